#include "taut/render/embree_scene.h"

#include "taut/base/error.h"
#include "taut/render/embree_packets.h"
#include "taut/render/triangle_pairs.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>
#include <sys/types.h>

namespace taut {

namespace {

void onError(void *, RTCError code, const char *message) {
    // Embree calls this where the error arises; throwing through its frames is not allowed, so errors are read after each commit.
    static_cast<void>(code);
    static_cast<void>(message);
}

/// Embree tells what it takes and gives back.
bool countBytes(void *count, ssize_t bytes, bool) {
    *static_cast<std::atomic<std::ptrdiff_t> *>(count) += bytes;
    return true;
}

/// Asked by Embree on the thread that traces, which has the batch's test here: of a context from elsewhere nothing could be known.
thread_local const SurfaceTest *currentTest = nullptr;

class WithTest {
  public:
    explicit WithTest(const SurfaceTest *test) { currentTest = test; }
    WithTest(const WithTest &) = delete;
    WithTest &operator=(const WithTest &) = delete;
    ~WithTest() { currentTest = nullptr; }
};

/// A hit of one BVH's geometry, or of an instance's: the outer one's number.
Index geometryOf(unsigned geometry, unsigned instance) {
    return instance == RTC_INVALID_GEOMETRY_ID ? geometry : instance;
}

void keepSurfaces(const RTCFilterFunctionNArguments *args) {
    if (currentTest == nullptr) return;
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        Hit hit;
        hit.t = RTCRayN_tfar(args->ray, args->N, i);
        hit.u = RTCHitN_u(args->hit, args->N, i);
        hit.v = RTCHitN_v(args->hit, args->N, i);
        hit.geometry = geometryOf(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_instID(args->hit, args->N, i, 0));
        hit.primitive = RTCHitN_primID(args->hit, args->N, i);
        if (const auto *pairs = static_cast<const TrianglePairs *>(args->geometryUserPtr)) pairs->toTriangle(hit);
        if (!currentTest->isThere(RTCRayN_id(args->ray, args->N, i), hit)) args->valid[i] = 0;
    }
}

/// Traces rays [begin, begin + N) as one packet, N wide.
template <int N, class Packet>
void intersectPacket(RTCScene scene, const std::vector<const TrianglePairs *> &pairs, std::span<const Ray> rays, std::size_t begin,
                     std::span<Hit> hits) {
    alignas(64) std::array<int, N> valid;
    alignas(64) Packet packet;
    const std::size_t count = std::min<std::size_t>(N, rays.size() - begin);
    for (std::size_t i = 0; i < N; ++i) {
        const Ray &ray = rays[begin + std::min(i, count - 1)];
        valid[i] = i < count && isTraceable(ray) ? -1 : 0; // what is not traced meets nothing
        setLane(packet, i, ray, static_cast<unsigned>(begin + i));
    }
    tracePacket(scene, valid.data(), packet, N == 16);
    for (std::size_t i = 0; i < count; ++i) {
        Hit &hit = hits[begin + i];
        hit.t = packet.ray.tfar[i];
        hit.u = packet.hit.u[i];
        hit.v = packet.hit.v[i];
        hit.geometry = geometryOf(packet.hit.geomID[i], packet.hit.instID[0][i]);
        hit.primitive = packet.hit.primID[i];
        if (hit.geometry != kNone && pairs[hit.geometry] != nullptr) pairs[hit.geometry]->toTriangle(hit);
    }
}

} // namespace

struct EmbreeScene::State {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    bool refits = false;
    std::atomic<std::ptrdiff_t> bytes{0};
    std::vector<RTCScene> instanced;                          ///< the BVHs behind instances
    std::vector<RTCScene> behind;                             ///< [geometries] that of an instance; null: none
    std::vector<unsigned> steps;                              ///< [geometries] times in the shutter
    std::vector<unsigned char> asks;                          ///< [geometries]
    std::vector<std::unique_ptr<const TrianglePairs>> meshes; ///< null: no quads
    std::vector<const TrianglePairs *> pairs;                 ///< [geometries] likewise

