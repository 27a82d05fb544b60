#include "study/measures/replay.h"

#include "taut/base/parallel.h"
#include "taut/base/stopwatch.h"
#include "taut/render/embree_packets.h"
#include "taut/render/frame_render.h"

#include <tbb/global_control.h>

#include <algorithm>

namespace taut::chart {

namespace {

constexpr std::size_t kGrain = 64;

/// Wall clock of the quickest of several runs; `prepare` restores what a run has overwritten and is not timed.
template <class Prepare, class Run> double quickest(int repetitions, const Prepare &prepare, const Run &run) {
    double best = kInfinity;
    for (int i = 0; i < repetitions; ++i) {
        prepare();
        Stopwatch watch;
        run();
        best = std::min(best, watch.lap());
    }
    return best;
}

template <int N, class Packet> std::vector<Packet> makePackets(const std::vector<Ray> &rays) {
    std::vector<Packet> packets((rays.size() + N - 1) / N);
    for (std::size_t i = 0; i < packets.size() * N; ++i) setLane(packets[i / N], i % N, rays[std::min(i, rays.size() - 1)]);
    return packets;
}

template <int N, class Packet> double replayPackets(RTCScene scene, const std::vector<Ray> &rays, bool coherent, int repetitions) {
    if (rays.empty()) return 0;
    const std::vector<Packet> original = makePackets<N, Packet>(rays);
    std::vector<Packet> packets;
    return quickest(
        repetitions, [&] { packets = original; },
        [&] {
            parallelFor(packets.size(), kGrain, [&](std::size_t i) {
                alignas(64) int valid[N];
                std::fill(valid, valid + N, -1);
                tracePacket(scene, valid, packets[i], coherent);
            });
        });
}

double replayShadows(RTCScene scene, const std::vector<Ray> &rays, int repetitions) {
    constexpr std::size_t kMost = ShadowRays::kMost;
    std::vector<ShadowRays> original((rays.size() + kMost - 1) / kMost);
    for (std::size_t i = 0; i < rays.size(); ++i) original[i / kMost].set(i % kMost, rays[i]);
    std::vector<ShadowRays> packets;
    return quickest(
        repetitions, [&] { packets = original; },
        [&] {
            parallelFor(packets.size(), 1024 / kMost,
                        [&](std::size_t i) { packets[i].trace(scene, std::min(kMost, rays.size() - i * kMost)); });
        });
}

} // namespace

RayRecord recordRays(const RenderScene &ready, int spp, std::uint32_t seed) {
    const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
    RayRecord record;
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    options.record = &record;
    renderFrame(ready, options);
    return record;
}

ReplayTimes replayRays(const EmbreeScene &scene, const RayRecord &record, int repetitions) {
    const auto native = static_cast<RTCScene>(scene.native());
    ReplayTimes times;
    times.camera = replayPackets<16, RTCRayHit16>(native, record.camera, true, repetitions);
    times.scattered = replayPackets<8, RTCRayHit8>(native, record.scattered, false, repetitions);
    times.shadow = replayShadows(native, record.shadow, repetitions);
    return times;
}

} // namespace taut::chart
