#include "taut/render/light_tree.h"

namespace taut {

namespace {

constexpr int kSize = LeafChoices::kSize;
/// Descents are worked on in whole vectors.
constexpr int kStep = 16;

struct Boxes {
    Lanes3<kSize> lower, upper, axis;
    float power[kSize], cosSpread[kSize], cosReach[kSize];
    int twoSided[kSize];

    void set(std::size_t i, const LightNode &node) {
        const LightBox box(node);
        lower.set(i, box.lower);
        upper.set(i, box.upper);
        axis.set(i, box.axis);
        power[i] = box.power;
        cosSpread[i] = box.cosSpread;
        cosReach[i] = box.cosReach;
        twoSided[i] = box.twoSided ? 1 : 0;
    }
    [[nodiscard, gnu::always_inline]] LightBox at(std::size_t i) const {
        LightBox box;
        box.lower = lower.at(i);
        box.upper = upper.at(i);
        box.axis = axis.at(i);
        box.power = power[i];
        box.cosSpread = cosSpread[i];
        box.cosReach = cosReach[i];
        box.twoSided = twoSided[i] != 0;
        return box;
    }
};

/// Those that are still on their way, side by side.
struct alignas(64) Descents {
    int count = 0;
    Lanes3<kSize> position, normal;
    float choose[kSize], probability[kSize];
    const LightNode *node[kSize];
    std::size_t owner[kSize]; ///< in LeafChoices
    Boxes first, second;      ///< children of `node`
    int goes[kSize];          ///< to which of them; -1: nowhere

    /// The last takes the place of one that has arrived.
    void remove(std::size_t i) {
        const auto last = static_cast<std::size_t>(--count);
        position.set(i, position.at(last));
        normal.set(i, normal.at(last));
        choose[i] = choose[last];
        probability[i] = probability[last];
        node[i] = node[last];
        owner[i] = owner[last];
    }
};

[[gnu::always_inline]] inline void stepLoop(Descents &d) {
    const int count = (d.count + kStep - 1) / kStep * kStep;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Receiver at{d.position.at(i), d.normal.at(i)};
        const float first = firstShare(d.first.at(i), d.second.at(i), at);
        const bool second = d.choose[i] >= first;
        const float share = second ? 1 - first : first;
        const float rest = second ? d.choose[i] - first : d.choose[i];
        d.choose[i] = std::min(rest / share, kOneMinusEpsilon);
        d.probability[i] *= share;
        const int side = second ? 1 : 0;
        d.goes[i] = first < 0 ? -1 : side;
    }
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void step(Descents &d) { stepLoop(d); }                                                        \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

void chooseLeaves(const LightTree &tree, LeafChoices &choices, Instructions instructions) {
    const auto all = static_cast<std::size_t>(choices.count);
    std::fill_n(choices.chosen, all, LeafChoice{});
    if (tree.nodes.empty()) return;
    Descents d;
    d.count = choices.count;
    d.position = choices.position;
    d.normal = choices.normal;
    std::copy_n(choices.choose, all, d.choose);
    std::fill_n(d.probability, all, 1.0F);
    std::fill_n(d.node, all, tree.nodes.data());
    for (std::size_t i = 0; i < all; ++i) d.owner[i] = i;
    while (true) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(d.count);) {
            const LightNode &node = *d.node[i];
            if (!node.isLeaf()) {
                d.first.set(i, tree.nodes[node.link]);
                d.second.set(i, tree.nodes[node.link + 1]);
                ++i;
                continue;
            }
            choices.chosen[d.owner[i]] = {node.link, d.probability[i]};
            d.remove(i);
        }
        if (d.count == 0) return;
        onInstructions(instructions, [&](auto loops) { decltype(loops)::step(d); });
        for (std::size_t i = static_cast<std::size_t>(d.count); i-- > 0;) {
            if (d.goes[i] < 0)
                d.remove(i);
            else
                d.node[i] = &tree.nodes[d.node[i]->link + static_cast<Index>(d.goes[i])];
        }
    }
}

} // namespace taut
