#pragma once
/// Trivariate Bernstein free-form deformation (Sederberg & Parry, "Free-form deformation of solid geometric models", 1986).
///
/// Inside the box the map is FFD(x) = sum_ijk B_i(u) B_j(v) B_k(w) P_ijk, with (u, v, w) the position in the box and
/// undisplaced control points on a regular grid, for which FFD is the identity. Outside it is FFD(clamped x) + (x - clamped x).

#include "taut/deform/deformer.h"

namespace taut {

/// Most control points along one axis.
inline constexpr int kMaxLatticePoints = 16;

/// The displaced control points at a frame, x fastest; object space. Empty where the lattice is malformed (point counts
/// outside [2, kMaxLatticePoints], a box without volume): such a lattice is the identity.
void latticeControlAtFrame(const DeformerKeys &keys, double frame, std::vector<DVec3> &control);

/// Image and Jacobian of a point of object space.
DeformedPoint deformByLattice(const Deformer &deformer, const DVec3 &position);

/// True where no control point is displaced, or the lattice is malformed.
bool isLatticeIdentity(const Deformer &deformer);

/// Bernstein polynomials of degree points - 1 at `u` and their derivatives; they sum to 1 and 0. 2 <= points <= 16.
struct BernsteinBasis {
    std::array<double, kMaxLatticePoints> value{};
    std::array<double, kMaxLatticePoints> derivative{};
};
BernsteinBasis bernsteinBasis(int points, double u);

} // namespace taut
