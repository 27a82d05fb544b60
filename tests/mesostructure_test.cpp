/// Facets of maps under deformations: the worked values, D, samplers, and roughening against closed values.

#include "catch.h"
#include "direction_bins.h"

#include "taut/bsdf/tilted_facet.h"
#include "taut/microsurface/mesostructure.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

BasicBlock<double> restOf(double alphaX, double alphaY, double rotation = 0) {
    return restBlock<double>(alphaX, alphaY, DVec2(std::cos(rotation), std::sin(rotation)));
}

/// A mapped facet in the frame whose x axis is the mesh's tangent made perpendicular to n'.
struct Facet {
    DVec2 slope;
    DVec2 lean;
    double alphaMax, alphaMin;
};
Facet facetOf(const DMat3 &deformation, const DVec2 &slope, const BasicBlock<double> &rest) {
    const auto t = mappedTransform(deformation, {Vec2(slope), Vec3(0)}, rest);
    REQUIRE(t);
    const DVec3 n(t->frame.n);
    const DVec3 x = glm::normalize(DVec3(1, 0, 0) - n * n.x);
    const DVec3 lean = DVec3(t->frame.s) * double(t->micro.p) + DVec3(t->frame.t) * double(t->micro.q);
    const EquivalentAlpha alpha = equivalentAlpha(t->micro);
    return {DVec2(n) / n.z, {glm::dot(lean, x), glm::dot(lean, glm::cross(n, x))}, alpha.max, alpha.min};
}

struct Case {
    const char *name;
    DMat3 deformation;
    DVec2 slope;
    DVec2 alpha;
};

/// Mapped, deformed and leaning in every way that a mesh can be, mirrored too.
std::vector<Case> cases() {
    const auto f = [](double a, double b, double c, double d, double p, double q, double lambda) {
        return surfaceDeformation({a, b, c, d}, {p, q}, lambda);
    };
    return {{"at rest", f(1, 0, 0, 1, 0, 0, 1), {0.5, 0.2}, {0.3, 0.5}},
            {"stretched", f(2, 0, 0, 1, 0, 0, 0.5), {0.5, 0}, {0.3, 0.3}},
            {"sheared", f(1, 1, 0, 1, 0, 0, 1), {0.3, -0.4}, {0.2, 0.6}},
            {"sheared, leaning", f(1, 1, 0, 1, 0.2, -0.3, 1.2), {0.3, -0.4}, {0.2, 0.6}},
            {"mirrored", f(1.2, 0.3, 0.4, -0.8, 0.1, 0, 1), {-0.6, 0.3}, {0.4, 0.25}},
            {"steep", f(0.9, 0.2, -0.1, 1.1, 0, 0, 1), {1, 0.3}, {0.5, 0.5}}};
}

} // namespace

TEST_CASE("A mapped facet under a deformation has the slope, the lean and the alphas that were worked out", "[mesostructure]") {
    struct Row {
        BasicBlock<double> a;
        double lambda;
        DVec2 lean, slope, alpha;
        Facet expected;
    };
    const BasicBlock<double> stretch{2, 0, 0, 1};
    const BasicBlock<double> shear{1, 1, 0, 1};
    const std::vector<Row> rows{
        {stretch, 1, {0, 0}, {.5, 0}, {.1, .1}, {{.25, 0}, {.6, 0}, .1084652, .0588235}},
        {stretch, .5, {0, 0}, {.5, 0}, {.1, .1}, {{.125, 0}, {1.5, 0}, .0554700, .0307692}},
        {shear, 1, {0, 0}, {.3, -.4}, {.1, .3}, {{.3, -.7}, {-.3493205, .2471421}, .2707013, .0779849}},
        {shear, 1, {.2, 0}, {.3, -.4}, {.1, .3}, {{.3191489, -.7446809}, {-.1560674, .2675568}, .2823243, .0838696}},
    };
    for (const Row &row : rows) {
        const DMat3 f = surfaceDeformation(row.a, row.lean, row.lambda);
        const Facet found = facetOf(f, row.slope, restOf(row.alpha.x, row.alpha.y));
        INFO(row.expected.slope.x << " " << row.expected.slope.y);
        CHECK(glm::length(found.slope - row.expected.slope) < 1e-6);
        CHECK(glm::length(carriedSlope(f, row.slope) - row.expected.slope) < 1e-7);
        CHECK(glm::length(found.lean - row.expected.lean) < 1e-6);
        CHECK(std::fabs(found.alphaMax - row.expected.alphaMax) < 1e-6);
        CHECK(std::fabs(found.alphaMin - row.expected.alphaMin) < 1e-6);
    }
}

