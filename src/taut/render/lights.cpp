#include "taut/render/lights.h"

#include "taut/base/frame.h"
#include "taut/base/warp.h"

#include <algorithm>

namespace taut {

namespace {

/// Share of the choice that is spread evenly over the lights.
constexpr float kEvenShare = 0.25F;

/// Power a light sends into the scene, up to a common factor.
float power(const LightEntry &entry, const LightTable &table) {
    const float strength = luminance(entry.radiance);
    const float disk = kPi * table.sceneRadius * table.sceneRadius;
    switch (entry.kind) {
    case LightKind::Environment: return luminance(table.environment->mean) * kPi * disk;
    case LightKind::Quad:
    case LightKind::Mesh: return strength * kPi * entry.area * (entry.twoSided ? 2.0F : 1.0F);
    case LightKind::Sphere: return strength * kPi * 4 * kPi * entry.radius * entry.radius;
    case LightKind::Directional: return strength * disk;
    case LightKind::Point: return strength * 4 * kPi;
    case LightKind::Spot: return strength * 2 * kPi * (1 - 0.5F * (entry.cosInner + entry.cosOuter));
    }
    return 0;
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
    s.pdf = entry.pmf * distance2 / (std::fabs(cosine) * entry.area);
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
    const float sine = std::sqrt(std::fmax(0.0F, oneMinusCos * (2 - oneMinusCos)));
    const float phi = 2 * kPi * u.y;
    const float centreDistance = glm::length(toCentre);
    const Frame frame = smoothFrameFromNormal(toCentre / centreDistance);
    s.direction = glm::normalize(frame.fromLocal({sine * std::cos(phi), sine * std::sin(phi), 1 - oneMinusCos}));
    const float along = glm::dot(toCentre, s.direction);
    const float discriminant = sqr(entry.radius) - (glm::dot(toCentre, toCentre) - along * along);
    s.distance = along - std::sqrt(std::fmax(0.0F, discriminant));
    s.radiance = entry.radiance;
    s.pdf = entry.pmf / (2 * kPi * cap);
    return s;
}

LightSample sampleMesh(const LightEntry &entry, const Vec3 &point, const Vec2 &u) {
    const auto found = std::upper_bound(entry.cumulativeArea.begin(), entry.cumulativeArea.end(), u.x * entry.area);
    const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(found - entry.cumulativeArea.begin()), entry.triangles.size() - 1);
    const float below = i == 0 ? 0.0F : entry.cumulativeArea[i - 1];
    const float share = entry.cumulativeArea[i] - below;
    const float reused = share > 0 ? glm::clamp((u.x * entry.area - below) / share, 0.0F, kOneMinusEpsilon) : 0.5F;
    const Index3 &t = entry.triangles[i];
    const Vec3 &a = entry.positions[t.x];
    const Vec3 e1 = entry.positions[t.y] - a;
    const Vec3 e2 = entry.positions[t.z] - a;
    const Vec2 b = squareToTriangle({reused, u.y});
    const Vec3 cross = glm::cross(e1, e2) * (entry.mirrored ? -1.0F : 1.0F);
    const float length = glm::length(cross);
    return length > 0 ? fromArea(entry, point, a + e1 * b.x + e2 * b.y, cross / length) : LightSample{};
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
    s.pdf = fade > 0 ? entry.pmf : 0;
    s.delta = true;
    return s;
}

} // namespace

void finishLightTable(LightTable &table) {
    const std::size_t count = table.entries.size();
    table.cumulative.resize(count);
    double total = 0;
    for (const LightEntry &entry : table.entries) total += static_cast<double>(power(entry, table));
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double even = 1.0 / static_cast<double>(count);
        const double share = total > 0 ? static_cast<double>(power(table.entries[i], table)) / total : even;
        const double pmf = count == 1 ? 1.0 : static_cast<double>(kEvenShare) * even + (1 - static_cast<double>(kEvenShare)) * share;
        table.entries[i].pmf = static_cast<float>(pmf);
        sum += pmf;
        table.cumulative[i] = static_cast<float>(sum);
    }
}

