#pragma once
/// What a pixel sees along a path, as a cone around its rays (Akenine-Moller et al. 2021, "Improved Shader and Texture Level of Detail
/// Using Ray Cones"): its width grows with the distance by its spread, and a lobe spreads it further.

#include "taut/render/render_scene.h"
#include "taut/render/surface_geometry.h"

namespace taut {

struct RayCone {
    float width = 0;  ///< where the ray starts
    float spread = 0; ///< width that a unit of length adds

    [[nodiscard]] float widthAt(float distance) const { return width + spread * distance; }
    /// Goes on from a hit at that distance, scattered by a lobe of this alpha.
    void scatter(float distance, float alpha) {
        width = widthAt(distance);
        spread = std::fmin(spread + alpha, 1.0F);
    }
};

/// Of a pixel, at the camera.
inline RayCone pixelCone(const CameraState &camera, int height) {
    const auto pixels = static_cast<double>(height);
    if (camera.orthoHeight > 0) return {static_cast<float>(camera.orthoHeight / pixels), 0};
    return {0, static_cast<float>(2 * std::tan(0.5 * camera.fovY) / pixels)};
}

/// What a cone of this width sees of a triangle, in its texture coordinates: across the ray, and stretched along it. `uvs` of the three
/// corners, in the order that p.e1 and p.e2 lead to the second and the third.
inline UvFootprint footprintOf(const InterpolatedSurface &p, const Vec3 &wo, float width, const std::array<Vec2, 3> &uvs) {
    const Vec3 cross = glm::cross(p.e1, p.e2);
    const float area2 = glm::dot(cross, cross);
    if (!(area2 > 0) || !(width > 0)) return {};
    const Vec3 n = cross / std::sqrt(area2);
    constexpr float kLeastCosine = 0.05F;
    const float cosine = std::fmax(std::fabs(glm::dot(n, wo)), kLeastCosine);
    const Vec3 flat = wo - n * glm::dot(n, wo);
    const float length = glm::length(flat);
    const Vec3 along = length > 1e-6F ? flat / length : smoothTangentFromNormal(n);
    // q = a e1 + b e2 in the plane.
    const float g11 = glm::dot(p.e1, p.e1);
    const float g12 = glm::dot(p.e1, p.e2);
    const float g22 = glm::dot(p.e2, p.e2);
    const auto inUv = [&](const Vec3 &q) {
        const float x = glm::dot(q, p.e1);
        const float y = glm::dot(q, p.e2);
        return ((uvs[1] - uvs[0]) * (g22 * x - g12 * y) + (uvs[2] - uvs[0]) * (g11 * y - g12 * x)) / area2;
    };
    return {inUv(along * (width / cosine)), inUv(glm::cross(n, along) * width)};
}

} // namespace taut
