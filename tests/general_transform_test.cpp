/// M as any invertible 3x3 matrix, deformations one after another, and canonical forms of sheared blocks.

#include "catch.h"
#include "direction_bins.h"

#include "taut/microsurface/general_transform.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

/// Columns of independent entries, every other one mirrored, well enough conditioned for a quadrature.
std::vector<DMat3> randomMatrices(int count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> entry(-1.5, 1.5);
    std::vector<DMat3> matrices;
    while (static_cast<int>(matrices.size()) < count) {
        DMat3 m(0);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) m[c][r] = entry(random);
        if (std::fabs(glm::determinant(m)) < 0.3) continue;
        if ((glm::determinant(m) < 0) != (matrices.size() % 2 == 0)) m[0] = -m[0];
        matrices.push_back(m);
    }
    return matrices;
}

DVec3 normalOf(const DMat3 &m) {
    return glm::normalize(glm::inverse(glm::transpose(m)) * DVec3(0, 0, 1));
}

DVec3 anyDirection(Uniform &uniform) {
    const double z = 2 * static_cast<double>(uniform.number()) - 1;
    const double phi = 2 * kPiD * static_cast<double>(uniform.number());
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

} // namespace

TEST_CASE("The normals under a general M add up to the macro-normal n' = M^-T z", "[general_transform]") {
    for (const DMat3 &m : randomMatrices(50)) {
        const DVec3 expected = normalOf(m);
        DVec3 sum(0);
        for (int axis = 0; axis < 3; ++axis)
            sum[axis] = integrateHemisphere([&](const DVec3 &w) { return generalDistribution(m, w) * w[axis]; }, m[2]);
        CHECK(glm::length(sum - expected) < 2e-5);
    }
}

