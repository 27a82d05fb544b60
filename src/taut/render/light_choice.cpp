#include "taut/render/lights.h"

#include <array>

namespace taut {

namespace {

/// Share of the choice that is spread evenly over the lights.
constexpr float kEvenShare = 0.1F;

/// Light that an unoccluded light could cause at a receiver, up to a common factor. Zero only where it can send nothing.
float importance(const LightTable &table, const LightPart &part, const Receiver &at) {
    const LightEntry &entry = table.entries[part.entry];
    return std::visit(
        [&](const auto &light) {
            if constexpr (requires { light.bounds(1.0F); })
                return light.importance(luminance(entry.radiance), at) * received(at, table.fewParts[entry.firstPart]);
            else if constexpr (requires { light.importance(1.0F, at); })
                return light.importance(luminance(entry.radiance), at);
            else
                return importance(table.fewParts[entry.firstPart + part.triangle], at);
        },
        entry.shape);
}

/// Probability of a choice of importance `own` among `count` that have any, `total` together.
float probabilityOf(float own, float total, std::size_t count) {
    if (!(own > 0)) return 0;
    const float even = 1 / static_cast<float>(count);
    return total > 0 && std::isfinite(total) ? kEvenShare * even + (1 - kEvenShare) * own / total : even;
}

/// What is weighed one by one at a point: all there is where that is little, else the tree as one beside what reaches everywhere.
struct Choices {
    float total = 0;
    float tree = 0; ///< importance of the tree's lights together
    std::size_t count = 0;

