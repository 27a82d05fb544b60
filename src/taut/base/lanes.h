#pragma once
/// Structure of arrays for loops that the compiler vectorises.

#include "taut/base/vec.h"

namespace taut {

/// Lanes of vectors.
template <int kSize, class T = float> struct Lanes3 {
    T x[kSize], y[kSize], z[kSize];
    [[nodiscard]] Vector3<T> at(std::size_t i) const { return {x[i], y[i], z[i]}; }
    void set(std::size_t i, const Vector3<T> &v) {
        x[i] = v.x;
        y[i] = v.y;
        z[i] = v.z;
    }
};

} // namespace taut
