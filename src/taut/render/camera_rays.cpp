#include "taut/render/camera_rays.h"

#include "taut/base/sobol.h"
#include "taut/base/warp.h"
#include "taut/render/pixel_filter.h"

namespace taut {

namespace {

/// How pixels lie on the plane at distance one.
struct PixelGrid {
    float pixelSize, halfWidth, halfHeight;
    std::uint32_t seed;
    bool independent; ///< every sample has random numbers of its own
};

[[gnu::always_inline]] inline void numbersLoop(const PixelGrid &grid, CameraLanes &l) {
    const int count = l.count;
    const std::uint32_t seed = grid.seed;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i)
        l.seed[i] = hash(static_cast<std::uint32_t>(l.x[i]) + 0x10000U * static_cast<std::uint32_t>(l.y[i]), seed);
    if (grid.independent)
#pragma GCC ivdep
        for (int i = 0; i < count; ++i) l.seed[i] = hash(l.seed[i], l.sample[i]);
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 u = sobolFourthFifth(l.sample[i], hash(l.seed[i], dimensionOf(0, kLightNumbers)), hash(l.seed[i], kFilterDimension));
        l.filterU[i] = u.x;
        l.filterV[i] = u.y;
    }
}

/// sampleFilter() of the box.
[[gnu::always_inline]] inline void boxLoop(CameraLanes &l) {
    const int count = l.count;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        l.u[i] = l.filterU[i] - 0.5F;
        l.v[i] = l.filterV[i] - 0.5F;
    }
}

/// From the offset within the pixel to the plane.
[[gnu::always_inline]] inline void placeLoop(const PixelGrid &grid, CameraLanes &l) {
    const int count = l.count;
    const PixelGrid g = grid;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        l.u[i] = (static_cast<float>(l.x[i]) + 0.5F + l.u[i] - g.halfWidth) * g.pixelSize;
        l.v[i] = (g.halfHeight - (static_cast<float>(l.y[i]) + 0.5F + l.v[i])) * g.pixelSize;
    }
}

[[gnu::always_inline]] inline void pinholeLoop(CameraLanes &l) {
    const int count = l.count;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const float inverse = 1 / std::sqrt(l.u[i] * l.u[i] + l.v[i] * l.v[i] + 1);
        l.origin.x[i] = l.origin.y[i] = l.origin.z[i] = 0;
        l.direction.x[i] = l.u[i] * inverse;
        l.direction.y[i] = l.v[i] * inverse;
        l.direction.z[i] = -inverse;
        l.time[i] = 0;
    }
}

/// Orthographic: from the plane through the camera, all one way.
[[gnu::always_inline]] inline void parallelLoop(CameraLanes &l) {
    const int count = l.count;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        l.origin.x[i] = l.u[i];
        l.origin.y[i] = l.v[i];
        l.direction.x[i] = l.direction.y[i] = l.origin.z[i] = 0;
        l.direction.z[i] = -1;
        l.time[i] = 0;
    }
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void numbers(const PixelGrid &g, CameraLanes &l) { numbersLoop(g, l); }                        \
        [[gnu::flatten __VA_ARGS__]] static void box(CameraLanes &l) { boxLoop(l); }                                                       \
        [[gnu::flatten __VA_ARGS__]] static void place(const PixelGrid &g, CameraLanes &l) { placeLoop(g, l); }                            \
        [[gnu::flatten __VA_ARGS__]] static void pinhole(CameraLanes &l) { pinholeLoop(l); }                                               \
        [[gnu::flatten __VA_ARGS__]] static void parallel(CameraLanes &l) { parallelLoop(l); }                                             \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

/// The rigid motion between the two steps around a time: linear in place, in rotation by Gram-Schmidt of the linear mean.
Affine rigidAt(const std::vector<Affine> &steps, float time) {
    Affine m = affineAt(steps, time);
    m[2] = glm::normalize(m[2]);
    m[0] = glm::normalize(m[0] - m[2] * glm::dot(m[0], m[2]));
    m[1] = glm::cross(m[2], m[0]);
    return m;
}

/// Lane `i` through the lens, or on its way along the others, from where the camera is at its time.
void throughLens(const RenderScene &scene, CameraLanes &l, std::size_t i) {
    const CameraState &camera = scene.camera();
    const bool moves = scene.cameraSteps().size() > 1;
    l.time[i] = scene.scene().render.shutter > 0 ? sobol1(l.sample[i], hash(l.seed[i], kTimeDimension)) : 0;
    const Vec3 through(l.u[i], l.v[i], -1);
    Vec3 origin(0);
    Vec3 direction = through;
    if (camera.orthoHeight > 0) {
        origin = Vec3(l.u[i], l.v[i], 0);
        direction = Vec3(0, 0, -1);
    } else if (camera.apertureRadius > 0) {
        const Vec2 u = sobol2(l.sample[i], hash(l.seed[i], kLensDimension));
        origin = Vec3(squareToDisk(u) * static_cast<float>(camera.apertureRadius), 0);
        direction = through * static_cast<float>(camera.focusDistance) - origin;
    }
    if (moves) {
        const Affine renderFromCamera = rigidAt(scene.cameraSteps(), l.time[i]);
        origin = transformPoint(renderFromCamera, origin);
        direction = transformVector(renderFromCamera, direction);
    }
    l.origin.set(i, origin);
    l.direction.set(i, glm::normalize(direction));
}

} // namespace

void cameraRays(const RenderScene &scene, const TraceSettings &settings, CameraLanes &l, Instructions instructions) {
    const CameraState &camera = scene.camera();
    const bool orthographic = camera.orthoHeight > 0;
    const double height = orthographic ? camera.orthoHeight : 2 * std::tan(0.5 * camera.fovY);
    const PixelGrid grid{static_cast<float>(height / settings.height), 0.5F * static_cast<float>(settings.width),
                         0.5F * static_cast<float>(settings.height), settings.seed, settings.independent};
    const bool still = camera.apertureRadius <= 0 && scene.cameraSteps().size() <= 1 && scene.scene().render.shutter <= 0;
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        Loops::numbers(grid, l);
        if (settings.boxFilter && !l.centred) {
            Loops::box(l);
        } else {
            const auto offsetOf = [&](std::size_t i) {
                if (l.centred) return Vec2(0);
                const Vec2 u(l.filterU[i], l.filterV[i]);
                return settings.shared ? sharedOffset(*settings.shared, l.x[i], l.y[i], u) : sampleFilter(settings.boxFilter, u);
            };
            for (std::size_t i = 0; i < static_cast<std::size_t>(l.count); ++i) {
                const Vec2 offset = offsetOf(i);
                l.u[i] = offset.x;
                l.v[i] = offset.y;
            }
        }
        Loops::place(grid, l);
        if (still) return orthographic ? Loops::parallel(l) : Loops::pinhole(l);
        for (std::size_t i = 0; i < static_cast<std::size_t>(l.count); ++i) throughLens(scene, l, i);
    });
}

} // namespace taut
