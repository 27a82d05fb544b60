#pragma once
/// From a hit to what scatters there: shading frame, M from the interpolated stretch, and the material's parameters.

#include "taut/base/frame.h"
#include "taut/bsdf/tilted_facet.h"
#include "taut/render/interpolation.h"
#include "taut/render/render_scene.h"
#include "taut/scene/material_gloss.h"

namespace taut {

/// What a deforming mesh does at a hit, in the shading frame.
struct HitDeformation {
    Vec3 stretch{1, 0, 1}; ///< V: ss, st, tt
    Vec2 lean{0};          ///< column 3 of M; zero unless the mesh leans
    Vec2 tangent{1, 0};    ///< R t0, the rotated tangent; unit
    float strain = 0;      ///< equivalentStrain() of A, where a material asks for it
};
HitDeformation deformationAt(const RenderObject &object, const HitCorners<false> &corners, const SurfaceGeometry &at);

/// A surface point in render space, seen from one side.
struct SurfacePoint : HitDeformation {
    Vec3 position;
    Vec3 geometricNormal; ///< unit, towards the viewer
    float clearance = 0;  ///< distance from the surface at which a ray may start, see offsetOrigin()
    Frame frame;          ///< shading frame: a function of the shading normal alone, so that nothing sampled in it depends on how
                          ///< the surface is parametrised; n on the geometric normal's side
    Frame facet;          ///< that of `bsdf`: the shading frame but where a map tilts it
    bool tilted = false;  ///< whether one does
    Bsdf bsdf;
    UvPoint uv;
    Vec4 color{1};        ///< of the mesh itself, linear RGBA
    float facing = 1;     ///< SurfaceGeometry
    Vec3 emission{0};     ///< radiance leaving towards the viewer
    bool scatters = true; ///< false: unlit, the base colour is what is seen
    Vec3 extinction{0};   ///< of the medium beyond the surface, where light is refracted into it; a unit of length
    // For AOVs.
    Vec3 baseColor{0};
    const RenderObject *object = nullptr;
    Index3 corners{0};
    Vec3 barycentrics{0};
};

/// Materials with what is worked out once.
struct PreparedMaterial {
    const Material *material = nullptr;
    float coatEscape = 1; ///< coatEscape(ior)
    MultiscatterPlan multiscatter;
    float bearableWaste = kBearableWaste; ///< the plan's
    Vec3 extinction{0};                   ///< of its volume
    bool filters = false;                 ///< textures are looked up over footprints
};
/// At least one, for objects without a material.
std::vector<PreparedMaterial> prepareMaterials(const Scene &scene, const ScenePlan &plan);

/// The values of a material that looks the same everywhere, but for its colour.
MaterialValues valuesOf(const PreparedMaterial &prepared, const Vec3 &color);
/// A material's values where its colour and texture coordinates are these.
MaterialValues valuesAt(const PreparedMaterial &prepared, const Scene &scene, const Vec3 &color, const UvPoint &uv);

/// What a mesh says at a hit of how its material looks.
struct MeshValues {
    UvPoint uv;
    Vec4 color{1}; ///< of the mesh itself, linear RGBA
};
/// `at`: the point there; `wo`: unit, back along the ray; `coneWidth`: what a pixel sees, across the ray; 0: a point.
MeshValues meshValuesAt(const RenderObject &object, const Hit &hit, const InterpolatedSurface &at, const Vec3 &wo, float coneWidth);
/// Whether a triangle emits, on either side; and the radiance that leaves it to the side it is seen from, SurfaceGeometry::facing.
bool mayEmit(const RenderObject &object, Index triangle);
Vec3 emissionAt(const RenderObject &object, Index triangle, const Scene &scene, float facing, const UvPoint &uv);
/// A material's colour there.
inline Vec3 baseColorAt(const Material &material, const Scene &scene, const MeshValues &mesh) {
    Vec3 color = evaluateShare(material.color, scene, mesh.uv);
    if (material.vertexColors) color *= Vec3(mesh.color);
    return color;
}

/// What a material scatters by where it has these values, seen from that side; microsurfaces and the treatment of light of several
/// facets are the caller's.
Bsdf bsdfOf(const PreparedMaterial &prepared, const MaterialValues &values, float facing);

/// What is done about light of several facets where M is this; `metallic`: of kinds that read it.
Multiscatter treatmentAt(const PreparedMaterial &prepared, float metallic, const MicroTransform &m, bool tilted);

/// Fills the point for a hit at a time in the shutter. `wo` is the unit direction back along the ray, `coneWidth` what a pixel sees there
/// (ray_cone.h), in units of length across the ray; 0: a point.
SurfacePoint surfacePointAt(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const Hit &hit, const Vec3 &wo,
                            float time = 0, float coneWidth = 0);

/// A point as lights see it, `normal` its geometric one on the viewer's side.
inline Receiver receiverAt(const Vec3 &position, const Vec3 &normal, const Bsdf &bsdf) {
    return {position, mayTransmit(bsdf) ? Vec3(0) : normal};
}

/// The point moved off the surface, to the viewer's side or the other, far enough that a ray from there does not meet it again.
inline Vec3 offsetOrigin(const SurfacePoint &point, bool viewersSide) {
    return point.position + point.geometricNormal * (viewersSide ? point.clearance : -point.clearance);
}

} // namespace taut
