#pragma once
/// What a mesh's surface gradient does over its frames: the numbers that a plan's predictions are made from.

#include "taut/scene/object_surface.h"

namespace taut {

/// Extremes over all vertices and the frames looked at. Differences of tensors are relative: the Frobenius norm of the difference
/// over the smaller tensor's least stretch, an upper bound of the change of any stretch.
struct GradientField {
    float greatestStretch = 1; ///< singular values of A
    float leastStretch = 1;
    float greatestShear = 0;    ///< |s.dt| / |t.dt|
    float logStretch = 0;       ///< |log sigma|: how far from rest
    float fromMean = 0;         ///< V from its mean over the mesh
    float withinFace = 0;       ///< V of a corner from the mean of its triangle
    float lean = 0;             ///< |tangential part of F n0| / lambda
    float logNormalStretch = 0; ///< |log lambda|, lambda = (F n0).n
    std::size_t collapsed = 0;  ///< most vertices at once whose smaller stretch is under 1e-3 of the larger
    std::size_t folded = 0;     ///< most triangles at once that turned over against their vertex normals

    /// Takes in one frame of the object as it stands (deformAtFrame).
    void add(const ObjectSurface &object);
    /// Takes in other frames.
    void add(const GradientField &other);
};

} // namespace taut
