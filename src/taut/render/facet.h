#pragma once
/// From a hit to its facet of the mesostructure: slopes of a material's map, carried along with the mesh.

#include "taut/microsurface/mesostructure.h"
#include "taut/render/shading.h"
#include "taut/scene/material_gloss.h"

namespace taut {

/// How a point's uv lies on its triangle at rest: dP/du = (ux, 0), dP/dv = (vx, vy) in metres, x along the tangent, y along b0.
struct UvMetric {
    float ux = 1, vx = 0, vy = 1;
};

/// What slopes are looked up by, of one point.
struct SlopePlace {
    const Scene &scene;
    const SurfacePoint &point;
    const InterpolatedSurface &at;
    float sense; ///< SurfaceGeometry
};

/// Slopes in the frame (t0, b0, n), n on the viewer's side; 0 without a map.
SlopeStatistics slopesAt(const SlopeMap &map, const SlopePlace &place);

/// The mesh's deformation there, F, from the rest frame (t0, b0, n) to the point's shading frame, over lambda.
DMat3 deformationOf(const Material &material, const SurfacePoint &point, float sense);

/// A facet in the point's shading frame, and its M in that of the facet.
struct HitFacet {
    Frame frame;
    MicroTransform micro;
    bool tilted = false; ///< else it is the mesh's own: `plain`
};
HitFacet facetAt(const Material &material, const RestRoughness &rest, const SlopeStatistics &slopes, const SurfacePoint &point, float sense,
                 const MicroTransform &plain);

} // namespace taut
