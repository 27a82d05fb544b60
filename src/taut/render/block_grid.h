#pragma once
/// The blocks of pixels that adaptive sampling decides about, in nine colours (adaptive.h).

#include "taut/base/vec.h"
#include "taut/render/window.h"

#include <array>
#include <optional>
#include <vector>

namespace taut {

/// The blocks of the frame's own grid that lie in a window, row by row. Colours stand in a repeated 3 x 3 pattern: a ring on which each
/// colour is followed by a neighbour, so a block has each of the eight other colours once among the eight blocks around it.
class BlockGrid {
  public:
    static constexpr int kSide = 4; ///< pixels
    static constexpr int kColours = 9;

    explicit BlockGrid(const Window &window);

    [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }
    [[nodiscard]] Window windowOf(Index block) const;
    [[nodiscard]] int colourOf(Index block) const { return colourAt(columnOf(block), rowOf(block)); }
    /// A block at a distance in blocks; none where it is outside of the window.
    [[nodiscard]] std::optional<Index> beside(Index block, int dx, int dy) const { return at(columnOf(block) + dx, rowOf(block) + dy); }
    /// The nearest blocks of the next colour, on either side.
    [[nodiscard]] std::array<std::optional<Index>, 2> nextOnRing(Index block) const;

    /// Colour of a block by its place in the frame, counted in blocks; and the way to the neighbour of the next colour.
    static int colourAt(int column, int row);
    static std::array<int, 2> towardsGuide(int column, int row);
    /// A way from a block to another, in blocks.
    struct Neighbour {
        int dx = 0, dy = 0;
    };
    /// Ways from a block of this colour to those at most `distance` away along each axis whose colours are the next `reach` on the ring,
    /// row by row.
    static std::vector<Neighbour> followers(int colour, int reach, int distance);

  private:
    [[nodiscard]] int columnOf(Index block) const { return firstColumn_ + static_cast<int>(block) % columns_; }
    [[nodiscard]] int rowOf(Index block) const { return firstRow_ + static_cast<int>(block) / columns_; }
    [[nodiscard]] std::optional<Index> at(int column, int row) const {
        column -= firstColumn_;
        row -= firstRow_;
        if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return std::nullopt;
        return static_cast<Index>(row) * static_cast<Index>(columns_) + static_cast<Index>(column);
    }

    Window window_;
    int columns_ = 0, rows_ = 0, firstColumn_ = 0, firstRow_ = 0;
};

} // namespace taut
