#pragma once
/// Roughness that is added to what geometry makes of a microsurface: slopes that have nothing to do with those that are there.
///
/// Metal that is strained beyond its elastic limit roughens, by grains that turn against each other: its roughness grows in proportion to
/// the plastic strain and the size of the grains (Stoudt & Ricker 2002, Metall. Mater. Trans. A 33, 2883; more than that where they are
/// coarse: Stoudt, Hubbard & Leigh 2011, ibid. 42; over scales: Zaiser et al. 2004, Phys. Rev. Lett. 93, 195507). As a slope that is
/// alpha = roughening (eps - yield), eps the equivalent Hencky strain of the surface with the thickness from volume:
///
///     Sigma' = Sigma + alpha^2 I.
///
/// In slope tensors that sum is exact for Gaussian slopes and a model for GGX.

#include "taut/microsurface/transform.h"

namespace taut {

/// eps of a surface with the singular values `larger` and `smaller` of A: e1 and e2 their logarithms, e3 = -(e1 + e2), and
/// eps = sqrt(2/3 (e1^2 + e2^2 + e3^2)). A collapsed surface counts as stretched by kLeastSingularValue.
inline double equivalentStrain(double larger, double smaller) {
    const double least = static_cast<double>(kLeastSingularValue);
    const double e1 = std::log(std::fmax(larger, least));
    const double e2 = std::log(std::fmax(smaller, least));
    return std::sqrt(4.0 / 3 * (e1 * e1 + e1 * e2 + e2 * e2));
}

/// The alpha that a strain adds.
inline double addedAlpha(double strain, double roughening, double yield) {
    return roughening * std::fmax(0.0, strain - yield);
}

/// M whose slope tensor Sigma is that of `m` plus [xx xy; xy yy], not negative; its lean is kept.
inline MicroTransform withAddedSlopes(const MicroTransform &m, double xx, double xy, double yy) {
    const auto wide = canonicalTransform<double>(static_cast<double>(m.a), static_cast<double>(m.b), static_cast<double>(m.d));
    const SlopeTensor<double> s = slopeTensor(wide);
    const double sumXX = s.xx + xx;
    const double sumXY = s.xy + xy;
    // det(S + X) by terms that do not cancel where X is isotropic.
    const double det = s.determinant + (s.xx * yy + s.yy * xx - 2 * s.xy * xy) + std::fmax(0.0, xx * yy - xy * xy);
    // (a, b, d) of M M^T = (S + X)^-1.
    return microTransform(1 / std::sqrt(sumXX), -sumXY / std::sqrt(sumXX * det), 0, std::sqrt(sumXX / det), static_cast<double>(m.p),
                          static_cast<double>(m.q));
}
/// Isotropic slopes: a roughened surface. 0 leaves the bits alone.
inline MicroTransform roughened(const MicroTransform &m, double alpha) {
    return alpha > 0 ? withAddedSlopes(m, alpha * alpha, 0, alpha * alpha) : m;
}

} // namespace taut
