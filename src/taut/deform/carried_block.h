#pragma once
/// What a placement and deformers make of surface vertices whose control points rest: positions, tangents and normals of many at once,
/// structure of arrays, in loops that the compiler vectorises; the same bits as one by one.

#include "taut/base/instructions.h"
#include "taut/base/lanes.h"
#include "taut/deform/surface.h"
#include "taut/deform/surface_motion.h"

#include <atomic>
#include <span>

namespace taut {

/// The map of all of them: `carrier`, then the deformers, and with these `renderFromDeformed`.
struct CarryingMap {
    Affine carrier;       ///< of positions, from object space
    Mat3 carrierFromRest; ///< of tangents and normals, from rest space
    std::span<const Deformer> deformers;
    DMat4 renderFromDeformed;
};

struct CarriedBlock {
    static constexpr int kSize = 64;
    Lanes3<kSize> rest;          ///< in: position, object space
    Lanes3<kSize> restNormal;    ///< in: unit, rest space
    Lanes3<kSize> position;      ///< render space, as all that follows
    Lanes3<kSize> f1, f2, image; ///< F e1, F e2, F n
    Lanes3<kSize> normal;        ///< unit cross(f1, f2)
    float upright[kSize];        ///< > 0 where `normal` is right: elsewhere the parallelogram has collapsed
    int side[kSize];             ///< orientationOf() the deformers
};

/// Fills all but `rest` and `restNormal`, kSize entries of which must have values.
void carry(const CarryingMap &map, CarriedBlock &block, Instructions instructions = widest());

/// All surface vertices, into `out`, whose arrays have their size. `carriedSide` is orientationOf() what is not a deformer; `finite` is
/// cleared where a position is not.
void carryVertices(const Surface &surface, std::span<const Vec3> control, const CarryingMap &map, int carriedSide,
                   OrientationGatherer &orientation, std::atomic<bool> &finite, SurfaceGradient &out);

} // namespace taut
