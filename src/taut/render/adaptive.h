#pragma once
/// How many samples each part of a frame gets where a noise level is asked for: adaptive sampling without bias.
///
/// A stopping rule that looks at the samples it then averages is biased: pixels that have missed their rare bright samples look
/// finished. Here no pixel has a say in its own number of samples. The frame is divided into blocks of 4 x 4 pixels, coloured with
/// nine colours in a repeated 3 x 3 pattern, a ring on which each colour is followed by a neighbour. After each pass a block goes on
/// or stops by the noise of its guides alone: the nearest blocks of the next colour on either side. How many samples a guide had is
/// the doing of its own guides, one colour further, so after k decisions a block's number of samples depends on the k colours that
/// follow its own. With at most eight decisions the ring never closes: the number of samples is independent of the block's own
/// samples (pixels have independent random numbers), and the mean of all of them is unbiased.
///
/// Decisions follow from sums alone, so the same seed gives the same bits for any number of threads.

#include "taut/render/block_grid.h"
#include "taut/render/film.h"

#include <array>
#include <iosfwd>

namespace taut {

/// What is known of a block's noise after a pass.
struct BlockNoise {
    double variance = 0;  ///< of the mean luminance of a pixel after `samples`, averaged over the block
    double luminance = 0; ///< mean over the block
    int samples = 0;
};

class AdaptiveBlocks {
  public:
    static constexpr int kPilot = 16; ///< samples of the first pass
    static constexpr int kDecisions = BlockGrid::kColours - 1;

    /// Samples the pixels of `window` until the standard error of a pixel's luminance is `noise` times the luminance around it (but
    /// at least a tenth of the mean over the blocks asked), or `most` samples a pixel are reached.
    AdaptiveBlocks(const Window &window, double noise, int most);

    /// The pass to be made: samples [first, last) of every pixel of the active blocks. None are active when all is done.
    [[nodiscard]] int first() const { return first_; }
    [[nodiscard]] int last() const { return last_; }
    [[nodiscard]] int firstOf(Index) const { return first_; }
    [[nodiscard]] int lastOf(Index) const { return last_; }
    [[nodiscard]] int most() const { return most_; }
    [[nodiscard]] const std::vector<Index> &active() const { return active_; }
    [[nodiscard]] Window windowOf(Index block) const { return grid_.windowOf(block); }

    /// What the pass found; from any thread, once for every active block.
    void report(Index block, const BlockNoise &noise) { noise_[block] = noise; }
    /// After the pass: who goes on.
    void decide();

    /// What has been decided and found so far, to go on elsewhere. load() throws InputError where that is damaged or of another frame.
    void save(std::ostream &out) const;
    void load(std::istream &in);

    /// Share of the work that is surely done, for progress.
    [[nodiscard]] double done() const;

  private:
    [[nodiscard]] bool isQuiet(Index block) const;

    BlockGrid grid_;
    double level_;
    int most_;
    double growth_; // samples after a pass over those before
    int first_ = 0, last_ = 0;
    int decisions_ = 0;
    std::array<double, BlockGrid::kColours> floor_{}; // a tenth of the mean luminance of the blocks of each colour after the first pass
    std::vector<BlockNoise> noise_;        // [blocks]
    std::vector<Index> active_;
};

/// The noise of a block from the luminance sums of its pixels after `before` and `after` samples: both parts estimate the same mean,
/// so their difference tells the variance of either. Points that stratify each other make it an overestimate.
BlockNoise noiseOf(const std::vector<double> &sumsBefore, int before, const std::vector<double> &sumsAfter, int after);

/// Luminance sums of a block's pixels, row by row.
struct BlockScratch {
    std::vector<double> before, after;
    static void fill(const Film &film, const Window &block, std::vector<double> &sums);
};

/// Makes the pass over one block and reports what it found. trace(window, first, last) adds these samples to the film.
template <class Trace> void samplePass(AdaptiveBlocks &blocks, Index block, const Film &film, BlockScratch &scratch, const Trace &trace) {
    const Window window = blocks.windowOf(block);
    const int last = blocks.last();
    if (last >= blocks.most()) { // nothing is left to decide
        trace(window, blocks.first(), last);
        return;
    }
    // Where the samples are split into two estimates of the same: those of earlier passes, or half of the first.
    const int middle = blocks.first() > 0 ? blocks.first() : last / 2;
    if (blocks.first() < middle) trace(window, blocks.first(), middle);
    BlockScratch::fill(film, window, scratch.before);
    trace(window, middle, last);
    BlockScratch::fill(film, window, scratch.after);
    blocks.report(block, noiseOf(scratch.before, middle, scratch.after, last));
}

} // namespace taut