TEST_CASE("D under a general M is the area of facets that were carried along", "[general_transform]") {
    // Facets with normals in a small solid angle around m lie, before, around M^T m. A facet's area vector is carried by the cofactors
    // of M, and D counts it per area of macro-surface, which is carried so too.
    Uniform uniform(1);
    for (const DMat3 &m : randomMatrices(50)) {
        const DMat3 cofactors = glm::inverse(glm::transpose(m)) * std::fabs(glm::determinant(m));
        const DMat3 transposed = glm::transpose(m);
        for (int i = 0; i < 10; ++i) {
            const DVec3 normal = anyDirection(uniform);
            const DVec3 before = glm::normalize(transposed * normal);
            if (before.z < 0.01) {
                if (before.z <= 0) CHECK(generalDistribution(m, normal) == 0);
                continue;
            }
            const DVec3 s = glm::normalize(glm::cross(normal, std::fabs(normal.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
            const DVec3 t = glm::cross(normal, s);
            const auto moved = [&](const DVec3 &d) {
                return (glm::normalize(transposed * (normal + 1e-5 * d)) - glm::normalize(transposed * (normal - 1e-5 * d))) / 2e-5;
            };
            const double solidAngle = glm::length(glm::cross(moved(s), moved(t)));
            const double area = glm::length(cofactors * before) / glm::length(cofactors * DVec3(0, 0, 1));
            CHECK(generalDistribution(m, normal) == Approx(solidAngle * area / kPiD).epsilon(1e-6));
        }
    }
}

TEST_CASE("A general M is a canonical one in the macro-surface's own frame", "[general_transform]") {
    Uniform uniform(2);
    for (const DMat3 &m : randomMatrices(50)) {
        const auto general = generalTransform(m);
        REQUIRE(general);
        CHECK(glm::length(DVec3(general->frame.n) - normalOf(m)) < 1e-6);
        for (int i = 0; i < 50; ++i) {
            const Vec3 normal(anyDirection(uniform));
            const double found = static_cast<double>(ggx::distribution(general->micro, general->frame.toLocal(normal)));
            CHECK(found == Approx(generalDistribution(m, glm::normalize(DVec3(normal)))).epsilon(1e-4).margin(1e-6));
        }
    }
}

TEST_CASE("Where the macro-surface stays, the general form is the plain one", "[general_transform]") {
    const DMat3 m(2, 0.3, 0, 0.5, 1.5, 0, 0.8, -0.4, 1); // columns
    const auto general = generalTransform(m);
    REQUIRE(general);
    CHECK(general->frame.n == Vec3(0, 0, 1));
    CHECK(general->frame.s == Vec3(1, 0, 0));
    const MicroTransform plain = microTransform(2, 0.5, 0.3, 1.5, 0.8, -0.4);
    CHECK(general->micro.a == Approx(plain.a));
    CHECK(general->micro.b == Approx(plain.b));
    CHECK(general->micro.d == Approx(plain.d));
    CHECK(general->micro.p == Approx(0.8));
    CHECK(general->micro.q == Approx(-0.4));
    // A uniform scale and a rotation change no roughness.
    const DMat3 turn = 3.0 * glm::mat3_cast(glm::normalize(DQuat(0.5, 0.1, -0.7, 0.3)));
    const auto rotated = generalTransform(turn * m);
    REQUIRE(rotated);
    CHECK(rotated->micro.det == Approx(plain.det).epsilon(1e-5));
    CHECK(singularValues(rotated->micro).x == Approx(singularValues(plain).x).epsilon(1e-5));
    CHECK(rotated->micro.p * rotated->micro.p + rotated->micro.q * rotated->micro.q == Approx(0.8).epsilon(1e-5));
}

TEST_CASE("A matrix without an inverse has no general form", "[general_transform]") {
    CHECK_FALSE(generalTransform(DMat3(0)));
    CHECK_FALSE(generalTransform(DMat3(1, 0, 0, 2, 0, 0, 0, 0, 1)));
    CHECK_FALSE(generalTransform(DMat3(1, 0, 0, 0, 1, 0, 1, 1, 0)));
    CHECK_FALSE(generalTransform(DMat3(NAN, 0, 0, 0, 1, 0, 0, 0, 1)));
    CHECK_FALSE(generalTransform(DMat3(INFINITY, 0, 0, 0, 1, 0, 0, 0, 1)));
}

TEST_CASE("A deformation of a transformed surface is the product of their matrices", "[general_transform]") {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> entry(-2, 2);
    for (int i = 0; i < 50; ++i) {
        const MicroTransform rest =
            microTransform(entry(random), entry(random), entry(random), entry(random), entry(random), entry(random));
        const Block a{entry(random), entry(random), entry(random), entry(random)};
        const Vec2 lean(entry(random), entry(random));
        const float lambda = 0.5F + std::fabs(entry(random));
        const MicroTransform deformed = deformedTransform(a, rest, lambda, lean);
        // In three dimensions: the gradient with its lean and lambda, times M, over the scale lambda that no normal feels.
        const DMat3 gradient(a.a, a.c, 0, a.b, a.d, 0, lean.x, lean.y, lambda);
        const DMat3 m(rest.a, 0, 0, rest.b, rest.d, 0, rest.p, rest.q, 1);
        const auto general = generalTransform(gradient * m);
        REQUIRE(general);
        INFO("case " << i);
        CHECK(deformed.a == Approx(general->micro.a).epsilon(1e-5));
        CHECK(deformed.b == Approx(general->micro.b).epsilon(1e-5).margin(1e-5));
        CHECK(deformed.d == Approx(general->micro.d).epsilon(1e-5));
        CHECK(deformed.p == Approx(general->micro.p).epsilon(1e-5).margin(1e-5));
        CHECK(deformed.q == Approx(general->micro.q).epsilon(1e-5).margin(1e-5));
        // A rest material's block and its whole are deformed alike.
        const Vec2 axis(0.6F, 0.8F);
        const auto block = restBlock(0.3F, 0.1F, axis);
        const MicroTransform byBlock = deformedTransform(a, block, lambda);
        const MicroTransform byWhole = deformedTransform(a, microTransformFromAlpha(0.3F, 0.1F, std::atan2(0.8F, 0.6F)), lambda);
        CHECK(byBlock.a == Approx(byWhole.a).epsilon(1e-5));
        CHECK(byBlock.d == Approx(byWhole.d).epsilon(1e-5));
    }
}

TEST_CASE("The canonical form of a sheared block is right to a rounding", "[general_transform]") {
    // Rows that are nearly parallel: det and the first diagonal are what is left after a cancellation of up to five digits.
    for (const float shear : {10.0F, 100.0F, 1e3F}) {
        const float a = 0.7F;
        const float b = 0.3F;
        const auto m = microTransform(shear * a + 0.1F, shear * b, a, b);
        const long double exactDet = static_cast<long double>(shear * a + 0.1F) * static_cast<long double>(b) -
                                     static_cast<long double>(shear * b) * static_cast<long double>(a);
        const long double row = std::sqrt(static_cast<long double>(a) * a + static_cast<long double>(b) * b);
        CHECK(double(m.det) == Approx(double(std::fabs(exactDet))).epsilon(2e-7));
        CHECK(double(m.a) == Approx(double(std::fabs(exactDet) / row)).epsilon(2e-7));
    }
}
