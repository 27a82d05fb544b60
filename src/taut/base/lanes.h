#pragma once
/// Structure of arrays for loops that the compiler vectorises.

#include "taut/base/vec.h"

namespace taut {

/// Lanes of vectors.
template <int kSize> struct Lanes3 {
    float x[kSize], y[kSize], z[kSize];
    [[nodiscard]] Vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
    void set(std::size_t i, const Vec3 &v) {
        x[i] = v.x;
        y[i] = v.y;
        z[i] = v.z;
    }
};

} // namespace taut