TEST_CASE("A carried slope is lambda A^-T s / (1 - l A^-T s)", "[mesostructure]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> entry(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const BasicBlock<double> a{1.5 + entry(random), entry(random), entry(random), 1.5 + entry(random)};
        const DVec2 lean(0.3 * entry(random), 0.3 * entry(random));
        const DVec2 s(0.5 * entry(random), 0.5 * entry(random));
        const double lambda = 1.2 + entry(random);
        const double det = a.a * a.d - a.b * a.c;
        if (std::fabs(det) < 0.3) continue;
        const DVec2 carried = DVec2(a.d * s.x - a.c * s.y, a.a * s.y - a.b * s.x) / det; // A^-T s
        const DVec2 expected = lambda * carried / (1 - glm::dot(lean, carried));
        CHECK(glm::length(carriedSlope(surfaceDeformation(a, lean, lambda), s) - expected) < 1e-12 * (1 + glm::length(expected)));
    }
}

TEST_CASE("Without a slope a mapped facet is the mesh's own microsurface", "[mesostructure]") {
    const BasicBlock<double> a{1.3, 0.4, 0.2, 0.8};
    const auto rest = restOf(0.1, 0.3, 0.7);
    const auto mapped = mappedTransform(surfaceDeformation(a, {0.2, -0.1}, 1.4), {}, rest);
    REQUIRE(mapped);
    CHECK(mapped->frame.n == Vec3(0, 0, 1));
    const auto direct = deformedTransform<double>(a, rest, 1.4, Vector2<double>(0.2, -0.1));
    CHECK(mapped->micro.a == Approx(direct.a));
    CHECK(mapped->micro.b == Approx(direct.b));
    CHECK(mapped->micro.d == Approx(direct.d));
    CHECK(mapped->micro.p == Approx(direct.p));
    CHECK(mapped->micro.q == Approx(direct.q));
}

TEST_CASE("A facet turns with a rigid motion, and uniform scaling changes nothing", "[mesostructure]") {
    const auto rest = restOf(0.1, 0.3, 0.4);
    const DVec2 s(0.4, -0.6);
    const Facet still = facetOf(DMat3(1), s, rest);
    CHECK(glm::length(still.slope - s) < 1e-6);
    CHECK(glm::length(still.lean) < 1e-7);
    CHECK(still.alphaMax == Approx(0.3));
    CHECK(still.alphaMin == Approx(0.1));
    const Facet scaled = facetOf(surfaceDeformation({3, 0, 0, 3}, DVec2(0), 3), s, rest);
    CHECK(glm::length(scaled.slope - s) < 1e-6);
    CHECK(glm::length(scaled.lean) < 1e-7);
    CHECK(scaled.alphaMax == Approx(0.3));
    // Turned by any rotation, the facet is the turned one.
    const DMat3 turn = glm::mat3_cast(glm::normalize(DQuat(0.5, 0.1, -0.7, 0.3)));
    const auto turned = mappedTransform(turn, {Vec2(s), Vec3(0)}, rest);
    REQUIRE(turned);
    CHECK(glm::length(DVec3(turned->frame.n) - turn * (DVec3(s, 1) / std::sqrt(1 + glm::dot(s, s)))) < 1e-6);
    CHECK(std::hypot(turned->micro.p, turned->micro.q) < 1e-6F);
    CHECK(singularValues(turned->micro).x == Approx(10));
}

