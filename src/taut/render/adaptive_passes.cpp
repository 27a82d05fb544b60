#include "taut/render/adaptive_passes.h"

#include <map>

namespace taut {

namespace {

/// Blocks of adaptive sampling that one task traces.
constexpr std::size_t kBlocksATask = 8;

} // namespace

AdaptivePasses::AdaptivePasses(const Window &window, double noise, int most) : goal_(AdaptiveBlocks(window, noise, most)) {
    cut();
}

AdaptivePasses::AdaptivePasses(const Window &window, const PictureGoal &goal, int most, std::uint32_t seed)
    : goal_(PictureNoise(window, goal.noise, goal.firstSamples, most, seed)) {
    cut();
}

/// Blocks by themselves; where the noise of the picture is the goal, those with as much to do together: a tile, or a part of its row.
void AdaptivePasses::cut() {
    pieces_.clear();
    const auto *picture = std::get_if<PictureNoise>(&goal_);
    std::map<std::pair<int, int>, std::vector<Index>> tiles;
    std::visit(
        [&](const auto &goal) {
            for (const Index block : goal.active()) {
                const Window window = goal.windowOf(block);
                if (picture != nullptr)
                    tiles[{window.y0 / kTile, window.x0 / kTile}].push_back(block);
                else
                    pieces_.push_back({window, {block}, goal.lastOf(block)});
            }
        },
        goal_);
    for (const auto &[place, blocks] : tiles) cutTile(*picture, blocks);
}

void AdaptivePasses::cutTile(const PictureNoise &picture, const std::vector<Index> &blocks) {
    const auto isAlike = [&](Index a, Index b) {
        return picture.firstOf(a) == picture.firstOf(b) && picture.lastOf(a) == picture.lastOf(b);
    };
    const bool allAlike = std::all_of(blocks.begin(), blocks.end(), [&](Index block) { return isAlike(block, blocks.front()); });
    const std::size_t before = pieces_.size();
    int area = 0;
    for (const Index block : blocks) { // row by row
        const Window window = picture.windowOf(block);
        area += window.width() * window.height();
        PassPiece *last = pieces_.size() > before ? &pieces_.back() : nullptr;
        const bool joins =
            last != nullptr && last->window.y0 == window.y0 && last->window.x1 == window.x0 && isAlike(block, last->blocks.front());
        if (!joins) last = &pieces_.emplace_back(PassPiece{window, {}, picture.lastOf(block)});
        last->window.x1 = window.x1;
        last->blocks.push_back(block);
    }
    const Window first = picture.windowOf(blocks.front());
    const Window last = picture.windowOf(blocks.back());
    const Window whole{first.x0, first.y0, last.x1, last.y1};
    const bool within = std::all_of(blocks.begin(), blocks.end(), [&](Index block) { return whole.contains(picture.windowOf(block)); });
    if (!allAlike || !within || whole.width() * whole.height() != area) return;
    pieces_.resize(before);
    pieces_.push_back({whole, blocks, picture.lastOf(blocks.front())});
}

std::size_t AdaptivePasses::piecesATask() const {
    return !pieces_.empty() && pieces_.front().blocks.size() > 1 ? 1 : kBlocksATask;
}

void AdaptivePasses::make(const PassPiece &piece, const Film &film, PassScratch &scratch,
                          const std::function<double(const Window &, int, int)> &trace) {
    if (auto *blocks = std::get_if<AdaptiveBlocks>(&goal_))
        samplePass(*blocks, piece.blocks.front(), film, scratch.luminances, trace);
    else
        samplePass(std::get<PictureNoise>(goal_), piece.blocks, piece.window, film, scratch.colours, trace);
}

std::vector<PassPiece> AdaptivePasses::drawControls(const Film &film) {
    std::vector<PassPiece> pieces;
    auto *picture = std::get_if<PictureNoise>(&goal_);
    if (picture == nullptr) return pieces;
    if (film.sharedSums() != nullptr) picture->noteSquares(film);
    for (const Control &control : picture->drawControls())
        pieces.push_back({control.window, {control.block}, picture->errorOf(control.block).samples});
    return pieces;
}

void AdaptivePasses::decide(const Film &film, const std::vector<PassPiece> &controls, const std::vector<std::vector<double>> &again) {
    if (auto *picture = std::get_if<PictureNoise>(&goal_)) {
        std::vector<double> variances;
        std::vector<double> sums;
        for (std::size_t k = 0; k < controls.size(); ++k) {
            const auto &[window, blocks, last] = controls[k];
            ColourSums::fill(film, window, sums);
            variances.push_back(0.5 * squaredDifference(window, window, sums, 1.0 / last, again[k], 1.0 / last));
        }
        picture->decide(variances);
    } else {
        std::get<AdaptiveBlocks>(goal_).decide();
    }
    cut();
}

double AdaptivePasses::share() const {
    return std::visit([](const auto &goal) { return goal.done(); }, goal_);
}

std::optional<PictureNoiseReached> AdaptivePasses::reached() const {
    const auto *picture = std::get_if<PictureNoise>(&goal_);
    return picture != nullptr ? std::optional(picture->reached()) : std::nullopt;
}

void AdaptivePasses::save(std::ostream &out) const {
    std::visit([&](const auto &goal) { goal.save(out); }, goal_);
}

void AdaptivePasses::load(std::istream &in) {
    std::visit([&](auto &goal) { goal.load(in); }, goal_);
    cut();
}

} // namespace taut
