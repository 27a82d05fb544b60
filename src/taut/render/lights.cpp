#include "taut/render/lights.h"

#include "taut/base/frame.h"
#include "taut/base/warp.h"
#include "taut/render/light_bounds.h"

#include <algorithm>

namespace taut {

namespace {

/// Share of the choice that is spread evenly over the lights.
constexpr float kEvenShare = 0.1F;

/// Irradiance that an unoccluded light could cause at a point, up to a common factor and the receiver's cosine. Zero only where
/// the light can send nothing.
float importance(const LightTable &table, const LightPart &part, const Vec3 &point) {
    const LightEntry &entry = table.entries[part.entry];
    const float strength = luminance(entry.radiance);
    const auto overDistance2 = [&](const Vec3 &from) {
        const Vec3 d = from - point;
        return 1 / std::max(glm::dot(d, d), 1e-20F);
    };
    switch (entry.kind) {
    case LightKind::Environment: return luminance(table.environment->mean) * kPi;
    case LightKind::Quad:
        if (!entry.twoSided && glm::dot(point - entry.origin, entry.direction) <= 0) return 0;
        return strength * std::min(2 * kPi, entry.area * overDistance2(entry.centre));
    case LightKind::Sphere: return strength * kPi * std::min(2.0F, sqr(entry.radius) * overDistance2(entry.origin));
    case LightKind::Directional: return strength;
    case LightKind::Point:
    case LightKind::Spot: return strength * overDistance2(entry.origin);
    case LightKind::Mesh: return importance(table.fewParts[entry.firstPart + part.triangle], point);
    }
    return 0;
}

/// Probability of a choice of importance `own` among `count` of importance `total`.
float probabilityOf(float own, float total, std::size_t count) {
    const float even = 1 / static_cast<float>(count);
    return total > 0 && std::isfinite(total) ? kEvenShare * even + (1 - kEvenShare) * own / total : even;
}

/// What is weighed one by one at a point: all there is where that is little, else the tree as one beside what reaches everywhere.
struct Choices {
    float total = 0;
    float tree = 0; ///< importance of the tree's lights together
    std::size_t count = 0;
};

/// Calls `weigh(part, importance)` for all choices, until it returns true.
template <class Weigh> void eachOfFew(const LightTable &table, const Vec3 &point, const Weigh &weigh) {
    for (Index entry = 0; entry < table.entries.size(); ++entry) {
        const bool mesh = table.entries[entry].kind == LightKind::Mesh;
        const Index triangles = mesh ? static_cast<Index>(table.entries[entry].triangles.size()) : 1;
        for (Index triangle = 0; triangle < triangles; ++triangle)
            if (weigh(LightPart{entry, triangle}, importance(table, {entry, triangle}, point))) return;
    }
}

Choices choicesAt(const LightTable &table, const Vec3 &point) {
    Choices choices;
    if (table.few) {
        eachOfFew(table, point, [&](const LightPart &, float own) {
            choices.total += own;
            ++choices.count;
            return false;
        });
        return choices;
    }
    for (const Index entry : table.everywhere) choices.total += importance(table, {entry, 0}, point);
    choices.tree = importance(table.tree, point);
    choices.total += choices.tree;
    choices.count = table.everywhere.size() + (choices.tree > 0 ? 1 : 0);
    return choices;
}

/// The only choice there is.
bool isAlone(const LightTable &table) {
    return table.choices == 1;
}

/// Converts a point sampled uniformly by area into a solid-angle sample.
[[gnu::always_inline]] inline LightSample fromArea(const LightEntry &entry, float area, const Vec3 &point, const Vec3 &onLight,
                                                   const Vec3 &normal) {
    LightSample s;
    const Vec3 d = onLight - point;
    const float distance2 = glm::dot(d, d);
    if (!(distance2 > 0)) return s;
    s.distance = std::sqrt(distance2);
    s.direction = d / s.distance;
    const float cosine = -glm::dot(normal, s.direction);
    if (!(entry.twoSided ? cosine != 0 : cosine > 0)) return s;
    s.radiance = entry.radiance;
    s.pdf = distance2 / (std::fabs(cosine) * area);
    return s;
}

/// 1 - cos of the half angle under which a sphere is seen, without cancellation; 2 from inside.
float sphereCap(const LightEntry &entry, const Vec3 &point) {
    const Vec3 d = entry.origin - point;
    const float sin2 = sqr(entry.radius) / glm::dot(d, d);
    if (!(sin2 < 1)) return 2;
    return sin2 / (1 + std::sqrt(1 - sin2));
}

LightSample sampleSphere(const LightEntry &entry, const Vec3 &point, const Vec2 &u) {
    LightSample s;
    const Vec3 toCentre = entry.origin - point;
    const float cap = sphereCap(entry, point);
    if (cap >= 2) return s; // from inside: left to scattered rays
    const float oneMinusCos = u.x * cap;
    const float sine = std::sqrt(std::max(0.0F, oneMinusCos * (2 - oneMinusCos)));
    const float phi = 2 * kPi * u.y;
    const float centreDistance = glm::length(toCentre);
    const Frame frame = smoothFrameFromNormal(toCentre / centreDistance);
    s.direction = glm::normalize(frame.fromLocal({sine * std::cos(phi), sine * std::sin(phi), 1 - oneMinusCos}));
    const float along = glm::dot(toCentre, s.direction);
    const float discriminant = sqr(entry.radius) - (glm::dot(toCentre, toCentre) - along * along);
    s.distance = along - std::sqrt(std::max(0.0F, discriminant));
    s.radiance = entry.radiance;
    s.pdf = 1 / (2 * kPi * cap);
    return s;
}

/// A mesh emitter's triangle at a time in the shutter.
struct EmittingTriangle {
    Vec3 corner, e1, e2;
    Vec3 cross; ///< twice the area long, on the side that shines
};

EmittingTriangle emittingTriangle(const LightEntry &entry, Index triangle, float time) {
    const Index3 &t = entry.triangles[triangle];
    EmittingTriangle e;
    e.corner = emitterPosition(entry, t.x, time);
    e.e1 = emitterPosition(entry, t.y, time) - e.corner;
    e.e2 = emitterPosition(entry, t.z, time) - e.corner;
    e.cross = glm::cross(e.e1, e.e2) * (entry.mirrored ? -1.0F : 1.0F);
    return e;
}

[[gnu::noinline]] LightSample sampleTriangle(const LightEntry &entry, Index triangle, const Vec3 &point, float time, const Vec2 &u) {
    const EmittingTriangle e = emittingTriangle(entry, triangle, time);
    const Vec2 b = squareToTriangle(u);
    const float length = glm::length(e.cross);
    return length > 0 ? fromArea(entry, 0.5F * length, point, e.corner + e.e1 * b.x + e.e2 * b.y, e.cross / length) : LightSample{};
}

LightSample sampleSpotOrPoint(const LightEntry &entry, const Vec3 &point) {
    LightSample s;
    const Vec3 d = entry.origin - point;
    const float distance2 = glm::dot(d, d);
    if (!(distance2 > 0)) return s;
    s.distance = std::sqrt(distance2);
    s.direction = d / s.distance;
    float fade = 1;
    if (entry.kind == LightKind::Spot) {
        const float cosine = -glm::dot(s.direction, entry.direction);
        // KHR_lights_punctual: linear in the cosine between the cones, squared.
        fade = sqr(glm::clamp((cosine - entry.cosOuter) / std::fmax(1e-4F, entry.cosInner - entry.cosOuter), 0.0F, 1.0F));
    }
    s.radiance = entry.radiance * (fade / distance2);
    s.pdf = fade > 0 ? 1.0F : 0.0F;
    s.delta = true;
    return s;
}

/// A sample of one light; the density does not yet know of the choice between lights.
LightSample samplePart(const LightTable &table, const LightPart &part, const Vec3 &point, float time, const Vec2 &u) {
    const LightEntry &entry = table.entries[part.entry];
    switch (entry.kind) {
    case LightKind::Environment: {
        const EnvironmentSample e = sampleEnvironment(*table.environment, u);
        // Transposed: render from world. A constant sky is the same any way round and stays in render space, where a rigid motion
        // of camera and scene leaves no trace.
        return {table.environment->constant ? e.direction : e.direction * table.worldFromRender, kInfinity, e.radiance, e.pdf, false};
    }
    case LightKind::Quad: return fromArea(entry, entry.area, point, entry.origin + entry.u * u.x + entry.v * u.y, entry.direction);
    case LightKind::Sphere: return sampleSphere(entry, point, u);
    case LightKind::Mesh: return sampleTriangle(entry, part.triangle, point, time, u);
    case LightKind::Directional: return {-entry.direction, kInfinity, entry.radiance, 1, true};
    case LightKind::Point:
    case LightKind::Spot: return sampleSpotOrPoint(entry, point);
    }
    return {};
}

} // namespace

Vec3 emitterPosition(const LightEntry &entry, Index vertex, float time) {
    if (!entry.placements.empty()) return transformPoint(affineAt(entry.placements, time), entry.steps.front()[vertex]);
    if (entry.steps.size() == 1) return entry.steps.front()[vertex];
    const float at = time * static_cast<float>(entry.steps.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(at), entry.steps.size() - 2);
    return glm::mix(entry.steps[before][vertex], entry.steps[before + 1][vertex], at - static_cast<float>(before));
}

void prepareChoice(LightTable &table) {
    table.parts.clear();
    table.fewParts.clear();
    table.everywhere.clear();
    std::vector<LightBounds> bounds;
    for (Index i = 0; i < table.entries.size(); ++i) {
        LightEntry &entry = table.entries[i];
        if (entry.kind == LightKind::Environment || entry.kind == LightKind::Directional) {
            table.everywhere.push_back(i);
            continue;
        }
        entry.firstPart = static_cast<Index>(table.parts.size());
        const Index triangles = entry.kind == LightKind::Mesh ? static_cast<Index>(entry.triangles.size()) : 1;
        for (Index triangle = 0; triangle < triangles; ++triangle) {
            table.parts.push_back({i, triangle});
            bounds.push_back(boundsOf(entry, triangle));
        }
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

namespace {

[[gnu::noinline]] float probabilityAmong(const LightTable &table, const LightPart &part, const Vec3 &point) {
    const Index firstPart = table.entries[part.entry].firstPart;
    const bool inTree = !table.few && firstPart != kNone;
    const float below = inTree ? leafProbability(table.tree, firstPart + part.triangle, point) : 1.0F;
    if (inTree && table.everywhere.empty()) return below;
    const Choices choices = choicesAt(table, point);
    if (inTree && !(choices.tree > 0)) return 0;
    return below * probabilityOf(inTree ? choices.tree : importance(table, part, point), choices.total, choices.count);
}

/// Out of the way of scenes with one light.
[[gnu::noinline]] LightChoice chooseAmong(const LightTable &table, const Vec3 &point, float choose) {
    const auto fromTree = [&](float number, float probability) -> LightChoice {
        const LeafChoice leaf = chooseLeaf(table.tree, point, number);
        if (leaf.light == kNone) return {};
        const LightPart &part = table.parts[leaf.light];
        return {part.entry, part.triangle, probability * leaf.probability};
    };
    if (!table.few && table.everywhere.empty()) return fromTree(choose, 1);
    const Choices choices = choicesAt(table, point);
    LightChoice chosen;
    float below = 0;
    // The last takes what rounding leaves over.
    const auto weigh = [&](const LightPart &part, float own) {
        const float probability = probabilityOf(own, choices.total, choices.count);
        chosen = {part.entry, part.triangle, probability};
        if (choose < below + probability) return true;
        below += probability;
        return false;
    };
    if (table.few) {
        eachOfFew(table, point, weigh);
        return chosen;
    }
    for (const Index entry : table.everywhere)
        if (weigh({entry, 0}, importance(table, {entry, 0}, point))) return chosen;
    if (!(choices.tree > 0)) return chosen;
    const float probability = probabilityOf(choices.tree, choices.total, choices.count);
    return fromTree(std::clamp((choose - below) / probability, 0.0F, kOneMinusEpsilon), probability);
}

} // namespace

float choiceProbability(const LightTable &table, const LightPart &part, const Vec3 &point) {
    return isAlone(table) ? 1.0F : probabilityAmong(table, part, point);
}

LightChoice chooseLight(const LightTable &table, const Vec3 &point, float choose) {
    if (isAlone(table)) return {0, 0, 1};
    return table.entries.empty() ? LightChoice{} : chooseAmong(table, point, choose);
}

LightSample sampleLight(const LightTable &table, const LightChoice &choice, const Vec3 &point, float time, const Vec2 &u) {
    if (choice.entry == kNone) return {};
    LightSample s = samplePart(table, {choice.entry, choice.triangle}, point, time, u);
    s.pdf *= choice.probability;
    return s;
}

LightSample sampleLight(const LightTable &table, const Vec3 &point, float time, float choose, const Vec2 &u) {
    return sampleLight(table, chooseLight(table, point, choose), point, time, u);
}

LightHit intersectLight(const LightTable &table, Index index, const Vec3 &origin, const Vec3 &direction, float farthest) {
    const LightEntry &entry = table.entries[index];
    if (entry.kind == LightKind::Quad) {
        const float cosine = glm::dot(entry.direction, direction);
        if (!(entry.twoSided ? cosine != 0 : cosine < 0)) return {};
        const Vec3 toCorner = entry.origin - origin;
        const float t = glm::dot(entry.direction, toCorner) / cosine;
        if (!(t > 0 && t < farthest)) return {};
        // Coordinates along u and v, which need not be perpendicular.
        const Vec3 onPlane = direction * t - toCorner;
        const float a = glm::dot(onPlane, entry.alongU);
        const float b = glm::dot(onPlane, entry.alongV);
        const bool inside = a >= 0 && a <= 1 && b >= 0 && b <= 1;
        return inside ? LightHit{index, t, std::fabs(cosine)} : LightHit{};
    }
    if (entry.kind != LightKind::Sphere) return {};
    const Vec3 toCentre = entry.origin - origin;
    const float along = glm::dot(toCentre, direction);
    const Vec3 closest = toCentre - direction * along; // perpendicular offset: no cancellation far away
    const float discriminant = sqr(entry.radius) - glm::dot(closest, closest);
    if (discriminant < 0) return {};
    const float t = along - std::sqrt(discriminant);
    return t > 0 && t < farthest ? LightHit{index, t, 1} : LightHit{};
}

float lightHitPdf(const LightTable &table, Index index, const Vec3 &point, float t, float absCosine) {
    const LightEntry &entry = table.entries[index];
    if (entry.kind == LightKind::Sphere) {
        const float cap = sphereCap(entry, point);
        return cap < 2 ? choiceProbability(table, {index, 0}, point) / (2 * kPi * cap) : 0;
    }
    return absCosine > 0 ? choiceProbability(table, {index, 0}, point) * t * t / (absCosine * entry.area) : 0;
}

float emitterHitPdf(const LightTable &table, const LightPart &part, const Vec3 &point, float time, float t, float absCosine) {
    const float area = 0.5F * glm::length(emittingTriangle(table.entries[part.entry], part.triangle, time).cross);
    return absCosine * area > 0 ? choiceProbability(table, part, point) * t * t / (absCosine * area) : 0;
}

} // namespace taut