TEST_CASE("D of mapped, deformed, leaning facets integrates to n'", "[mesostructure]") {
    for (const Case &c : cases()) {
        INFO(c.name);
        const auto rest = restOf(c.alpha.x, c.alpha.y, 0.3);
        const DMat3 matrix = mappedMatrix(c.deformation, c.slope, rest);
        const auto mapped = mappedTransform(c.deformation, {Vec2(c.slope), Vec3(0)}, rest);
        REQUIRE(mapped);
        DVec3 sum(0);
        for (int axis = 0; axis < 3; ++axis)
            sum[axis] = integrateHemisphere(
                [&](const DVec3 &w) {
                    return static_cast<double>(ggx::distribution(mapped->micro, mapped->frame.toLocal(Vec3(w)))) * w[axis];
                },
                matrix[2]);
        CHECK(glm::length(sum - DVec3(mapped->frame.n)) < 1e-4);
        CHECK(glm::length(DVec2(mapped->frame.n) / double(mapped->frame.n.z) - carriedSlope(c.deformation, c.slope)) < 1e-6);
    }
}

TEST_CASE("Samplers of mapped, deformed, leaning facets follow their densities", "[mesostructure]") {
    Uniform uniform(11);
    const auto all = cases();
    const double level = sidak(0.01, static_cast<int>(all.size()) * 3);
    for (const Case &c : all) {
        const auto mapped = mappedTransform(c.deformation, {Vec2(c.slope), Vec3(0)}, restOf(c.alpha.x, c.alpha.y, 0.3));
        REQUIRE(mapped);
        Bsdf bsdf;
        bsdf.type = BsdfType::Conductor;
        bsdf.micro = mapped->micro;
        for (const double theta : {20.0, 70.0, 100.0}) {
            INFO(c.name << " from " << theta << " degrees");
            const ScatteringPoint point(bsdf, direction(theta, 50));
            const auto draw = [&]() -> std::optional<Vec3> {
                const auto s = point.sample(uniform.pair(), uniform.number());
                return s ? std::optional<Vec3>(s->wi) : std::nullopt;
            };
            CHECK(chiSquaredOf(
                      draw, [&](const Vec3 &wi) { return point.evaluate(wi).pdf; }, 0, 1) > level);
        }
    }
}

TEST_CASE("A map seen from afar broadens the lobe by twice the covariance of its slopes", "[mesostructure]") {
    // Around a level mean the slope tensors add; around a steep one the facet sees slopes foreshortened.
    const auto alphaOf = [](const BasicBlock<double> &block) {
        return equivalentAlpha(microTransform(block.a, block.b, block.c, block.d));
    };
    const EquivalentAlpha level = alphaOf(broadenedBlock(restOf(0.1, 0.3), {Vec2(0), Vec3(0.02F, 0, 0.005F)}));
    CHECK(level.max == Approx(std::sqrt(0.09 + 0.01)));
    CHECK(level.min == Approx(std::sqrt(0.01 + 0.04)));
    // Slopes 1 +- d along x: the facet's angle changes by d / (1 + 1), the one across by d / sqrt(2).
    const EquivalentAlpha steep = alphaOf(broadenedBlock(restOf(0.1, 0.1), {Vec2(1, 0), Vec3(0.02F, 0, 0.02F)}));
    CHECK(steep.max == Approx(std::sqrt(0.01 + 0.04 / 2)));
    CHECK(steep.min == Approx(std::sqrt(0.01 + 0.04 / 4)));
    CHECK(broadenedBlock(restOf(0.1, 0.3, 0.2), {Vec2(1, 0.5F), Vec3(0)}).b == restOf(0.1, 0.3, 0.2).b);
}

