#include "taut/render/block_grid.h"

#include <algorithm>

namespace taut {

namespace {

/// The ring through the pattern: colour by row and column, and the step from each colour to the next (the pattern repeats, so that
/// a step out of it leads into the next copy).
constexpr std::array<std::array<int, 3>, 3> kPattern{{{0, 1, 2}, {4, 5, 3}, {8, 6, 7}}};
constexpr std::array<std::array<int, 2>, BlockGrid::kColours> kSteps{
    {{1, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}}};

int modulo3(int i) {
    return ((i % 3) + 3) % 3;
}

} // namespace

BlockGrid::BlockGrid(const Window &window) : window_(window), firstColumn_(window.x0 / kSide), firstRow_(window.y0 / kSide) {
    columns_ = (window.x1 - 1) / kSide - firstColumn_ + 1;
    rows_ = (window.y1 - 1) / kSide - firstRow_ + 1;
}

Window BlockGrid::windowOf(Index block) const {
    const int column = columnOf(block);
    const int row = rowOf(block);
    return {std::max(window_.x0, column * kSide), std::max(window_.y0, row * kSide), std::min(window_.x1, (column + 1) * kSide),
            std::min(window_.y1, (row + 1) * kSide)};
}

int BlockGrid::colourAt(int column, int row) {
    return kPattern[static_cast<std::size_t>(modulo3(row))][static_cast<std::size_t>(modulo3(column))];
}

std::array<int, 2> BlockGrid::towardsGuide(int column, int row) {
    return kSteps[static_cast<std::size_t>(colourAt(column, row))];
}

std::vector<BlockGrid::Neighbour> BlockGrid::followers(int colour, int reach, int distance) {
    int column = 0;
    int row = 0;
    while (colourAt(column, row) != colour) {
        column = (column + 1) % 3;
        if (column == 0) ++row;
    }
    std::vector<Neighbour> ways;
    for (int dy = -distance; dy <= distance; ++dy)
        for (int dx = -distance; dx <= distance; ++dx) {
            const int steps = (colourAt(column + dx, row + dy) - colour + kColours) % kColours;
            if (steps >= 1 && steps <= reach) ways.push_back({dx, dy});
        }
    return ways;
}

std::array<std::optional<Index>, 2> BlockGrid::nextOnRing(Index block) const {
    const int column = columnOf(block);
    const int row = rowOf(block);
    const auto [dx, dy] = towardsGuide(column, row);
    return {at(column + dx, row + dy), at(column - 2 * dx, row - 2 * dy)}; // the pattern repeats every three blocks
}

} // namespace taut
