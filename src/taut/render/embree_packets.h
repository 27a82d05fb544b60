#pragma once
/// Our rays in Embree's own layouts, traced in the widths that suit each kind, by Embree 3 (Debian 12) or 4 (Debian 13): all that
/// differs between the two is here. Internal to render/: includes Embree's header.

#include "taut/render/ray_batch.h"

#include <array>

#if TAUT_EMBREE == 3 // the build's
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <cmath>

namespace taut {

/// Whether Embree takes a ray: it ends the process at one that is not finite, or beyond some 1.8e18 (its FLT_LARGE), where debugging is
/// compiled in as in Debian's. Not a number is in no range.
inline bool isTraceable(const Ray &ray) {
    const Vec3 o = glm::abs(ray.origin);
    const Vec3 d = glm::abs(ray.direction);
    return o.x + o.y + o.z + d.x + d.y + d.z < 1.8e18F && ray.nearest < 1.8e18F && !std::isnan(ray.farthest);
}

/// For shadow rays that Embree does not take: it meets nothing, and counts as blocked.
inline const Ray &traceable(const Ray &ray) {
    static const Ray inert{Vec3(0), 0, Vec3(0, 0, 1), -1, 0};
    return isTraceable(ray) ? ray : inert;
}

/// Puts a ray into one lane of an RTCRay8 / RTCRay16; `id` is what filters know it by.
template <class Lanes> void setRay(Lanes &rays, std::size_t lane, const Ray &ray, unsigned id = 0) {
    rays.org_x[lane] = ray.origin.x;
    rays.org_y[lane] = ray.origin.y;
    rays.org_z[lane] = ray.origin.z;
    rays.dir_x[lane] = ray.direction.x;
    rays.dir_y[lane] = ray.direction.y;
    rays.dir_z[lane] = ray.direction.z;
    rays.tnear[lane] = ray.nearest;
    rays.tfar[lane] = ray.farthest;
    rays.time[lane] = ray.time;
    rays.mask[lane] = 0xffffffffU;
    rays.id[lane] = id;
    rays.flags[lane] = 0;
}

/// Into one of an RTCRayHit8 / RTCRayHit16, which has no hit yet.
template <class Packet> void setLane(Packet &packet, std::size_t lane, const Ray &ray, unsigned id = 0) {
    setRay(packet.ray, lane, ray, id);
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
}

/// `valid`: 8 or 16 integers, -1 for rays that count; aligned to 32 or 64 bytes. `coherent`: neighbours side by side.
#if TAUT_EMBREE == 3
inline RTCIntersectContext traceContext(bool coherent) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}
inline void tracePacket(RTCScene scene, const int *valid, RTCRayHit8 &packet, bool coherent) {
    RTCIntersectContext context = traceContext(coherent);
    rtcIntersect8(valid, scene, &context, &packet);
}
inline void tracePacket(RTCScene scene, const int *valid, RTCRayHit16 &packet, bool coherent) {
    RTCIntersectContext context = traceContext(coherent);
    rtcIntersect16(valid, scene, &context, &packet);
}
#else
inline RTCIntersectArguments traceArguments(bool coherent) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    return arguments;
}
inline void tracePacket(RTCScene scene, const int *valid, RTCRayHit8 &packet, bool coherent) {
    RTCIntersectArguments arguments = traceArguments(coherent);
    rtcIntersect8(valid, scene, &packet, &arguments);
}
inline void tracePacket(RTCScene scene, const int *valid, RTCRayHit16 &packet, bool coherent) {
    RTCIntersectArguments arguments = traceArguments(coherent);
    rtcIntersect16(valid, scene, &packet, &arguments);
}
#endif

/// Embree 4.3 leaves some quads where they were when it refits them (found by a test: one ray in six met a sheet that had moved away);
/// there what may be refitted stays triangles.
inline constexpr bool kRefitsQuads = TAUT_EMBREE == 3;

/// Shadow rays that are traced together.
#if TAUT_EMBREE == 3
class ShadowRays { ///< a stream
  public:
    static constexpr std::size_t kMost = 256;
    void set(std::size_t i, const Ray &given, unsigned id = 0) {
        const Ray &ray = traceable(given);
        rays_[i] = {ray.origin.x,
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
    /// The first `count`, which have been set.
    void trace(RTCScene scene, std::size_t count) {
        rtcOccluded1M(scene, &context_, rays_.data(), static_cast<unsigned>(count), sizeof(RTCRay));
    }
    [[nodiscard]] bool isBlocked(std::size_t i) const { return rays_[i].tfar < 0; }

  private:
    std::array<RTCRay, kMost> rays_;
    RTCIntersectContext context_ = traceContext(false);
};
#else
class ShadowRays { ///< a packet: Embree 4 has no streams
  public:
    static constexpr std::size_t kMost = 16;
    void set(std::size_t i, const Ray &ray, unsigned id = 0) { setRay(rays_, i, traceable(ray), id); }
    void trace(RTCScene scene, std::size_t count) {
        for (std::size_t i = 0; i < kMost; ++i) valid_[i] = i < count ? -1 : 0;
        RTCOccludedArguments arguments;
        rtcInitOccludedArguments(&arguments);
        rtcOccluded16(valid_.data(), scene, &rays_, &arguments);
    }
    [[nodiscard]] bool isBlocked(std::size_t i) const { return rays_.tfar[i] < 0; }

  private:
    RTCRay16 rays_;
    alignas(64) std::array<int, kMost> valid_;
};
#endif

} // namespace taut
