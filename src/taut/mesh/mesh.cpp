#include "taut/mesh/mesh.h"

namespace taut {

Bounds boundsOf(const std::vector<Vec3> &points) {
    Bounds bounds;
    for (const Vec3 &p : points)
        if (isFinite(p)) bounds.add(p);
    return bounds;
}

} // namespace taut
