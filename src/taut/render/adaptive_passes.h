#pragma once
/// Adaptive sampling as a frame makes it: passes over pieces of its window, whichever goal decides about them.

#include "taut/render/adaptive.h"
#include "taut/render/picture_noise.h"

#include <functional>
#include <optional>
#include <variant>

namespace taut {

/// Adaptive sampling to the noise of the whole picture (picture_noise.h).
struct PictureGoal {
    double noise = 0.01;  ///< relative RMS
    int firstSamples = 4; ///< a pixel, of the first pass
    bool operator==(const PictureGoal &) const = default;
};

/// Pixels whose samples of a pass are traced together. A piece lies in one tile.
struct PassPiece {
    Window window;
    std::vector<Index> blocks; ///< that fill it
    int last = 0;              ///< samples a pixel after the pass
};

/// Working memory of one thread.
struct PassScratch {
    BlockScratch luminances;
    ColourSums colours;
};

class AdaptivePasses {
  public:
    /// Side of the tiles in pixels, a multiple of that of any block.
    static constexpr int kTile = 16;

    /// To a noise level of every pixel.
    AdaptivePasses(const Window &window, double noise, int most);
    /// To the noise of the picture.
    AdaptivePasses(const Window &window, const PictureGoal &goal, int most, std::uint32_t seed);

    /// Of the pass to be made; none when all is done.
    [[nodiscard]] const std::vector<PassPiece> &pieces() const { return pieces_; }
    /// Pieces that one task does well to take.
    [[nodiscard]] std::size_t piecesATask() const;
    /// Makes a piece. trace(window, first, last) adds samples [first, last) of its pixels to the film and returns what they cost.
    /// From any thread, once for each piece.
    void make(const PassPiece &piece, const Film &film, PassScratch &scratch, const std::function<double(const Window &, int, int)> &trace);
    /// When all pieces are made: windows to be rendered again with other random numbers, and as many samples. Once there are some, they are
    /// the same ones after every pass.
    std::vector<PassPiece> drawControls(const Film &film);
    /// Then what is next. `again`: the sums of each of those windows (ColourSums).
    void decide(const Film &film, const std::vector<PassPiece> &controls, const std::vector<std::vector<double>> &again);

    /// Share of the work that is done, for progress.
    [[nodiscard]] double share() const;
    /// Where the noise of the picture is the goal.
    [[nodiscard]] std::optional<PictureNoiseReached> reached() const;

    void save(std::ostream &out) const;
    /// Throws InputError where what save() wrote is damaged or of another frame.
    void load(std::istream &in);

  private:
    void cut();
    void cutTile(const PictureNoise &picture, const std::vector<Index> &blocks);

    std::variant<AdaptiveBlocks, PictureNoise> goal_;
    std::vector<PassPiece> pieces_;
};

} // namespace taut
