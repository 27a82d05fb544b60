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
    const RenderObject &object;
    const Index3 &corners;
    const UvPoint &uv;
    const InterpolatedSurface &at;
};

/// Slopes in the frame (t0, b0, n), n outward; 0 without a map.
SlopeStatistics slopesAt(const SlopeMap &map, const SlopePlace &place);

/// A facet in the point's shading frame, and its M in that of the facet.
struct HitFacet {
    Frame frame;
    MicroTransform micro;
    bool tilted = false; ///< else it is the mesh's own: `plain`
};
/// `slopes` as above, `sense` as SurfaceGeometry's.
HitFacet facetAt(const Material &material, const RestRoughness &rest, const SlopeStatistics &slopes, const SurfacePoint &point, float sense,
                 const MicroTransform &plain);

} // namespace taut
