#pragma once
/// A tree over many lights, by which one is chosen from a point in logarithmic time after what it could send there: Conty Estevez and
/// Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (in place of the splitting: light_candidates.h); bounds of
/// the cosines as in Pharr, Jakob and Humphreys 2023, "Physically Based Rendering", section 12.6.3. It knows bounds of lights alone, not
/// lights.

#include "taut/base/instructions.h"
#include "taut/base/lanes.h"
#include "taut/scene/lights/light.h"

#include <limits>
#include <span>
#include <vector>

namespace taut {

/// Bounds of both.
LightBounds united(const LightBounds &a, const LightBounds &b);

/// 44 bytes: the cone in 16-bit numbers, rounded outwards.
struct LightNode {
    static constexpr std::uint16_t kLeaf = 1, kTwoSided = 2, kMet = 4;
    Vec3 lower{0}, upper{0};
    float power = 0;
    Index link = 0; ///< the leaf's light, else the first of two children side by side
    std::int16_t axis[3] = {0, 0, 0};
    std::int16_t cosSpread = 0, cosReach = 0;
    std::uint16_t flags = 0;

    [[nodiscard]] bool isLeaf() const { return (flags & kLeaf) != 0; }
};

/// A leaf of one light.
LightNode leafOf(const LightBounds &bounds, Index light);

struct LightTree {
    static constexpr std::uint64_t kNoPath = ~std::uint64_t{0};
    std::vector<LightNode> nodes;     ///< the root first; none where no light has power
    std::vector<std::uint64_t> paths; ///< [lights] from the root, the lowest bit first: 1 is the second child; kNoPath: not in the tree
};

/// Builds a tree over lights. Those without power, or not finite, are left out. O(n log n); the same for any number of threads.
LightTree buildLightTree(std::span<const LightBounds> lights);

/// What the choice knows of a node: its numbers as they are reckoned with.
struct LightBox {
    Vec3 lower, upper;
    Vec3 axis; ///< times 32767, as the cosines
    float power, cosSpread, cosReach;
    bool twoSided;

