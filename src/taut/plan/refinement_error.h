#pragma once
/// How far a refined mesh is from its limit surface between its vertices, where everything is interpolated linearly.

#include "taut/scene/object_surface.h"

namespace taut {

/// What linear interpolation misses in the middle of an edge, by second differences over one-rings: root mean squares over the
/// vertices whose ring is closed, the greatest of the frames looked at. A level more divides each by four.
struct RefinementError {
    float normal = 0;   ///< radians
    float stretch = 0;  ///< of V, relative to its least stretch
    float position = 0; ///< metres along the normal
    float vertices = 0; ///< render vertices of the mesh
    // Box of the deformed mesh over the frames, world space, metres.
    Vec3 lower{kInfinity}, upper{-kInfinity};

    /// Takes in one frame of the object as it stands (deformAtFrame).
    void add(const ObjectSurface &object);
};

} // namespace taut
