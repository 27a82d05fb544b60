#pragma once
/// A material's parameters at a point, and its M there. In the header: it is what shading does at every hit.

#include "taut/microsurface/roughening.h"
#include "taut/scene/ranges.h"
#include "taut/scene/scene.h"

namespace taut {

inline float evaluate(const FloatParam &param, const Scene &scene, const UvPoint &uv) {
    return param.texture == kNone ? param.value : param.value * lookup(scene.textures[param.texture], uv)[param.channel];
}
inline Vec3 evaluate(const ColorParam &param, const Scene &scene, const UvPoint &uv) {
    return param.texture == kNone ? param.value : param.value * Vec3(lookup(scene.textures[param.texture], uv));
}

/// Of what reflects or passes a share of the light: what a texture says beyond that is held at none and all.
template <class Param> auto evaluateShare(const Param &param, const Scene &scene, const UvPoint &uv) {
    const auto value = evaluate(param, scene, uv);
    return glm::clamp(value, decltype(value)(0), decltype(value)(1));
}

/// Share of the surface that is there; `own`: alpha of the mesh's own colour.
inline float opacityOf(const Material &material, const Scene &scene, const UvPoint &uv, float own = 1) {
    if (material.alphaMode == AlphaMode::Opaque) return 1;
    const float opacity = evaluateShare(material.opacity, scene, uv) * own;
    if (material.alphaMode == AlphaMode::Blend) return opacity;
    return opacity >= material.alphaCutoff ? 1.0F : 0.0F;
}

/// Rest roughness and rotation of a material at uv.
struct RestRoughness {
    float alphaX, alphaY, rotation;
};

inline RestRoughness restRoughness(const Material &material, const Scene &scene, const UvPoint &uv) {
    RestRoughness r{evaluate(material.alphaX, scene, uv), evaluate(material.alphaY, scene, uv), evaluate(material.rotation, scene, uv)};
    if (material.alphaIsRoughness) {
        r.alphaX *= r.alphaX;
        r.alphaY *= r.alphaY;
    }
    float strength = material.anisotropyStrength;
    if (material.anisotropyTexture != kNone) {
        const Vec4 texel = lookup(scene.textures[material.anisotropyTexture], uv);
        r.rotation += std::atan2(2 * texel.y - 1, 2 * texel.x - 1);
        strength *= texel.z;
    }
    // KHR_materials_anisotropy: rougher along the direction.
    if (strength != 0) r.alphaX = glm::mix(r.alphaX, 1.0F, strength * strength);
    r.alphaX = glm::clamp(r.alphaX, kLeastAlpha, kMostAlpha);
    r.alphaY = glm::clamp(r.alphaY, kLeastAlpha, kMostAlpha);
    return r;
}

/// Alpha of a clear coat at uv.
inline float coatAlpha(const Material &material, const Scene &scene, const UvPoint &uv) {
    return glm::clamp(sqr(evaluate(material.clearcoatRoughness, scene, uv)), kLeastAlpha, 1.0F);
}

/// M of a material that its strain roughens.
inline MicroTransform roughenedBy(const Material &material, float strain, const MicroTransform &m) {
    return roughened(
        m, addedAlpha(static_cast<double>(strain), static_cast<double>(material.roughening), static_cast<double>(material.yield)));
}

/// Unit direction of the rest material's x axis in a frame: the tangent turned by the material's rotation (cosine, sine), to the side of
/// b0 that `sense` says.
inline Vec2 restAxis(const Vec2 &tangent, float cosine, float sine, float sense) {
    const float s = sine * sense;
    return {tangent.x * cosine - tangent.y * s, tangent.x * s + tangent.y * cosine};
}

/// Stretch along the normal by Poisson's ratio, from V.
inline float lambdaOf(const Vec3 &stretch, float poisson) {
    const float area = std::fabs(stretch.x * stretch.z - stretch.y * stretch.y);
    return normalStretch(std::fmax(area, 1e-12F), poisson);
}

/// M = A M0 / lambda in an orthonormal frame (s, t, n). `stretch` is V there (ss, st, tt), `tangent` the rotated rest tangent R t0
/// there (unit), `sense` +1 where the rest frame's b0 lies at cross(n, t0), -1 where the UV map is mirrored. With A = V R, R taking t0 to
/// `tangent` and b0 to its `sense` side, and because a mirror image of the standard microsurface is itself, M = V Rotation(tangent)
/// Rotation(sense * rotation) diag(1/alphaX, 1/alphaY). A mesh whose deformers move space (`lean` not null) brings its own lambda
/// along, already in `stretch` and `lean`; Poisson's ratio then has no say.
inline MicroTransform transformAt(const Material &material, const RestRoughness &rest, const Vec3 &stretch, const Vec2 &tangent,
                                  float sense, const Vec2 *lean = nullptr) {
    const float lambda = material.poisson == 0 || lean != nullptr ? 1.0F : lambdaOf(stretch, material.poisson);
    Vec2 axis = tangent;
    if (rest.alphaX == rest.alphaY) {
        axis = {1, 0}; // any will do; this one leaves the bits alone
    } else if (rest.rotation != 0) {
        axis = restAxis(tangent, std::cos(rest.rotation), std::sin(rest.rotation), sense);
    }
    return deformedTransform(Block{stretch.x, stretch.y, stretch.y, stretch.z}, restBlock(rest.alphaX, rest.alphaY, axis), lambda,
                             lean != nullptr ? *lean : Vec2(0));
}
/// With the material's roughness at uv.
inline MicroTransform transformAt(const Material &material, const Scene &scene, const Vec2 &uv, const Vec3 &stretch, const Vec2 &tangent,
                                  float sense, const Vec2 *lean = nullptr) {
    return transformAt(material, restRoughness(material, scene, uv), stretch, tangent, sense, lean);
}

} // namespace taut
