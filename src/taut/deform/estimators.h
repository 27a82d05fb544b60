#pragma once
/// The ways to compute a surface gradient and to interpolate it within a triangle, with their names in scene files and reports.

#include "taut/deform/gradient_interpolation.h"
#include "taut/deform/surface.h"

#include <array>
#include <string>

namespace taut {

/// How a surface gradient is computed. All but Analytic use final positions alone.
enum class GradientEstimator {
    Face,         ///< constant per triangle (face_gradient.h); first order
    Area,         ///< area-weighted mean of the faces around a vertex
    Angle,        ///< angle-weighted mean
    LeastSquares, ///< the one-ring's best linear map
    Limit,        ///< exact derivatives of the limit surface (subdivided meshes)
    Analytic,     ///< carried through skin and deformers; from an Area fit where control points move by themselves
};

template <class E> struct Named {
    E value;
    const char *name;
};
inline constexpr std::array<Named<GradientEstimator>, 6> kEstimators{{{GradientEstimator::Face, "face"},
                                                                      {GradientEstimator::Area, "area"},
                                                                      {GradientEstimator::Angle, "angle"},
                                                                      {GradientEstimator::LeastSquares, "least-squares"},
                                                                      {GradientEstimator::Limit, "limit"},
                                                                      {GradientEstimator::Analytic, "analytic"}}};
inline constexpr std::array<Named<GradientInterpolation>, 5> kInterpolations{{{GradientInterpolation::Stretch, "stretch"},
                                                                              {GradientInterpolation::DsDt, "ds-dt"},
                                                                              {GradientInterpolation::Cholesky, "cholesky"},
                                                                              {GradientInterpolation::LogEuclidean, "log"},
                                                                              {GradientInterpolation::Face, "face"}}};

template <class E, std::size_t N> std::string nameIn(const std::array<Named<E>, N> &table, E value) {
    for (const auto &[known, name] : table)
        if (known == value) return name;
    return {};
}
inline std::string nameOf(GradientEstimator estimator) {
    return nameIn(kEstimators, estimator);
}
inline std::string nameOf(GradientInterpolation interpolation) {
    return nameIn(kInterpolations, interpolation);
}

/// The fit that an estimator takes where it takes one.
inline GradientFit fitOf(GradientEstimator estimator) {
    if (estimator == GradientEstimator::Angle) return GradientFit::Angle;
    return estimator == GradientEstimator::LeastSquares ? GradientFit::LeastSquares : GradientFit::Area;
}

} // namespace taut
