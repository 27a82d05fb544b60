#include "taut/render/lights.h"

#include "taut/base/frame.h"
#include "taut/base/warp.h"

#include <algorithm>

namespace taut {

namespace {

/// Share of the choice that is spread evenly over the lights.
constexpr float kEvenShare = 0.1F;

/// Irradiance that an unoccluded light could cause at a point, up to a common factor and the receiver's cosine. Zero only where
/// the light can send nothing.
float importance(const LightEntry &entry, const LightTable &table, const Vec3 &point) {
    const float strength = luminance(entry.radiance);
    const auto overDistance2 = [&](const Vec3 &from) {
        const Vec3 d = from - point;
        return 1 / std::max(glm::dot(d, d), 1e-20F);
    };
    switch (entry.kind) {
    case LightKind::Environment: return luminance(table.environment->mean) * kPi;
    case LightKind::Quad:
        if (!entry.twoSided && glm::dot(point - entry.origin, entry.direction) <= 0) return 0;
        [[fallthrough]];
    case LightKind::Mesh: return strength * std::min(2 * kPi, entry.area * overDistance2(entry.centre));
    case LightKind::Sphere: return strength * kPi * std::min(2.0F, sqr(entry.radius) * overDistance2(entry.origin));
    case LightKind::Directional: return strength;
    case LightKind::Point:
    case LightKind::Spot: return strength * overDistance2(entry.origin);
    }
    return 0;
}

/// Probability of an entry of importance `own` among entries of importance `total`.
float probabilityOf(float own, float total, std::size_t count) {
    const float even = 1 / static_cast<float>(count);
    return total > 0 && std::isfinite(total) ? kEvenShare * even + (1 - kEvenShare) * own / total : even;
}

float totalImportance(const LightTable &table, const Vec3 &point) {
    float total = 0;
    for (const LightEntry &entry : table.entries) total += importance(entry, table, point);
    return total;
}

/// Converts a point sampled uniformly by area into a solid-angle sample.
LightSample fromArea(const LightEntry &entry, const Vec3 &point, const Vec3 &onLight, const Vec3 &normal) {
    LightSample s;
    const Vec3 d = onLight - point;
    const float distance2 = glm::dot(d, d);
    if (!(distance2 > 0)) return s;
    s.distance = std::sqrt(distance2);
    s.direction = d / s.distance;
    const float cosine = -glm::dot(normal, s.direction);
    if (!(entry.twoSided ? cosine != 0 : cosine > 0)) return s;
    s.radiance = entry.radiance;
    s.pdf = distance2 / (std::fabs(cosine) * entry.area);
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

LightSample sampleMesh(const LightEntry &entry, const Vec3 &point, float time, const Vec2 &u) {
    const auto found = std::upper_bound(entry.cumulativeArea.begin(), entry.cumulativeArea.end(), u.x * entry.area);
    const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(found - entry.cumulativeArea.begin()), entry.triangles.size() - 1);
    const float below = i == 0 ? 0.0F : entry.cumulativeArea[i - 1];
    const float share = entry.cumulativeArea[i] - below;
    const float reused = share > 0 ? glm::clamp((u.x * entry.area - below) / share, 0.0F, kOneMinusEpsilon) : 0.5F;
    const Index3 &t = entry.triangles[i];
    const Vec3 a = emitterPosition(entry, t.x, time);
    const Vec3 e1 = emitterPosition(entry, t.y, time) - a;
    const Vec3 e2 = emitterPosition(entry, t.z, time) - a;
    const Vec2 b = squareToTriangle({reused, u.y});
    const Vec3 cross = glm::cross(e1, e2) * (entry.mirrored ? -1.0F : 1.0F);
    const float length = glm::length(cross);
    if (!(length > 0)) return {};
    LightSample s = fromArea(entry, point, a + e1 * b.x + e2 * b.y, cross / length);
    if (entry.moves()) s.pdf /= emitterGrowth(entry, static_cast<Index>(i), time);
    return s;
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
LightSample sampleEntry(const LightTable &table, const LightEntry &entry, const Vec3 &point, float time, const Vec2 &u) {
    switch (entry.kind) {
    case LightKind::Environment: {
        const EnvironmentSample e = sample(*table.environment, u);
        // Transposed: render from world. A constant sky is the same any way round and stays in render space, where a rigid motion
        // of camera and scene leaves no trace.
        return {table.environment->constant ? e.direction : e.direction * table.worldFromRender, kInfinity, e.radiance, e.pdf, false};
    }
    case LightKind::Quad: return fromArea(entry, point, entry.origin + entry.u * u.x + entry.v * u.y, entry.direction);
    case LightKind::Sphere: return sampleSphere(entry, point, u);
    case LightKind::Mesh: return sampleMesh(entry, point, time, u);
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

float emitterGrowth(const LightEntry &entry, Index triangle, float time) {
    if (!entry.moves()) return 1;
    const Index3 &t = entry.triangles[triangle];
    const auto area = [&](float when) {
        const Vec3 a = emitterPosition(entry, t.x, when);
        return glm::length(glm::cross(emitterPosition(entry, t.y, when) - a, emitterPosition(entry, t.z, when) - a));
    };
    const float before = area(0);
    return before > 0 ? area(time) / before : 1.0F;
}

float choiceProbability(const LightTable &table, Index entry, const Vec3 &point) {
    if (table.entries.size() == 1) return 1;
    return probabilityOf(importance(table.entries[entry], table, point), totalImportance(table, point), table.entries.size());
}

LightChoice chooseLight(const LightTable &table, const Vec3 &point, float choose) {
    const std::size_t count = table.entries.size();
    if (count == 0) return {};
    if (count == 1) return {0, 1};
    const float total = totalImportance(table, point);
    float below = 0;
    for (Index entry = 0;; ++entry) {
        const float probability = probabilityOf(importance(table.entries[entry], table, point), total, count);
        if (choose < below + probability || entry + 1 == count) return {entry, probability};
        below += probability;
    }
}

LightSample sampleLight(const LightTable &table, const LightChoice &choice, const Vec3 &point, float time, const Vec2 &u) {
    if (choice.entry == kNone) return {};
    LightSample s = sampleEntry(table, table.entries[choice.entry], point, time, u);
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

float lightHitPdf(const LightTable &table, Index index, const Vec3 &point, float t, float absCosine, float growth) {
    const LightEntry &entry = table.entries[index];
    if (entry.kind == LightKind::Sphere) {
        const float cap = sphereCap(entry, point);
        return cap < 2 ? choiceProbability(table, index, point) / (2 * kPi * cap) : 0;
    }
    return absCosine > 0 ? choiceProbability(table, index, point) * t * t / (absCosine * entry.area * growth) : 0;
}

} // namespace taut
