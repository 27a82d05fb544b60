#pragma once
/// A parallelogram that shines.

#include "taut/scene/lights/light.h"

namespace taut {

/// It shines on the side of cross(u, v). Light::radiance is its radiance.
struct QuadLight {
    static constexpr std::string_view kName = "quad";
    DVec3 corner{0};
    DVec3 u{1, 0, 0}, v{0, 1, 0}; ///< edges
    bool twoSided = false;

    template <class Keys> void read(Keys &keys) {
        keys.brightness("radiance");
        keys.cameraVisible();
        keys.vector("corner", corner);
        keys.vector("u", u);
        keys.vector("v", v);
        keys.flag("two_sided", twoSided);
    }

    [[nodiscard]] std::optional<LightFault> fault() const {
        const double area = glm::length(glm::cross(u, v));
        if (area > 1e-12 * glm::length(u) * glm::length(v) && area > 0) return std::nullopt;
        return LightFault{"u and v along one line", "two edges of a quad"};
    }

    [[nodiscard]] std::optional<LightOutline> outline() const {
        const DVec3 cross = glm::cross(u, v);
        const double area = glm::length(cross);
        if (!(area > 0)) return std::nullopt;
        return LightOutline{Vec3(corner + 0.5 * (u + v)), static_cast<float>(std::sqrt(area / static_cast<double>(kPi))),
                            twoSided ? Vec3(0) : Vec3(cross / area), 0};
    }
};

struct PlacedQuad {
    Vec3 corner, u, v;
    Vec3 alongU, alongV; ///< what a vector in its plane is multiplied by to have its coordinates along the edges
    Vec3 normal, centre;
    float area;
    bool twoSided;
    bool operator==(const PlacedQuad &) const = default;

    [[nodiscard]] float importance(float strength, const Receiver &at) const {
        if (!twoSided && glm::dot(at.position - corner, normal) <= 0) return 0;
        return strength * std::min(2 * kPi, area * inverseDistance2(centre, at.position));
    }

    [[nodiscard]] LightSample sample(const Vec3 &radiance, const Vec3 &point, const Vec2 &number) const {
        return sampleOfArea(radiance, twoSided, area, point, corner + u * number.x + v * number.y, normal);
    }

    [[nodiscard]] ShapeHit meet(const Vec3 &origin, const Vec3 &direction, float farthest) const {
        const float cosine = glm::dot(normal, direction);
        if (!(twoSided ? cosine != 0 : cosine < 0)) return {};
        const Vec3 toCorner = corner - origin;
        const float t = glm::dot(normal, toCorner) / cosine;
        if (!(t > 0 && t < farthest)) return {};
        // Coordinates along u and v, which need not be perpendicular.
        const Vec3 onPlane = direction * t - toCorner;
        const float a = glm::dot(onPlane, alongU);
        const float b = glm::dot(onPlane, alongV);
        const bool inside = a >= 0 && a <= 1 && b >= 0 && b <= 1;
        return inside ? ShapeHit{t, std::fabs(cosine)} : ShapeHit{};
    }

    [[nodiscard]] float hitPdf(float choice, const Vec3 & /*point*/, const ShapeHit &hit) const {
        return hit.absCosine > 0 ? choice * hit.t * hit.t / (hit.absCosine * area) : 0;
    }

    [[nodiscard]] LightBounds bounds(float strength) const {
        LightBounds b;
        for (const Vec3 &at : {corner, corner + u, corner + v, corner + u + v}) include(b, at);
        b.axis = normal;
        b.power = strength * area;
        b.twoSided = twoSided;
        return b;
    }
};

inline PlacedQuad place(const QuadLight &light, const DMat4 &renderFromWorld) {
    PlacedQuad q;
    q.corner = placedPoint(renderFromWorld, light.corner);
    q.u = placedVector(renderFromWorld, light.u);
    q.v = placedVector(renderFromWorld, light.v);
    const Vec3 cross = glm::cross(q.u, q.v);
    q.area = glm::length(cross);
    q.normal = cross / q.area;
    q.alongU = glm::cross(q.v, q.normal) / q.area;
    q.alongV = glm::cross(q.normal, q.u) / q.area;
    q.centre = q.corner + 0.5F * (q.u + q.v);
    q.twoSided = light.twoSided;
    return q;
}

} // namespace taut