    LightBox() = default;
    explicit LightBox(const LightNode &node)
        : lower(node.lower), upper(node.upper), axis(node.axis[0], node.axis[1], node.axis[2]), power(node.power),
          cosSpread(node.cosSpread), cosReach(node.cosReach), twoSided((node.flags & LightNode::kTwoSided) != 0) {}
};

/// Light that what is below a node could cause at a receiver, up to a factor that all share. Zero only where nothing can arrive. Without
/// branches, for loops over many.
[[gnu::always_inline]] inline float importance(const LightBox &box, const Receiver &at) {
    constexpr float kUnit = 1.0F / 32767;
    const Vec3 centre = 0.5F * (box.lower + box.upper);
    const Vec3 half = box.upper - centre;
    const Vec3 away = at.position - centre;
    const float distance2 = glm::dot(away, away);
    const float radius2 = glm::dot(half, half);
    const bool inside = distance2 <= radius2;
    const float inverse2 = 1 / std::max(distance2, 1e-20F);
    const float inverse = std::sqrt(inverse2);
    // What rounding the axis does to its length and direction is in the spread.
    const float cosAxis = glm::dot(box.axis, away) * (kUnit * inverse);
    const float cosW = std::clamp(box.twoSided ? std::fabs(cosAxis) : cosAxis, -1.0F, 1.0F);
    const float cosSpread = box.cosSpread * kUnit;
    // The angle between light and axis, less the spread, less the angle under which the box is seen; none of them below zero.
    const float sines = std::sqrt((1 - cosW * cosW) * (1 - cosSpread * cosSpread));
    const float cosX = cosW >= cosSpread ? 1.0F : cosW * cosSpread + sines;
    const float sin2Box = radius2 * inverse2;
    const float cosBox = std::sqrt(std::max(1 - sin2Box, 0.0F));
    const float sinXBox = std::sqrt(std::max(1 - cosX * cosX, 0.0F) * sin2Box);
    const float cosine = cosX >= cosBox ? 1.0F : cosX * cosBox + sinXBox;
    const float lit = received(at, -away, inside ? 0.0F : inverse, half, inside ? 0.0F : sin2Box, inside ? -1.0F : cosBox);
    const float within = box.power / std::max(radius2, 1e-20F) * lit;
    const float beyond = box.power * std::max(cosine, 0.0F) * inverse2 * lit;
    return inside ? within : cosine > box.cosReach * kUnit ? beyond : 0.0F;
}
[[gnu::always_inline]] inline float importance(const LightNode &node, const Receiver &at) {
    return importance(LightBox(node), at);
}

/// Share of the first child in the choice between two; negative where nothing arrives from either.
[[gnu::always_inline]] inline float firstShare(const LightBox &first, const LightBox &second, const Receiver &at) {
    const float a = importance(first, at);
    const float total = a + importance(second, at);
    const float share = total < kInfinity ? a / total : 0.5F;
    return total > 0 ? share : -1.0F;
}

/// received() of a node's box.
inline float received(const Receiver &at, const LightNode &node) {
    const Vec3 centre = 0.5F * (node.lower + node.upper);
    const Vec3 half = node.upper - centre;
    const Vec3 towards = centre - at.position;
    const float inverse2 = 1 / glm::dot(towards, towards);
    const float sin2Box = glm::dot(half, half) * inverse2;
    if (!(sin2Box < 1)) return received(at, towards, 0, half, 0, -1);
    return received(at, towards, std::sqrt(inverse2), half, sin2Box, std::sqrt(1 - sin2Box));
}

/// Light that all of a tree could cause at a receiver together, up to a factor that all share.
inline float importance(const LightTree &tree, const Receiver &at) {
    return tree.nodes.empty() ? 0.0F : importance(tree.nodes.front(), at);
}

/// A light, and the probability with which it is chosen at a receiver; none where nothing can arrive.
struct LeafChoice {
    Index light = kNone;
    float probability = 0;
};
/// `choose` uniform in [0, 1).
LeafChoice chooseLeaf(const LightTree &tree, const Receiver &at, float choose);
/// Choices of many receivers at once.
template <class Choice> struct alignas(64) ChoiceLanes {
    static constexpr int kSize = 64;
    int count = 0;
    Lanes3<kSize> position, normal; ///< Receiver
    float choose[kSize];
    Choice chosen[kSize];

    void add(const Receiver &at, float number) {
        const auto i = static_cast<std::size_t>(count++);
        position.set(i, at.position);
        normal.set(i, at.normal);
        choose[i] = number;
    }
};

/// chooseLeaf() of all: the same bits.
using LeafChoices = ChoiceLanes<LeafChoice>;
void chooseLeaves(const LightTree &tree, LeafChoices &choices, Instructions instructions = widest());

/// Probability with which chooseLeaf() returns a light at a receiver: its way down from the root.
float leafProbability(const LightTree &tree, Index light, const Receiver &at);

/// Calls `meet(light, farthest)` for every light whose rays can meet it and whose box, grown by what rounding may move, the ray
/// enters before `farthest`. It returns what is farthest from then on.
template <class Meet>
[[gnu::noinline]] void visitMetBy(const LightTree &tree, const Vec3 &origin, const Vec3 &direction, float farthest, const Meet &meet) {
    if (tree.nodes.empty()) return;
    const auto inverseOf = [](float d) { return 1 / (std::fabs(d) > 1e-18F ? d : std::copysign(1e-18F, d)); };
    const Vec3 inverse(inverseOf(direction.x), inverseOf(direction.y), inverseOf(direction.z));
    const float slack = 4e-6F * std::max(std::fabs(origin.x), std::max(std::fabs(origin.y), std::fabs(origin.z)));
    const auto enters = [&](const LightNode &node) {
        if ((node.flags & LightNode::kMet) == 0) return false;
        const Vec3 a = (node.lower - slack - origin) * inverse;
        const Vec3 b = (node.upper + slack - origin) * inverse;
        const float from = std::max(std::max(std::min(a.x, b.x), std::min(a.y, b.y)), std::min(a.z, b.z));
        const float to = std::min(std::min(std::max(a.x, b.x), std::max(a.y, b.y)), std::max(a.z, b.z));
        constexpr float kRounding = 1e-5F;
        return from - kRounding * std::fabs(from) <= to + kRounding * std::fabs(to) && to >= 0 && from * (1 - kRounding) < farthest;
    };
    Index waiting[std::numeric_limits<std::uint64_t>::digits + 1];
    int count = 0;
    waiting[count++] = 0;
    while (count > 0) {
        const LightNode &node = tree.nodes[waiting[--count]];
        if (!enters(node)) continue;
        if (node.isLeaf()) {
            farthest = meet(node.link, farthest);
            continue;
        }
        waiting[count++] = node.link + 1;
        waiting[count++] = node.link;
    }
}

} // namespace taut