    /// Positions at one time or several.
    RTCGeometry geometry(const std::vector<std::span<const Vec3>> &positions, const MeshTriangles &mesh, RTCBuildQuality quality);
    Index attach(RTCGeometry geometry, std::size_t times, const TrianglePairs *pairsOf);
    Index instance(RTCScene of, std::size_t times, const TrianglePairs *pairsOf);
};

std::string_view embreeVersion() {
    return RTC_VERSION_STRING;
}

EmbreeScene::EmbreeScene(bool refits) : state_(std::make_unique<State>()) {
    state_->device = rtcNewDevice(nullptr);
    if (state_->device == nullptr) throw RunError("Embree could not start on this machine");
    rtcSetDeviceErrorFunction(state_->device, onError, nullptr);
    rtcSetDeviceMemoryMonitorFunction(state_->device, countBytes, &state_->bytes);
    state_->scene = rtcNewScene(state_->device);
    state_->refits = refits;
    if (!refits) return;
    // With this combination Embree refits instead of rebuilding; 3.13 with no other.
    rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(state_->scene, RTC_BUILD_QUALITY_LOW);
}

EmbreeScene::~EmbreeScene() {
    for (RTCScene scene : state_->instanced) rtcReleaseScene(scene);
    if (state_->scene != nullptr) rtcReleaseScene(state_->scene);
    if (state_->device != nullptr) rtcReleaseDevice(state_->device);
}

RTCGeometry EmbreeScene::State::geometry(const std::vector<std::span<const Vec3>> &positions, const MeshTriangles &mesh,
                                         RTCBuildQuality quality) {
    const bool mayBeRefitted = quality == RTC_BUILD_QUALITY_REFIT || (mesh.deforms && positions.size() == 1);
    const bool asQuads = kRefitsQuads || !mayBeRefitted;
    const TrianglePairs *made = meshes.emplace_back(asQuads ? std::make_unique<TrianglePairs>(mesh.triangles, mesh.places) : nullptr).get();
    RTCGeometry geometry = rtcNewGeometry(device, asQuads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(positions.size()));
    for (std::size_t step = 0; step < positions.size(); ++step)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(step), RTC_FORMAT_FLOAT3, positions[step].data(),
                                   0, sizeof(Vec3), positions[step].size() - 1);
    if (asQuads) {
        void *const corners =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof(QuadCorners), made->size());
        if (corners != nullptr) made->corners(mesh.triangles, {static_cast<QuadCorners *>(corners), made->size()});
        rtcSetGeometryUserData(geometry, const_cast<TrianglePairs *>(made)); // for filters, which read it alone
    } else {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0, sizeof(Index3),
                                   mesh.triangles.size());
    }
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcCommitGeometry(geometry);
    return geometry;
}

Index EmbreeScene::State::attach(RTCGeometry geometry, std::size_t times, const TrianglePairs *pairsOf) {
    const Index id = rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    steps.resize(std::max<std::size_t>(steps.size(), id + 1));
    steps[id] = static_cast<unsigned>(times);
    behind.resize(steps.size(), nullptr);
    asks.resize(steps.size(), 0);
    pairs.resize(steps.size(), nullptr);
    pairs[id] = pairsOf;
    return id;
}

Index EmbreeScene::State::instance(RTCScene of, std::size_t times, const TrianglePairs *pairsOf) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, of);
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(times));
    const Index id = attach(geometry, times, pairsOf);
    behind[id] = of;
    return id;
}

Index EmbreeScene::addTriangles(const std::vector<std::span<const Vec3>> &positions, const MeshTriangles &mesh) {
    const bool refits = state_->refits && positions.size() == 1;
    RTCGeometry geometry = state_->geometry(positions, mesh, refits ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_MEDIUM);
    return state_->attach(geometry, positions.size(), state_->meshes.back().get());
}