TEST_CASE("Roughening adds alpha in proportion to the strain beyond the yield", "[mesostructure]") {
    // Uniaxial at constant volume, (2, 1/sqrt 2): eps = ln 2. Pure shear (2, 1/2): 2/sqrt(3) ln 2. Equibiaxial (2, 2): 2 ln 2.
    const double ln2 = std::log(2.0);
    CHECK(equivalentStrain(2, std::sqrt(0.5)) == Approx(ln2));
    CHECK(equivalentStrain(2, 0.5) == Approx(2 / std::sqrt(3.0) * ln2));
    CHECK(equivalentStrain(2, 2) == Approx(2 * ln2));
    CHECK(equivalentStrain(1, 1) == 0);
    CHECK(std::isfinite(equivalentStrain(1, 0)));
    CHECK(addedAlpha(0.3, 0.5, 0.1) == Approx(0.1));
    CHECK(addedAlpha(0.05, 0.5, 0.1) == 0);
    CHECK(addedAlpha(0.3, 0, 0) == 0);
    // alpha^2 add in every direction, whatever the shear; the lean stays.
    const MicroTransform m = microTransform(8, 3, 1, 5, 0.2F, -0.4F);
    const MicroTransform rough = roughened(m, 0.2);
    const auto before = slopeTensor(m);
    const auto after = slopeTensor(rough);
    CHECK(after.xx == Approx(before.xx + 0.04F));
    CHECK(after.xy == Approx(before.xy));
    CHECK(after.yy == Approx(before.yy + 0.04F));
    CHECK(rough.p == m.p);
    CHECK(rough.q == m.q);
    const MicroTransform same = roughened(m, 0);
    CHECK((same.a == m.a && same.b == m.b && same.d == m.d));
    CHECK(equivalentAlpha(roughened(microTransformFromAlpha(1e-4F, 10), 0.3)).min == Approx(std::sqrt(1e-8 + 0.09)));
}

TEST_CASE("What a facet sends below its mesh is mirrored: sampler and density agree, and nothing is lost or made", "[mesostructure]") {
    Uniform uniform(12);
    const auto all = cases();
    const double level = sidak(0.01, static_cast<int>(all.size()) * 3);
    for (const Case &c : all) {
        const auto mapped = mappedTransform(c.deformation, {Vec2(c.slope), Vec3(0)}, restOf(c.alpha.x, c.alpha.y, 0.3));
        REQUIRE(mapped);
        Bsdf bsdf;
        bsdf.type = BsdfType::Conductor;
        bsdf.micro = mapped->micro;
        // A geometric normal a little off the shading normal.
        const Frame plane = smoothFrameFromNormal(glm::normalize(Vec3(0.05F, -0.03F, 1)));
        for (const double theta : {20.0, 60.0, 85.0}) {
            INFO(c.name << " from " << theta << " degrees");
            const FacetScattering point(bsdf, mapped->frame, &plane.n, direction(theta, 200));
            const auto draw = [&]() -> std::optional<Vec3> {
                const auto s = point.sample(uniform.pair(), uniform.number());
                return s ? std::optional<Vec3>(plane.toLocal(s->wi)) : std::nullopt;
            };
            const auto pdf = [&](const Vec3 &wi) { return point.evaluate(plane.fromLocal(wi)).pdf; };
            CHECK(chiSquaredOf(draw, pdf, 0, 1) > level);
            // The light that is reflected is that of the facet alone.
            const Vec3 wo = direction(theta, 200);
            const Vec3 seen = mapped->frame.toLocal(wo);
            const ScatteringPoint alone(bsdf, {seen.x, seen.y, std::fabs(seen.z)});
            const auto albedo = [](const auto &f) { return integrate(f, 0, 1, 0, 2 * kPiD, 200); };
            const double reflected = albedo([&](const Vec3 &wi) { return point.evaluate(plane.fromLocal(wi)).fCos.x; });
            CHECK(reflected == Approx(albedo([&](const Vec3 &wi) { return alone.evaluate(wi).fCos.x; })).epsilon(3e-3));
            CHECK(reflected < 1);
        }
    }
}
