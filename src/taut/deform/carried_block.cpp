#include "taut/deform/carried_block.h"

#include "taut/base/parallel.h"
#include "taut/deform/surface_normal.h"

#define TAUT_INLINE [[gnu::always_inline]] inline

namespace taut {

namespace {

constexpr int kSize = CarriedBlock::kSize;
using Wide3 = Lanes3<kSize, double>;

/// Positions, tangents and normals on their way through the deformers.
struct Wide {
    Wide3 x, f1, f2, n;
};

TAUT_INLINE void carrierLoop(const CarryingMap &map, CarriedBlock &b) {
    const Affine carrier = map.carrier;
    const Mat3 linear = map.carrierFromRest;
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) {
        const Frame frame = quickFrameFromNormal(b.restNormal.at(i));
        b.position.set(i, transformPoint(carrier, b.rest.at(i)));
        b.f1.set(i, linear * frame.s);
        b.f2.set(i, linear * frame.t);
        b.image.set(i, linear * frame.n);
    }
}

TAUT_INLINE void linearLoop(const DMat3 &map, Wide3 &rows) {
    const DMat3 m = map; // no store can change this one
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) rows.set(i, m * rows.at(i));
}

/// Deformers whose Jacobian is the same everywhere: the formulas of deform().
TAUT_INLINE bool linearDeformer(const Deformer &deformer, Wide &w) {
    const DeformerKeys &keys = deformer.keys;
    const DVec3 centre = keys.centre;
    if (keys.type == DeformerType::Shear) {
        double *const rows[] = {w.x.x, w.x.y, w.x.z};
        double *const moved = rows[keys.axis];
        const double *const along = rows[keys.axis2];
        const double amount = deformer.amount;
        const double from = centre[keys.axis2];
        for (std::size_t i = 0; i < kSize; ++i) moved[i] += amount * (along[i] - from);
    } else if (keys.type == DeformerType::Stretch) {
        const DVec3 factor = deformer.factor;
#pragma GCC ivdep
        for (std::size_t i = 0; i < kSize; ++i) w.x.set(i, centre + factor * (w.x.at(i) - centre));
    } else {
        return false;
    }
    return true;
}

TAUT_INLINE void deformersLoop(const CarryingMap &map, CarriedBlock &b) {
    Wide w;
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) {
        w.x.set(i, DVec3(b.position.at(i)));
        w.f1.set(i, DVec3(b.f1.at(i)));
        w.f2.set(i, DVec3(b.f2.at(i)));
        w.n.set(i, DVec3(b.image.at(i)));
    }
    for (const Deformer &deformer : map.deformers) {
        const DMat3 same = deform(deformer, deformer.keys.centre).jacobian;
        if (linearDeformer(deformer, w)) {
            const int side = orientationOf(same);
            for (std::size_t i = 0; i < kSize; ++i) b.side[i] *= side;
            for (auto *rows : {&w.f1, &w.f2, &w.n}) linearLoop(same, *rows);
            continue;
        }
        for (std::size_t i = 0; i < kSize; ++i) {
            const DeformedPoint image = deform(deformer, w.x.at(i));
            b.side[i] *= orientationOf(image.jacobian);
            w.x.set(i, image.position);
            for (auto *rows : {&w.f1, &w.f2, &w.n}) rows->set(i, image.jacobian * rows->at(i));
        }
    }
    const DMat4 placed = map.renderFromDeformed;
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) w.x.set(i, DVec3(placed * DVec4(w.x.at(i), 1)));
    for (auto *rows : {&w.f1, &w.f2, &w.n}) linearLoop(DMat3(placed), *rows);
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) {
        b.position.set(i, Vec3(w.x.at(i)));
        b.f1.set(i, Vec3(w.f1.at(i)));
        b.f2.set(i, Vec3(w.f2.at(i)));
        b.image.set(i, Vec3(w.n.at(i)));
    }
}

TAUT_INLINE void normalLoop(CarriedBlock &b) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < kSize; ++i) {
        const Vec3 f1 = b.f1.at(i);
        const Vec3 f2 = b.f2.at(i);
        const Vec3 n = glm::cross(f1, f2);
        const float area = glm::length(n);
        const float least = std::max(kCollapsedArea, kCollapsedSine * glm::length(f1) * glm::length(f2));
        b.upright[i] = (area < kInfinity) & (area > least) ? 1.0F : 0.0F;
        b.normal.set(i, n / area);
    }
}

TAUT_INLINE void carryLoops(const CarryingMap &map, CarriedBlock &b) {
    carrierLoop(map, b);
    for (int &side : b.side) side = 1;
    if (!map.deformers.empty()) deformersLoop(map, b);
    normalLoop(b);
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void carry(const CarryingMap &map, CarriedBlock &block) { carryLoops(map, block); }            \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

void carry(const CarryingMap &map, CarriedBlock &block, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) { decltype(loops)::carry(map, block); });
}

void carryVertices(const Surface &surface, std::span<const Vec3> control, const CarryingMap &map, int carriedSide,
                   OrientationGatherer &orientation, std::atomic<bool> &finite, SurfaceGradient &out) {
    constexpr std::size_t kSize = CarriedBlock::kSize;
    constexpr std::size_t kGrain = kVertexGrain / kSize;
    const std::size_t count = surface.normals.size();
    parallelFor((count + kSize - 1) / kSize, kGrain, [&](std::size_t b) {
        const std::size_t begin = b * kSize;
        const std::size_t size = std::min(kSize, count - begin);
        CarriedBlock block;
        for (std::size_t i = 0; i < kSize; ++i) {
            const std::size_t s = begin + std::min(i, size - 1); // the last one fills the block
            block.rest.set(i, control[surface.surfacePosition[s]]);
            block.restNormal.set(i, surface.normals[s]);
        }
        carry(map, block);
        bool allFinite = true;
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t s = begin + i;
            const Vec3 f1 = block.f1.at(i);
            const Vec3 f2 = block.f2.at(i);
            const Vec3 n = block.image.at(i);
            const bool mirrored = orientation.set(s, carriedSide * block.side[i]);
            const Vec3 normal = block.upright[i] > 0 ? block.normal.at(i) : normalOf(f1, f2, mirrored ? -n : n);
            out.position[s] = block.position.at(i);
            out.f1[s] = f1;
            out.f2[s] = f2;
            out.normal[s] = mirrored ? -normal : normal;
            if (out.wantNormalImage) out.normalImage[s] = n;
            allFinite &= isFinite(out.position[s]);
        }
        if (!allFinite) finite = false;
    });
}

} // namespace taut
