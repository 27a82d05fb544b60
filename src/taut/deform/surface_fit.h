#pragma once
/// The stencils of a Surface: how its gradient is had from positions. One interface for the fits over the faces around a vertex
/// and for the limit derivatives of a subdivided mesh; used by buildSurface().

#include "taut/deform/surface.h"

#include <span>

namespace taut {

struct FitInput {
    const Mesh &mesh;
    std::span<const Index> canonical;     ///< [positions], weldPositions()
    std::span<const Vec3> rest;           ///< [positions], rest space
    std::span<const Index> cornerSurface; ///< [corners] -> surface vertex
    std::span<const Index> surfaceNormal; ///< [surface vertices] -> normal of a limit surface; else empty
};

/// Whether the options ask for the derivatives of a limit surface (level 0 has none).
inline bool isLimit(const SurfaceOptions &options) {
    return options.limit != nullptr && options.limit->positions.rowCount() > 0 && options.limit->tangents.offsets.size() > 1;
}

/// Fills the stencils and slopes of surface vertices that have their position, normal and frame.
void makeFits(const FitInput &input, const SurfaceOptions &options, Surface &surface);

} // namespace taut
