#pragma once
/// Texels compared with one another and with values.

#include "taut/scene/texture.h"

#include <algorithm>

namespace taut {

inline bool operator==(const SharedTexels &a, const SharedTexels &b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}
inline bool operator==(const SharedTexels &a, const std::vector<float> &b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

} // namespace taut
