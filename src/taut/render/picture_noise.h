#pragma once
/// How many samples each part of a frame gets so that the noise of the whole picture comes down to a level, at least cost.
///
/// The measure is the picture's relative error, sqrt(mean (I - R)^2 / mean R^2), means over pixels and R, G, B. Where the variance of a
/// block's pixels after n samples is v n^-p, and a sample costs c, the cheapest picture of a given noise has the n that make
/// v n^-p + lambda c n least: Neyman's allocation (1934), for p = 1. Points that stratify each other have p above 1, and do so at powers of
/// two and, less, at three times those (Sobol 1967); so n is one of these.
///
/// The halves of a block's samples tell v only up to a factor, since they stratify each other: a usual one of the number of samples, times
/// one of the scene. That is measured: parts of some blocks are rendered a second time with other random numbers (controls), and go on as
/// their blocks do. Half the squared difference from the picture estimates its variance, without bias where pixels do not share; the ratio
/// to what halves tell there, each over its chance to be drawn (Hansen & Hurwitz 1943), is the scene's.
///
/// As in adaptive.h no block has a say in its own number of samples. After a pass a block looks at those around it of the colours that
/// follow its own, `kReach` of them; what those have is the doing of their followers. The steps together stay below the nine colours
/// of the ring, so a block's number of samples does not depend on its own samples, but for lambda and the factor, two numbers of the whole
/// picture. Decisions that reach nobody keep what was seen before, and change lambda alone. All follows from sums and counts of rays: the
/// same seed gives the same bits for any number of threads.

#include "taut/render/block_grid.h"
#include "taut/render/film.h"

#include <algorithm>
#include <array>
#include <iosfwd>
#include <optional>
#include <span>
#include <vector>

namespace taut {

/// The next number of samples that stratify each other well: 1, 2, 3, 4, 6, 8, 12, 16, ...
int nextSampleCount(int samples);
/// The exponent p of points whose halves, taken for independent, tell `factor` times less variance than there is: the
/// variance of n points falls by the n-th part of D of the halves each time that n doubles, D falls with it, and the sum of all that is
/// left to come is factor = 1 / (2^p - 1). In [1, 2].
double exponentOf(double factor);

/// Variance of so many samples over what their halves tell as if they were independent, usually: the mean over the scenes of `taut chart
/// plan`, whose pixels share.
double usualFactor(int samples);

/// What samples cost, by their rays: in units of a camera ray that meets nothing. A scattered or a shadow ray takes six times as long, with
/// the shading that it comes from.
inline double costOf(std::uint64_t camera, std::uint64_t others) {
    return static_cast<double>(camera) + 6 * static_cast<double>(others);
}

/// What is known of a block after a pass.
struct BlockError {
    int samples = 0;     ///< a pixel
    double variance = 0; ///< that so many samples bring to the picture, over pixels and R, G, B, as if the halves were independent
    double spread = 0;   ///< variance of that number, by what the block's pixels differ in it
    double square = 0;   ///< of the mean, over pixels and R, G, B
    double cost = 0;     ///< of a sample (costOf)
};

/// A part of a block that is rendered again.
struct Control {
    Index block = 0;
    Window window;
    double chance = 1; ///< to be drawn, relative to the others'
};

/// What a picture has reached.
struct PictureNoiseReached {
    double error = 0;    ///< relative RMS, of the noise alone
    double spread = 0;   ///< standard error of that
    int controls = 0;    ///< parts of blocks that were rendered twice to know it; 0: it is what halves tell
    double exponent = 1; ///< p
};

class PictureNoise {
  public:
    /// Steps on the ring of each decision: the first goes part of the way to the numbers that seem right, the second to them, the others
    /// do what is missing still.
    static constexpr std::array<int, 4> kReach{2, 6, 0, 0};
    /// The least that the variance may be of what halves usually tell.
    static constexpr double kLeastFactor = 0.5;

    /// Samples the pixels of `window` until the noise of the picture is `level`, or `most` samples a pixel are reached. `first`: samples of
    /// the first pass, at least 2. `seed`: of the drawing of controls.
    PictureNoise(const Window &window, double level, int first, int most, std::uint32_t seed);

    [[nodiscard]] const std::vector<Index> &active() const { return active_; }
    [[nodiscard]] Window windowOf(Index block) const { return grid_.windowOf(block); }
    /// The pass to be made: samples [firstOf, lastOf) of an active block.
    [[nodiscard]] int firstOf(Index block) const { return errors_[block].samples; }
    [[nodiscard]] int lastOf(Index block) const { return targets_[block]; }
    /// What the pass found; from any thread, once for every active block.
    void report(Index block, const BlockError &error) { errors_[block] = error; }
    [[nodiscard]] const BlockError &errorOf(Index block) const { return errors_[block]; }
    /// Squares of the picture as it stands, where pixels share their samples: they depend on what blocks give to each other.
    void noteSquares(const Film &film);

