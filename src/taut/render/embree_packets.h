#pragma once
/// Our rays in Embree's own layouts. Internal to render/: includes Embree's header.

#include "taut/render/ray_batch.h"

#include <embree3/rtcore.h>

namespace taut {

/// Puts a ray into one lane of an RTCRayHit8 / RTCRayHit16; `id` is what filters know it by.
template <class Packet> void setLane(Packet &packet, std::size_t lane, const Ray &ray, unsigned id = 0) {
    packet.ray.org_x[lane] = ray.origin.x;
    packet.ray.org_y[lane] = ray.origin.y;
    packet.ray.org_z[lane] = ray.origin.z;
    packet.ray.dir_x[lane] = ray.direction.x;
    packet.ray.dir_y[lane] = ray.direction.y;
    packet.ray.dir_z[lane] = ray.direction.z;
    packet.ray.tnear[lane] = ray.nearest;
    packet.ray.tfar[lane] = ray.farthest;
    packet.ray.time[lane] = ray.time;
    packet.ray.mask[lane] = 0xffffffffU;
    packet.ray.id[lane] = id;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
}

/// A shadow ray for Embree's stream calls.
inline RTCRay shadowRay(const Ray &ray, unsigned id = 0) {
    return {ray.origin.x,
            ray.origin.y,
            ray.origin.z,
            ray.nearest,
            ray.direction.x,
            ray.direction.y,
            ray.direction.z,
            ray.time,
            ray.farthest,
            0xffffffffU,
            id,
            0};
}

} // namespace taut