LightSample sampleLight(const LightTable &table, const Vec3 &point, float choose, const Vec2 &u) {
    if (table.entries.empty()) return {};
    const auto found = std::upper_bound(table.cumulative.begin(), table.cumulative.end(), choose);
    const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(found - table.cumulative.begin()), table.entries.size() - 1);
    const LightEntry &entry = table.entries[i];
    switch (entry.kind) {
    case LightKind::Environment: {
        const EnvironmentSample e = sample(*table.environment, u);
        LightSample s;
        // Transposed: render from world. A constant sky is the same any way round and stays in render space, where a rigid motion
        // of camera and scene leaves no trace.
        s.direction = table.environment->constant ? e.direction : e.direction * table.worldFromRender;
        s.radiance = e.radiance;
        s.pdf = entry.pmf * e.pdf;
        return s;
    }
    case LightKind::Quad: return fromArea(entry, point, entry.origin + entry.u * u.x + entry.v * u.y, entry.direction);
    case LightKind::Sphere: return sampleSphere(entry, point, u);
    case LightKind::Mesh: return sampleMesh(entry, point, u);
    case LightKind::Directional: return {-entry.direction, kInfinity, entry.radiance, entry.pmf, true};
    case LightKind::Point:
    case LightKind::Spot: return sampleSpotOrPoint(entry, point);
    }
    return {};
}

LightHit intersectLights(const LightTable &table, const Vec3 &origin, const Vec3 &direction, float farthest, bool cameraRay) {
    LightHit best;
    best.t = farthest;
    for (Index i = 0; i < table.entries.size(); ++i) {
        const LightEntry &entry = table.entries[i];
        if (cameraRay && !entry.cameraVisible) continue;
        if (entry.kind == LightKind::Quad) {
            const float cosine = glm::dot(entry.direction, direction);
            if (!(entry.twoSided ? cosine != 0 : cosine < 0)) continue;
            const Vec3 toCorner = entry.origin - origin;
            const float t = glm::dot(entry.direction, toCorner) / cosine;
            if (!(t > 0 && t < best.t)) continue;
            // Coordinates along u and v, which need not be perpendicular.
            const Vec3 onPlane = direction * t - toCorner;
            const float a = glm::dot(glm::cross(onPlane, entry.v), entry.direction) / entry.area;
            const float b = glm::dot(glm::cross(entry.u, onPlane), entry.direction) / entry.area;
            if (a < 0 || a > 1 || b < 0 || b > 1) continue;
            best = {i, t, std::fabs(cosine)};
        } else if (entry.kind == LightKind::Sphere) {
            const Vec3 toCentre = entry.origin - origin;
            const float along = glm::dot(toCentre, direction);
            const Vec3 closest = toCentre - direction * along; // perpendicular offset: no cancellation far away
            const float discriminant = sqr(entry.radius) - glm::dot(closest, closest);
            if (discriminant < 0) continue;
            const float t = along - std::sqrt(discriminant);
            if (t > 0 && t < best.t) best = {i, t, 1};
        }
    }
    return best;
}

float lightHitPdf(const LightEntry &entry, const Vec3 &point, float t, float absCosine) {
    if (entry.kind == LightKind::Sphere) {
        const float cap = sphereCap(entry, point);
        return cap < 2 ? entry.pmf / (2 * kPi * cap) : 0;
    }
    return absCosine > 0 ? entry.pmf * t * t / (absCosine * entry.area) : 0;
}

Vec3 environmentRadiance(const LightTable &table, const Vec3 &direction) {
    return table.environment != nullptr ? radiance(*table.environment, table.worldFromRender * direction) : Vec3(0);
}

float environmentPdf(const LightTable &table, const Vec3 &direction) {
    if (table.environment == nullptr) return 0;
    return table.entries[table.environmentEntry].pmf * samplePdf(*table.environment, table.worldFromRender * direction);
}

} // namespace taut
