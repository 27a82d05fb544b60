#include "taut/deform/polar_batch.h"

namespace taut {

namespace {

[[gnu::always_inline]] inline void splitLoop(PolarBlock &block) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < PolarBlock::kSize; ++i) {
        const Vec3 f1(block.f1[0][i], block.f1[1][i], block.f1[2][i]);
        const Vec3 f2(block.f2[0][i], block.f2[1][i], block.f2[2][i]);
        const Vec3 n(block.n[0][i], block.n[1][i], block.n[2][i]);
        const Vec4 k(block.coefficients[0][i], block.coefficients[1][i], block.coefficients[2][i], block.coefficients[3][i]);
        const Tangents image = tangentsFrom(k, f1, f2);
        const PolarGradient polar = polarGradient(image.ds, image.dt, n);
        block.diagonal[0][i] = polar.stretch.diagonal.x;
        block.diagonal[1][i] = polar.stretch.diagonal.y;
        block.diagonal[2][i] = polar.stretch.diagonal.z;
        block.offDiagonal[0][i] = polar.stretch.offDiagonal.x;
        block.offDiagonal[1][i] = polar.stretch.offDiagonal.y;
        block.offDiagonal[2][i] = polar.stretch.offDiagonal.z;
        block.tangent[0][i] = polar.tangent.x;
        block.tangent[1][i] = polar.tangent.y;
        block.tangent[2][i] = polar.tangent.z;
        block.tangent[3][i] = polar.tangent.w;
    }
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void split(PolarBlock &block) { splitLoop(block); }                                            \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

void splitPolar(PolarBlock &block, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) { decltype(loops)::split(block); });
}

} // namespace taut
