#pragma once
/// polarGradient() of many vertices at once, structure of arrays, in loops that the compiler vectorises; the same bits as one by one.

#include "taut/base/instructions.h"
#include "taut/deform/stretch.h"

#include <cstddef>

namespace taut {

/// Up to kSize vertices: their gradient along e1 and e2, the coefficients of their rest tangent frame, and what comes of them.
struct PolarBlock {
    static constexpr std::size_t kSize = 64;
    float f1[3][kSize], f2[3][kSize], n[3][kSize];
    float coefficients[4][kSize]; ///< ds = x f1 + y f2, dt = z f1 + w f2
    float diagonal[3][kSize], offDiagonal[3][kSize], tangent[4][kSize];

    void set(std::size_t i, const Vec3 &alongE1, const Vec3 &alongE2, const Vec3 &normal, const Vec4 &tangentCoefficients) {
        for (int c = 0; c < 3; ++c) {
            f1[c][i] = alongE1[c];
            f2[c][i] = alongE2[c];
            n[c][i] = normal[c];
        }
        for (int c = 0; c < 4; ++c) coefficients[c][i] = tangentCoefficients[c];
    }
    [[nodiscard]] PolarGradient at(std::size_t i) const {
        return {{{diagonal[0][i], diagonal[1][i], diagonal[2][i]}, {offDiagonal[0][i], offDiagonal[1][i], offDiagonal[2][i]}},
                {tangent[0][i], tangent[1][i], tangent[2][i], tangent[3][i]}};
    }
};

/// Fills diagonal, offDiagonal and tangent of all kSize entries, all of which must have values.
void splitPolar(PolarBlock &block, Instructions instructions = widest());

} // namespace taut
