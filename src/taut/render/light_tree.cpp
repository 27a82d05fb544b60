#include "taut/render/light_tree.h"

#include <tbb/parallel_invoke.h>

#include <array>
#include <bit>

namespace taut {

namespace {

constexpr int kBins = 12;
/// Subtrees of more lights are built side by side.
constexpr std::size_t kWorthATask = 4096;

// --- cones -----------------------------------------------------------------------------------------------------------

struct Cone {
    Vec3 axis{0, 0, 1};
    float cosSpread = 1;
};

/// A cone around both, as narrow as goes about an axis between theirs (Conty Estevez and Kulla 2018, algorithm 1).
Cone unitedCones(const Cone &a, const Cone &b) {
    if (a.cosSpread > b.cosSpread) return unitedCones(b, a);
    const float spreadA = std::acos(a.cosSpread); // the wider one
    const float spreadB = std::acos(b.cosSpread);
    // Accurate for small angles and those near pi (Kahan).
    const float between = 2 * std::atan2(glm::length(a.axis - b.axis), glm::length(a.axis + b.axis));
    if (std::min(between + spreadB, kPi) <= spreadA) return a;
    const float spread = 0.5F * (spreadA + between + spreadB);
    if (spread >= kPi) return {a.axis, -1};
    const float sine = std::sin(between);
    if (!(sine > 1e-6F)) return {a.axis, std::cos(std::min(spreadA + between + spreadB, kPi))};
    const float turn = spread - spreadA;
    const Vec3 axis = (std::sin(between - turn) * a.axis + std::sin(turn) * b.axis) / sine;
    return {glm::normalize(axis), std::cos(spread)};
}

/// Rounded down, and by one more: what rounding the axis can turn it by.
std::int16_t cosineDown(float cosine) {
    return static_cast<std::int16_t>(std::max(-32767.0F, std::floor(cosine * 32767) - 1));
}

LightNode toNode(const LightBounds &bounds, Index link, bool leaf) {
    LightNode node;
    node.lower = bounds.lower;
    node.upper = bounds.upper;
    node.power = bounds.power;
    node.link = link;
    for (int k = 0; k < 3; ++k) node.axis[k] = static_cast<std::int16_t>(std::lround(bounds.axis[k] * 32767));
    node.cosSpread = cosineDown(bounds.cosSpread);
    node.cosReach = cosineDown(bounds.cosReach);
    node.flags = static_cast<std::uint16_t>((leaf ? LightNode::kLeaf : 0) | (bounds.twoSided ? LightNode::kTwoSided : 0) |
                                            (bounds.met ? LightNode::kMet : 0));
    return node;
}

// --- where to split --------------------------------------------------------------------------------------------------

/// Lights of one side of a split. Their cone is estimated from the length of the mean axis, (1 + cos spread)/2 for axes that fill a
/// cap evenly: sums are all it takes.
struct Side {
    Vec3 lower{kInfinity}, upper{-kInfinity};
    Vec3 axis{0};
    float power = 0;
    std::size_t count = 0;

    void add(const LightBounds &light) {
        lower = glm::min(lower, light.lower);
        upper = glm::max(upper, light.upper);
        axis += light.axis * (light.power * 0.5F * (1 + light.cosSpread));
        power += light.power;
        ++count;
    }
    void add(const Side &side) {
        lower = glm::min(lower, side.lower);
        upper = glm::max(upper, side.upper);
        axis += side.axis;
        power += side.power;
        count += side.count;
    }
    /// Power x area x solid angle (Conty Estevez and Kulla 2018, section 4.4). The angle's measure is a parabola through its values
    /// for spreads of 0, pi/2 and pi with a reach of pi/2; a hundredth of the diagonal's square stands for the area of a flat
    /// row of lights.
    [[nodiscard]] float cost() const {
        const float c = std::min(2 * glm::length(axis) / std::max(power, 1e-30F), 2.0F) - 1;
        const Vec3 d = upper - lower;
        const float area = d.x * d.y + d.y * d.z + d.z * d.x + 0.01F * glm::dot(d, d);
        return power * area * (11.2F - 4.71F * c - 3.36F * c * c);
    }
};

struct Split {
    int axis = -1;
    int bin = 0; ///< the first on the second side
    float cost = kInfinity;
};

/// Bin of a light's centre between the outermost centres, along an axis.
int binOf(const LightBounds &light, int axis, float from, float scale) {
    const float at = (0.5F * (light.lower[axis] + light.upper[axis]) - from) * scale;
    return std::clamp(static_cast<int>(at), 0, kBins - 1);
}

void tryAxis(std::span<const LightBounds> lights, std::span<const Index> order, int axis, float from, float scale, float regularity,
             Split &best) {
    std::array<Side, kBins> bins;
    for (const Index i : order) bins[static_cast<std::size_t>(binOf(lights[i], axis, from, scale))].add(lights[i]);
    std::array<float, kBins> above{}; // cost of this bin and all after it
    Side side;
    for (std::size_t bin = kBins - 1; bin > 0; --bin) {
        side.add(bins[bin]);
        above[bin] = side.count > 0 ? side.cost() : kInfinity;
    }
    side = {};
    for (std::size_t bin = 1; bin < kBins; ++bin) {
        side.add(bins[bin - 1]);
        if (side.count == 0) continue;
        const float cost = regularity * (side.cost() + above[bin]);
        if (cost < best.cost) best = {axis, static_cast<int>(bin), cost};
    }
}

/// Sorts `order` into two sides; how many the first has.
std::size_t partition(std::span<const LightBounds> lights, std::span<Index> order, bool balanced) {
    Vec3 lower(kInfinity);
    Vec3 upper(-kInfinity);
    for (const Index i : order) {
        const Vec3 centre = 0.5F * (lights[i].lower + lights[i].upper);
        lower = glm::min(lower, centre);
        upper = glm::max(upper, centre);
    }
    const Vec3 extent = upper - lower;
    const float longest = maxComponent(extent);
    if (order.size() == 2 || !(longest > 0) || balanced) return order.size() / 2;
    Split best;
    const auto scaleOf = [&](int axis) { return kBins / extent[axis]; };
    for (int axis = 0; axis < 3; ++axis)
        if (extent[axis] > 1e-6F * longest) tryAxis(lights, order, axis, lower[axis], scaleOf(axis), longest / extent[axis], best);
    if (best.axis < 0) return order.size() / 2;
    const auto middle = std::stable_partition(
        order.begin(), order.end(), [&](Index i) { return binOf(lights[i], best.axis, lower[best.axis], scaleOf(best.axis)) < best.bin; });
    return static_cast<std::size_t>(middle - order.begin());
}

// --- the tree --------------------------------------------------------------------------------------------------------

struct Builder {
    std::span<const LightBounds> lights;
    LightTree &tree;

