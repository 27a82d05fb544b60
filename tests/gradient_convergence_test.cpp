/// Convergence of every gradient estimator and interpolation scheme towards closed forms, with the observed order.

#include "catch.h"

#include "study/measures/gradient_error.h"

#include "taut/base/frame.h"

#include <array>
#include <cstdio>

using namespace taut;
using namespace taut::chart;

namespace {

constexpr std::array<int, 5> kResolutions{8, 16, 32, 64, 128};
/// Below this, rounding of float positions is all that is left to see.
constexpr double kRounding = 2e-4;

struct Row {
    std::array<double, kResolutions.size()> rms;
    /// Between the finest pair that is above rounding.
    [[nodiscard]] double order() const {
        double best = 99; // exact from the start
        for (std::size_t i = 0; i + 1 < rms.size(); ++i)
            if (rms[i + 1] > kRounding) best = observedOrder(rms[i], rms[i + 1]);
        return best;
    }
};

template <class F> Row rowOf(const std::string &name, const std::string &what, const F &error) {
    Row row;
    for (std::size_t i = 0; i < row.rms.size(); ++i) row.rms[i] = error(kResolutions[i]).rms;
    std::printf("%-28s %-14s", name.c_str(), what.c_str());
    for (const double e : row.rms) std::printf(" %9.2e", e);
    std::printf("   order %.2f\n", row.order());
    return row;
}

} // namespace

TEST_CASE("Every estimator converges to the closed form with its order", "[gradient][convergence]") {
    for (const GradientCase &c : gradientCases())
        for (const auto &[estimator, name] : kEstimators) {
            if (estimator == GradientEstimator::Limit) continue; // these meshes are not subdivided
            INFO(c.name << ", " << name);
            const Row row = rowOf(c.name, name, [&, e = estimator](int n) { return estimatorError(c, e, n); });
            if (estimator == GradientEstimator::Face) {
                CHECK(row.order() > 0.8);
                CHECK(row.rms.back() < 0.03);
            } else if (estimator == GradientEstimator::Analytic && !c.skinned) {
                CHECK(row.rms.front() < 2e-6); // at any resolution
            } else {
                CHECK(row.order() > 1.8);
                CHECK(row.rms.back() < 2e-3);
            }
        }
}

TEST_CASE("Every interpolation converges to the closed form with its order", "[gradient][convergence]") {
    for (const GradientCase &c : gradientCases())
        for (const auto &[scheme, name] : kInterpolations) {
            INFO(c.name << ", " << name);
            const Row row = rowOf(c.name, name, [&, s = scheme](int n) { return interpolationError(c, s, n); });
            if (scheme == GradientInterpolation::Face)
                CHECK(row.order() > 0.9);
            else
                CHECK(row.order() > 1.8);
            CHECK(row.rms.back() < (scheme == GradientInterpolation::Face ? 0.03 : 1e-3));
        }
}

TEST_CASE("Every scheme gives back what it was given, at rest and collapsed too", "[gradient][interpolation]") {
    const Vec3 n = glm::normalize(Vec3(0.3F, -0.5F, 0.8F));
    const Frame frame = smoothFrameFromNormal(n);
    const std::vector<std::pair<Vec2, Vec2>> gradients{{{1, 0}, {0, 1}},           {{3, 0}, {0, 3}},        {{1, 0}, {7, 1}},
                                                       {{0.2F, 1.5F}, {-2, 0.1F}}, {{1e-3F, 0}, {0, 1e3F}}, {{1, 0}, {0, -0.5F}}};
    for (const auto &[ds, dt] : gradients) {
        const auto world = [&](const Vec2 &v) { return frame.s * v.x + frame.t * v.y; };
        const SymmetricTensor v = polarGradient(world(ds), world(dt), n).stretch;
        const Vec3 direct = seenIn(v, frame.s, frame.t);
        const float size = glm::length(direct);
        CHECK(glm::length(polarInFrame(ds, dt).stretch - direct) < 1e-5F * size);
        for (const auto scheme : {GradientInterpolation::Stretch, GradientInterpolation::Cholesky, GradientInterpolation::LogEuclidean}) {
            const SymmetricTensor stored = encodeStretch(scheme, v, frame.s, frame.t, n);
            CHECK(glm::length(decodeStretch(scheme, stored, frame.s, frame.t) - direct) < 2e-5F * size);
        }
    }
    // Collapsed: finite, and along what is left.
    const SymmetricTensor line = polarGradient(frame.s * 2.0F, frame.s * 1.0F, n).stretch;
    const SymmetricTensor nothing = polarGradient(Vec3(0), Vec3(0), n).stretch;
    for (const auto scheme : {GradientInterpolation::Stretch, GradientInterpolation::Cholesky, GradientInterpolation::LogEuclidean})
        for (const SymmetricTensor &v : {line, nothing}) {
            const Vec3 back = decodeStretch(scheme, encodeStretch(scheme, v, frame.s, frame.t, n), frame.s, frame.t);
            CHECK(isFinite(back));
            CHECK(glm::length(back - seenIn(v, frame.s, frame.t)) < 1e-3F);
        }
}

TEST_CASE("At rest, rigid and uniformly scaled, interpolation between corners that disagree changes nothing", "[gradient][interpolation]") {
    // Three corners of a strongly curved triangle: normals 60 degrees apart, tangent frames turned against each other.
    const std::array<Vec3, 3> normals{glm::normalize(Vec3(1, 0, 1)), glm::normalize(Vec3(-0.5F, 0.8F, 1)),
                                      glm::normalize(Vec3(-0.5F, -0.8F, 1))};
    const Frame at = smoothFrameFromNormal(glm::normalize(normals[0] + normals[1] + normals[2]));
    for (const float scale : {1.0F, 2.5F})
        for (const auto scheme : {GradientInterpolation::Stretch, GradientInterpolation::Cholesky, GradientInterpolation::LogEuclidean}) {
            SymmetricTensor mixed{Vec3(0), Vec3(0)};
            for (std::size_t k = 0; k < 3; ++k) {
                const Frame f = smoothFrameFromNormal(normals[k]);
                const float turn = 1.3F * static_cast<float>(k);
                const Vec3 t0 = f.s * std::cos(turn) + f.t * std::sin(turn);
                const Vec3 b0 = glm::cross(normals[k], t0);
                const SymmetricTensor stored =
                    encodeStretch(scheme, polarGradient(t0 * scale, b0 * scale, normals[k]).stretch, f.s, f.t, f.n);
                mixed.diagonal += stored.diagonal / 3.0F;
                mixed.offDiagonal += stored.offDiagonal / 3.0F;
            }
            const Vec3 v = decodeStretch(scheme, mixed, at.s, at.t);
            CHECK(glm::length(v - Vec3(scale, 0, scale)) < 1e-5F * scale);
        }
}
