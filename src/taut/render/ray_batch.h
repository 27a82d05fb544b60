#pragma once
/// Rays and hits as plain arrays, in render space, and the calls that trace a batch of them through Embree in the way that suits
/// each kind: camera rays 16 wide, scattered rays 8 wide, shadow rays as a stream where Embree has streams (embree_packets.h).

#include "taut/base/vec.h"

#include <vector>

namespace taut {

struct Ray {
    Vec3 origin;
    float nearest = 0;
    Vec3 direction;
    float farthest = kInfinity;
    float time = 0; ///< within the shutter, 0 to 1
};

struct Hit {
    float t = kInfinity;
    float u = 0, v = 0; ///< barycentrics of the second and third corner
    Index geometry = kNone;
    Index primitive = kNone;
};

} // namespace taut