    /// After the pass: what is to be rendered with other random numbers, and as many samples as its block has. None where the noise is far
    /// from the level for sure; from then on that there are some they are the same ones. A part may stand there more than once.
    const std::vector<Control> &drawControls();
    /// What came of them: half the mean square of the differences from the picture, for each. Then who goes on.
    void decide(const std::vector<double> &variances);

    [[nodiscard]] const PictureNoiseReached &reached() const { return reached_; }
    /// Share of the work that is done, for progress.
    [[nodiscard]] double done() const;

    /// What has been decided and found so far, to go on elsewhere. load() throws InputError where that is damaged or of another frame.
    void save(std::ostream &out) const;
    void load(std::istream &in);

  private:
    struct Guide {
        double variance = 0; ///< v: of one sample
        double cost = 0;     ///< of one sample
    };
    struct Allocation {
        std::vector<int> samples; ///< [blocks]
        double cost = 0;
    };
    [[nodiscard]] std::vector<Guide> guidesOf(int reach) const;
    [[nodiscard]] Allocation cheapest(const std::vector<Guide> &choosing, double noiseWanted) const;
    [[nodiscard]] Window partOf(Index block, std::uint32_t random) const;
    /// What halves tell of a block's variance, by what is usual for as many samples.
    [[nodiscard]] double usualOf(Index block) const { return usualFactor(errors_[block].samples) * errors_[block].variance; }
    /// Sum of that over pixels.
    [[nodiscard]] double told() const;
    /// Around each block: the mean over it and its neighbours.
    [[nodiscard]] std::vector<double> toldAround() const;
    void measure(const std::vector<double> &variances);
    /// p, of the picture as it stands.
    [[nodiscard]] double exponent() const;
    /// Pixels of a block: what its means weigh.
    [[nodiscard]] double weightOf(Index block) const;
    /// v of each block, by its own halves.
    [[nodiscard]] std::vector<double> variancesOfOne() const;
    [[nodiscard]] double squares() const;
    [[nodiscard]] double aim() const;

    BlockGrid grid_;
    double level_;
    int most_;
    std::uint32_t seed_;
    std::size_t decisions_ = 0;
    double factor_ = 1; // variance over what halves usually tell
    PictureNoiseReached reached_;
    std::vector<Guide> guides_; // [blocks], of the last decision that reached somebody
    std::vector<Control> controls_;
    std::vector<BlockError> errors_; // [blocks]
    std::vector<int> targets_;       // [blocks] samples after the pass to be made
    std::vector<Index> active_;
};

/// Sums of the pixels of a window, row by row: of R, G and B, or, where pixels share their samples, of what each gives to the nine around
/// it.
struct ColourSums {
    std::vector<double> half, all;
    static void fill(const Film &film, const Window &window, std::vector<double> &sums);
};

/// Mean over a part of a window's pixels and R, G, B of the square of what s1 first - s2 second brings to the picture, of their sums.
/// Pixels have random numbers of their own, so what they give to each other adds up in squares.
double squaredDifference(const Window &part, const Window &window, std::span<const double> first, double s1, std::span<const double> second,
                         double s2);

/// What the sums of a window say of a block in it, after `middle` and after `last` samples.
BlockError blockErrorOf(const Window &block, const Window &window, const ColourSums &sums, int middle, int last);

/// Makes the pass over blocks that fill a window and have as many samples to make, and reports what it found. trace(window, first, last)
/// adds these samples to the film and returns what they cost.
template <class Trace>
void samplePass(PictureNoise &picture, std::span<const Index> blocks, const Window &window, const Film &film, ColourSums &sums,
                const Trace &trace) {
    const int first = picture.firstOf(blocks.front());
    const int last = picture.lastOf(blocks.front());
    const int middle = std::max(first, last / 2); // where the samples are split into two estimates of the same
    double cost = 0;
    const auto add = [&](int from, int to, std::vector<double> &into) {
        if (from < to) cost += static_cast<double>(trace(window, from, to)) / (window.width() * window.height());
        ColourSums::fill(film, window, into);
    };
    add(first, middle, sums.half);
    add(middle, last, sums.all);
    for (const Index block : blocks) {
        BlockError found = blockErrorOf(picture.windowOf(block), window, sums, middle, last);
        found.cost = (picture.errorOf(block).cost * first + cost) / last;
        picture.report(block, found);
    }
}

} // namespace taut