    void add(float own) {
        total += own;
        count += own > 0 ? 1 : 0;
    }
};

/// Calls `weigh(part)` for all choices, until it returns true.
template <class Weigh> void eachOfFew(const LightTable &table, const Weigh &weigh) {
    for (Index entry = 0; entry < table.entries.size(); ++entry) {
        const Index triangles = partCount(table.entries[entry]);
        for (Index triangle = 0; triangle < triangles; ++triangle)
            if (weigh(LightPart{entry, triangle})) return;
    }
}

/// Importances of few choices, in the order of eachOfFew().
using FewImportances = std::array<float, kFewChoices>;

Choices choicesAt(const LightTable &table, const Receiver &at, FewImportances *few = nullptr) {
    Choices choices;
    if (table.few) {
        std::size_t count = 0;
        eachOfFew(table, [&](const LightPart &part) {
            const float own = importance(table, part, at);
            choices.add(own);
            if (few != nullptr) (*few)[count++] = own;
            return false;
        });
        return choices;
    }
    for (const Index entry : table.everywhere) choices.add(importance(table, {entry, 0}, at));
    choices.tree = importance(table.tree, at);
    choices.add(choices.tree);
    return choices;
}

/// Appends the bounds of a light's parts while the shutter is open; false where it reaches everywhere alike.
bool appendBounds(const LightEntry &entry, std::vector<LightBounds> &bounds) {
    const float strength = luminance(entry.radiance);
    return std::visit(
        [&](const auto &light) {
            if constexpr (std::is_same_v<decltype(light), const MeshEmitter &>) {
                for (Index triangle = 0; triangle < light.triangles.size(); ++triangle)
                    bounds.push_back(emitterBounds(light, triangle, strength));
                return true;
            } else if constexpr (requires { light.bounds(strength); }) {
                LightBounds one = light.bounds(strength);
                one.met = requires {
                    light.meet(Vec3(), Vec3(), 0.0F);
                };
                if (one.met) one.power = std::max(one.power, 1e-30F); // a black one may still be seen
                bounds.push_back(one);
                return true;
            } else {
                return false;
            }
        },
        entry.shape);
}

} // namespace

void prepareChoice(LightTable &table) {
    table.parts.clear();
    table.fewParts.clear();
    table.everywhere.clear();
    std::vector<LightBounds> bounds;
    for (Index i = 0; i < table.entries.size(); ++i) {
        const bool somewhere = appendBounds(table.entries[i], bounds);
        table.entries[i].firstPart = somewhere ? static_cast<Index>(table.parts.size()) : kNone;
        if (!somewhere) table.everywhere.push_back(i);
        for (Index triangle = 0; table.parts.size() < bounds.size(); ++triangle) table.parts.push_back({i, triangle});
    }
    table.choices = table.parts.size() + table.everywhere.size();
    table.few = table.choices <= kFewChoices;
    table.tree = {};
    if (!table.few) {
        table.tree = buildLightTree(bounds);
        return;
    }
    for (Index part = 0; part < bounds.size(); ++part) table.fewParts.push_back(leafOf(bounds[part], part));
}

float probabilityAmong(const LightTable &table, const LightPart &part, const Receiver &at) {
    const Index firstPart = table.entries[part.entry].firstPart;
    const bool inTree = !table.few && firstPart != kNone;
    const float below = inTree ? leafProbability(table.tree, firstPart + part.triangle, at) : 1.0F;
    if (inTree && table.everywhere.empty()) return below;
    const Choices choices = choicesAt(table, at);
    if (inTree && !(choices.tree > 0)) return 0;
    return below * probabilityOf(inTree ? choices.tree : importance(table, part, at), choices.total, choices.count);
}

namespace {

/// `descend(number, probability)`: the choice goes on in the tree, which is chosen with that probability.
template <class Descend> LightChoice chooseThen(const LightTable &table, const Receiver &at, float choose, const Descend &descend) {
    if (!table.few && table.everywhere.empty()) return descend(choose, 1.0F);
    FewImportances few;
    const Choices choices = choicesAt(table, at, &few);
    LightChoice chosen;
    float below = 0;
    // The last takes what rounding leaves over.
    const auto weigh = [&](const LightPart &part, float own) {
        if (!(own > 0)) return false;
        const float probability = probabilityOf(own, choices.total, choices.count);
        chosen = {part.entry, part.triangle, probability};
        if (choose < below + probability) return true;
        below += probability;
        return false;
    };
    if (table.few) {
        std::size_t count = 0;
        eachOfFew(table, [&](const LightPart &part) { return weigh(part, few[count++]); });
        return chosen;
    }
    for (const Index entry : table.everywhere)
        if (weigh({entry, 0}, importance(table, {entry, 0}, at))) return chosen;
    if (!(choices.tree > 0)) return chosen;
    const float probability = probabilityOf(choices.tree, choices.total, choices.count);
    return descend(std::clamp((choose - below) / probability, 0.0F, kOneMinusEpsilon), probability);
}

LightChoice choiceOf(const LightTable &table, const LeafChoice &leaf, float probability) {
    if (leaf.light == kNone) return {};
    const LightPart &part = table.parts[leaf.light];
    return {part.entry, part.triangle, probability * leaf.probability};
}

} // namespace

LightChoice chooseAmong(const LightTable &table, const Receiver &at, float choose) {
    return chooseThen(table, at, choose,
                      [&](float number, float probability) { return choiceOf(table, chooseLeaf(table.tree, at, number), probability); });
}

void chooseByTree(const LightTable &table, LightChoices &lanes, Instructions instructions) {
    LeafChoices descents;
    std::size_t owner[LeafChoices::kSize];
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes.count); ++i) {
        const Receiver at{lanes.position.at(i), lanes.normal.at(i)};
        lanes.chosen[i] = chooseThen(table, at, lanes.choose[i], [&](float number, float probability) {
            owner[descents.count] = i;
            descents.add(at, number);
            return LightChoice{kNone, 0, probability};
        });
    }
    if (descents.count == 0) return;
    chooseLeaves(table.tree, descents, instructions);
    for (std::size_t k = 0; k < static_cast<std::size_t>(descents.count); ++k) {
        LightChoice &chosen = lanes.chosen[owner[k]];
        chosen = choiceOf(table, descents.chosen[k], chosen.probability);
    }
}

} // namespace taut
