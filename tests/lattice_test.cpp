#include "taut/deform/lattice.h"

#include "catch.h"
#include "deformer_fixtures.h"

using namespace taut;
using namespace taut::test::deformers;

TEST_CASE("Bernstein polynomials are those of the binomial theorem and sum to one", "[deformer][lattice]") {
    Random random;
    for (int points = 2; points <= kMaxLatticePoints; ++points)
        for (const double u : {0.0, 1.0, 0.5, random.uniform(0, 1), random.uniform(0, 1)}) {
            const BernsteinBasis basis = bernsteinBasis(points, u);
            const int n = points - 1;
            double sum = 0;
            double derivativeSum = 0;
            double mean = 0;
            double binomial = 1;
            for (int i = 0; i <= n; ++i) {
                const auto index = static_cast<std::size_t>(i);
                CHECK(basis.value[index] == Approx(binomial * std::pow(u, i) * std::pow(1 - u, n - i)).epsilon(1e-13).margin(1e-300));
                sum += basis.value[index];
                derivativeSum += basis.derivative[index];
                mean += basis.value[index] * i / n;
                binomial = binomial * (n - i) / (i + 1);
            }
            CHECK(sum == Approx(1).epsilon(1e-15));
            CHECK(std::fabs(derivativeSum) < 1e-13);
            CHECK(mean == Approx(u).epsilon(1e-14)); // linear precision
        }
}

TEST_CASE("A lattice displaced affinely gives the affine map", "[deformer][lattice]") {
    Random random;
    for (const std::array<int, 3> points : {std::array{2, 2, 2}, std::array{3, 4, 5}, std::array{16, 2, 7}}) {
        const DMat3 linear(random.point(-2, 2), random.point(-2, 2), random.point(-2, 2));
        const DVec3 shift = random.point(-2, 2);
        const DVec3 lower(-1, -2, 0.5);
        const DVec3 upper(1, 0.5, 3);
        const Deformer deformer = deformerAtFrame(latticeKeys(points, lower, upper, [&](const DVec3 &p) { return linear * p + shift; }), 0);
        CHECK_FALSE(isIdentity(deformer));
        for (int trial = 0; trial < 100; ++trial) {
            const DVec3 p = lower + random.point(0, 1) * (upper - lower);
            const DeformedPoint image = deform(deformer, p);
            CHECK(maxDifference(image.position, linear * p + shift) < 2e-14);
            CHECK(maxDifference(image.jacobian, linear) < 2e-13);
        }
        // Outside, the overshoot is added undeformed.
        const DeformedPoint outside = deform(deformer, {2, 0, 1});
        CHECK(maxDifference(outside.position, linear * DVec3(1, 0, 1) + shift + DVec3(1, 0, 0)) < 2e-14);
        CHECK(outside.jacobian[0] == DVec3(1, 0, 0));
        CHECK(maxDifference(outside.jacobian[1], linear[1]) < 2e-13);
    }
}

TEST_CASE("A lattice of 3 x 2 x 2 points lifts its middle as a parabola", "[deformer][lattice]") {
    const Deformer deformer = deformerAtFrame(
        latticeKeys({3, 2, 2}, DVec3(0), DVec3(2, 1, 1), [](const DVec3 &p) { return p.x == 1 ? p + DVec3(0, 0, 1) : p; }), 0);
    for (const double x : {0.0, 0.3, 1.0, 1.7, 2.0}) {
        const double u = x / 2;
        const DeformedPoint image = deform(deformer, {x, 0.5, 0.25});
        CHECK(maxDifference(image.position, {x, 0.5, 0.25 + 2 * u * (1 - u)}) < 1e-15);
        CHECK(image.jacobian[0][2] == Approx(1 - 2 * u).margin(1e-15));
    }
}
