#pragma once
/// What the kinds of light are described with; light_shapes.h lists them.

#include "taut/base/vec.h"

#include <optional>
#include <string_view>

namespace taut {

// --- in a scene: world space -----------------------------------------------------------------------------------------

/// What is wrong with a light whose keys are each in range.
struct LightFault {
    std::string_view found, expected;
};

/// A light as what it shines on sees it: a disk that faces `normal`, a ball, or a point.
struct LightOutline {
    Vec3 centre{0};
    float radius = 0;   ///< 0: a point
    Vec3 normal{0};     ///< of a disk or a spot; 0: shines to all sides
    float cosOuter = 0; ///< where there is a normal: least cosine to it that is lit
};

// --- in a frame: render space ----------------------------------------------------------------------------------------

struct LightSample {
    Vec3 direction{0}; ///< unit, towards the light
    float distance = kInfinity;
    Vec3 radiance{0};
    float pdf = 0;      ///< per steradian; delta lights: 1
    bool delta = false; ///< can't be met by a scattered ray
};

/// What light falls on, seen from one side.
struct Receiver {
    Vec3 position{0};
    Vec3 normal{0}; ///< unit, geometric, on that side: light from below it is lost; 0: it may come from everywhere
};

/// The least cosine that lights above the horizon are chosen by: an interpolated normal sees more of them than the triangle does.
inline constexpr float kHorizonCosine = 0.05F;

/// What light of a box counts for at a receiver, to choose by: the greatest cosine that it may come at, at least kHorizonCosine; 0 where
/// all of the box is below the horizon. Its centre lies `towards` there and it reaches `half` further; it is seen within an angle whose
/// cosine is `cosBox` and whose squared sine is `sin2Box` (Pharr, Jakob and Humphreys 2023, section 12.6.3).
[[gnu::always_inline]] inline float received(const Receiver &at, const Vec3 &towards, float inverseDistance, const Vec3 &half,
                                             float sin2Box, float cosBox) {
    const bool everywhere = (at.normal.x == 0) & (at.normal.y == 0) & (at.normal.z == 0);
    const float height = glm::dot(at.normal, towards);
    const bool below = height + glm::dot(glm::abs(at.normal), half) < 0;
    const float cosine = std::clamp(height * inverseDistance, -1.0F, 1.0F);
    const float sines = std::sqrt((1 - cosine * cosine) * sin2Box);
    const float most = cosine >= cosBox ? 1.0F : cosine * cosBox + sines;
    const float lit = below ? 0.0F : std::max(most, kHorizonCosine);
    return everywhere ? 1.0F : lit;
}

/// Where a ray meets a light that is no geometry; at infinity where it does not.
struct ShapeHit {
    float t = kInfinity;
    float absCosine = 0;
};

/// What a light, or several, can do: from a point of the box, light leaves within an angle `reach` of directions that lie within an
/// angle `spread` of the axis.
struct LightBounds {
    Vec3 lower{kInfinity}, upper{-kInfinity}; ///< box
    Vec3 axis{0, 0, 1};                       ///< unit
    float cosSpread = 1;                      ///< of an angle in [0, pi]; -1: all directions
    float cosReach = 0;                       ///< of an angle in [0, pi/2]
    float power = 0;       ///< greatest intensity: irradiance at distance 1 on a surface that faces a light that faces it
    bool twoSided = false; ///< shines about the opposite axis too
    bool met = false;      ///< rays can meet it though it is no geometry
};

inline void include(LightBounds &bounds, const Vec3 &point) {
    bounds.lower = glm::min(bounds.lower, point);
    bounds.upper = glm::max(bounds.upper, point);
}

inline Vec3 placedPoint(const DMat4 &renderFromWorld, const DVec3 &p) {
    return Vec3(DVec3(renderFromWorld * glm::dvec4(p, 1)));
}
inline Vec3 placedVector(const DMat4 &renderFromWorld, const DVec3 &v) {
    return Vec3(DMat3(renderFromWorld) * v);
}

inline float inverseDistance2(const Vec3 &from, const Vec3 &point) {
    const Vec3 d = from - point;
    return 1 / std::max(glm::dot(d, d), 1e-20F);
}

/// Converts a point sampled uniformly by area into a solid-angle sample.
[[gnu::always_inline]] inline LightSample sampleOfArea(const Vec3 &radiance, bool twoSided, float area, const Vec3 &point,
                                                       const Vec3 &onLight, const Vec3 &normal) {
    LightSample s;
    const Vec3 d = onLight - point;
    const float distance2 = glm::dot(d, d);
    if (!(distance2 > 0)) return s;
    s.distance = std::sqrt(distance2);
    s.direction = d / s.distance;
    const float cosine = -glm::dot(normal, s.direction);
    if (!(twoSided ? cosine != 0 : cosine > 0)) return s;
    s.radiance = radiance;
    s.pdf = distance2 / (std::fabs(cosine) * area);
    return s;
}

/// A sample of a light that is all at one place: `fade(direction)` is the share of its intensity that it sends against a direction.
template <class Fade> LightSample sampleOfPlace(const Vec3 &intensity, const Vec3 &position, const Vec3 &point, const Fade &fade) {
    LightSample s;
    const Vec3 d = position - point;
    const float distance2 = glm::dot(d, d);
    if (!(distance2 > 0)) return s;
    s.distance = std::sqrt(distance2);
    s.direction = d / s.distance;
    const float share = fade(s.direction);
    s.radiance = intensity * (share / distance2);
    s.pdf = share > 0 ? 1.0F : 0.0F;
    s.delta = true;
    return s;
}

} // namespace taut