    /// Builds what is below and at `place`; the nodes below go to `below` and on: two fewer than twice the lights.
    LightBounds build(std::span<Index> order, Index place, Index below, int depth, std::uint64_t path) {
        if (order.size() == 1) {
            const Index light = order[0];
            tree.paths[light] = path;
            tree.nodes[place] = leafOf(lights[light], light);
            return lights[light];
        }
        // Paths have 64 bits: from where halves alone still fit, halves.
        const int levelsOfHalves = std::bit_width(order.size() - 1);
        const bool balanced = depth + levelsOfHalves >= std::numeric_limits<std::uint64_t>::digits - 2;
        const std::size_t first = partition(lights, order, balanced);
        LightBounds a;
        LightBounds b;
        const auto buildFirst = [&] { a = build(order.first(first), below, below + 2, depth + 1, path); };
        const auto buildSecond = [&] {
            b = build(order.subspan(first), below + 1, below + static_cast<Index>(2 * first), depth + 1, path | std::uint64_t{1} << depth);
        };
        if (order.size() > kWorthATask) {
            tbb::parallel_invoke(buildFirst, buildSecond);
        } else {
            buildFirst();
            buildSecond();
        }
        const LightBounds all = united(a, b);
        tree.nodes[place] = toNode(all, below, false);
        return all;
    }
};

float firstShare(const LightTree &tree, const LightNode &node, const Receiver &at) {
    return firstShare(LightBox(tree.nodes[node.link]), LightBox(tree.nodes[node.link + 1]), at);
}

} // namespace

LightBounds united(const LightBounds &a, const LightBounds &b) {
    if (!(a.power > 0)) return b;
    if (!(b.power > 0)) return a;
    LightBounds all;
    all.lower = glm::min(a.lower, b.lower);
    all.upper = glm::max(a.upper, b.upper);
    all.twoSided = a.twoSided || b.twoSided;
    // About both ways of an axis is about both ways of its opposite.
    const bool turned = all.twoSided && glm::dot(a.axis, b.axis) < 0;
    const Cone cone = unitedCones({a.axis, a.cosSpread}, {turned ? -b.axis : b.axis, b.cosSpread});
    all.axis = cone.axis;
    all.cosSpread = cone.cosSpread;
    all.cosReach = std::min(a.cosReach, b.cosReach);
    all.power = a.power + b.power;
    all.met = a.met || b.met;
    return all;
}

LightNode leafOf(const LightBounds &bounds, Index light) {
    return toNode(bounds, light, true);
}

LightTree buildLightTree(std::span<const LightBounds> lights) {
    LightTree tree;
    tree.paths.assign(lights.size(), LightTree::kNoPath);
    std::vector<Index> order;
    for (Index i = 0; i < lights.size(); ++i)
        if (lights[i].power > 0 && std::isfinite(lights[i].power) && isFinite(lights[i].lower) && isFinite(lights[i].upper))
            order.push_back(i);
    if (order.empty()) return tree;
    tree.nodes.resize(2 * order.size() - 1);
    Builder{lights, tree}.build(order, 0, 1, 0, 0);
    return tree;
}

LeafChoice chooseLeaf(const LightTree &tree, const Receiver &at, float choose) {
    if (tree.nodes.empty()) return {};
    const LightNode *node = tree.nodes.data();
    float probability = 1;
    while (!node->isLeaf()) {
        const float first = firstShare(tree, *node, at);
        if (first < 0) return {};
        const bool second = choose >= first;
        const float share = second ? 1 - first : first;
        choose = std::min((second ? choose - first : choose) / share, kOneMinusEpsilon);
        probability *= share;
        node = &tree.nodes[node->link + (second ? 1 : 0)];
    }
    return {node->link, probability};
}

float leafProbability(const LightTree &tree, Index light, const Receiver &at) {
    std::uint64_t path = tree.paths[light];
    if (path == LightTree::kNoPath) return 0;
    const LightNode *node = tree.nodes.data();
    float probability = 1;
    for (; !node->isLeaf() && probability > 0; path >>= 1) {
        const float first = firstShare(tree, *node, at);
        if (first < 0) return 0;
        const bool second = (path & 1) != 0;
        probability *= second ? 1 - first : first;
        node = &tree.nodes[node->link + (second ? 1 : 0)];
    }
    return probability;
}

} // namespace taut