Index EmbreeScene::addInstance(std::span<const Vec3> positions, const MeshTriangles &mesh, std::span<const Affine> renderFromLocal) {
    RTCScene own = rtcNewScene(state_->device); // released with this
    state_->instanced.push_back(own);
    RTCGeometry geometry = state_->geometry({positions}, mesh, RTC_BUILD_QUALITY_MEDIUM);
    rtcAttachGeometry(own, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(own);
    const Index id = state_->instance(own, renderFromLocal.size(), state_->meshes.back().get());
    place(id, renderFromLocal);
    return id;
}

Index EmbreeScene::addInstanceOf(Index geometry, std::span<const Affine> renderFromLocal) {
    const Index id = state_->instance(state_->behind[geometry], renderFromLocal.size(), state_->pairs[geometry]);
    place(id, renderFromLocal);
    return id;
}

std::size_t EmbreeScene::instancedBvhs() const {
    return state_->instanced.size();
}

void EmbreeScene::ask(Index geometry, bool asks) {
    State &s = *state_;
    s.asks[geometry] = asks ? 1 : 0;
    RTCScene own = s.behind[geometry];
    bool any = asks; // of the instances of one BVH
    for (Index other = 0; own != nullptr && other < s.behind.size(); ++other) any |= s.behind[other] == own && s.asks[other] != 0;
    RTCGeometry triangles = own != nullptr ? rtcGetGeometry(own, 0) : rtcGetGeometry(s.scene, geometry);
    rtcSetGeometryIntersectFilterFunction(triangles, any ? keepSurfaces : nullptr);
    rtcSetGeometryOccludedFilterFunction(triangles, any ? keepSurfaces : nullptr);
    rtcCommitGeometry(triangles);
    if (own == nullptr) return;
    rtcCommitScene(own);
    rtcCommitGeometry(rtcGetGeometry(s.scene, geometry));
}

void EmbreeScene::place(Index geometry, std::span<const Affine> renderFromLocal) {
    RTCGeometry instance = rtcGetGeometry(state_->scene, geometry);
    for (unsigned step = 0; step < state_->steps[geometry]; ++step)
        rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &renderFromLocal[step][0][0]);
    rtcCommitGeometry(instance);
}

void EmbreeScene::update(Index geometry, bool rebuild) {
    RTCGeometry handle = rtcGetGeometry(state_->scene, geometry);
    for (unsigned step = 0; step < state_->steps[geometry]; ++step) rtcUpdateGeometryBuffer(handle, RTC_BUFFER_TYPE_VERTEX, step);
    // A refitting geometry is built anew when Embree believes that its topology has changed.
    if (rebuild) rtcUpdateGeometryBuffer(handle, RTC_BUFFER_TYPE_INDEX, 0);
    rtcCommitGeometry(handle);
}

void EmbreeScene::commit() {
    rtcCommitScene(state_->scene);
    const RTCError error = rtcGetDeviceError(state_->device);
    if (error != RTC_ERROR_NONE) throw RunError("Embree failed to build its scene (error " + std::to_string(static_cast<int>(error)) + ")");
}

void EmbreeScene::intersect(std::span<const Ray> rays, bool coherent, std::span<Hit> hits, const SurfaceTest *test) const {
    const WithTest with(test);
    if (coherent)
        for (std::size_t i = 0; i < rays.size(); i += 16) intersectPacket<16, RTCRayHit16>(state_->scene, state_->pairs, rays, i, hits);
    else
        for (std::size_t i = 0; i < rays.size(); i += 8) intersectPacket<8, RTCRayHit8>(state_->scene, state_->pairs, rays, i, hits);
}

void EmbreeScene::occluded(std::span<const Ray> rays, std::span<unsigned char> blocked, const SurfaceTest *test) const {
    const WithTest with(test);
    ShadowRays together;
    for (std::size_t begin = 0; begin < rays.size(); begin += ShadowRays::kMost) {
        const std::size_t count = std::min(ShadowRays::kMost, rays.size() - begin);
        for (std::size_t i = 0; i < count; ++i) together.set(i, rays[begin + i], static_cast<unsigned>(begin + i));
        together.trace(state_->scene, count);
        for (std::size_t i = 0; i < count; ++i) blocked[begin + i] = together.isBlocked(i) ? 1 : 0;
    }
}

std::size_t EmbreeScene::bytes() const {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, state_->bytes.load()));
}

std::size_t EmbreeScene::pairBytes() const {
    std::size_t bytes = 0;
    for (const auto &mesh : state_->meshes) bytes += mesh ? mesh->bytes() : 0;
    return bytes;
}

void *EmbreeScene::native() const {
    return state_->scene;
}

} // namespace taut
