/// A thin sheet of glass: energy, reciprocity, its sampler, and a sheet in a
/// furnace.

#include "bsdf_checks.h"
#include "catch.h"
#include "render_fixtures.h"

#include <numeric>

using namespace taut;
using namespace taut::test;

namespace {

Bsdf sheet(const MicroTransform &m, const Vec3 &tint = Vec3(1)) {
    Bsdf bsdf;
    bsdf.type = BsdfType::ThinGlass;
    bsdf.eta = 1.5F;
    bsdf.tint = tint;
    bsdf.micro = m;
    return bsdf;
}

Vec3 mirrored(const Vec3 &w) {
    return {w.x, w.y, -w.z};
}

const MicroTransform kSurfaces[] = {microTransformFromAlpha(0.05F, 0.05F), microTransform(2, 1, 0, 3), microTransform(1, 2, 0, 1)};

} // namespace

TEST_CASE("Thin glass: the sampler follows its density", "[bsdf][chi2][thin_glass]") {
    const double thetas[] = {0, 40, 80, 95};
    const double level = sidak(0.01, 3 * 2 * 4);
    std::uint32_t seed = 300;
    for (const MicroTransform &m : kSurfaces)
        for (const Vec3 &tint : {Vec3(1), Vec3(0.3F, 0.1F, 0)})
            for (const double theta : thetas) {
                INFO("a " << m.a << ", tint " << tint.x << ", theta " << theta);
                CHECK(chiSquaredOf(sheet(m, tint), direction(theta, 25), seed++) > level);
            }
}

TEST_CASE("Thin glass: what is reflected and what passes make up the albedo of "
          "a white mirror",
          "[bsdf][thin_glass]") {
    for (const MicroTransform &m : kSurfaces)
        for (const double theta : {0.0, 40.0, 80.0}) {
            INFO("a " << m.a << ", theta " << theta);
            const Vec3 wo = direction(theta, 25);
            Bsdf mirror;
            mirror.type = BsdfType::Conductor;
            mirror.micro = m;
            const Bsdf clear = sheet(m);
            const Bsdf black = sheet(m, Vec3(0));
            const auto light = [&](const Bsdf &bsdf) {
                const ScatteringPoint point(bsdf, wo);
                return integrateSphere([&](const Vec3 &w) { return point.evaluate(w).fCos.x; });
            };
            const double all = light(clear);
            CHECK(all == Approx(light(mirror)).epsilon(1e-4));
            CHECK(all < 1.001);
            const ScatteringPoint point(clear, wo);
            CHECK(light(black) == Approx(integrate([&](const Vec3 &w) { return point.evaluate(w).fCos.x; }, false)).epsilon(1e-6));
        }
    // A smooth sheet, seen from the normal: 2 R / (1 + R) with R = 0.04.
    const Bsdf smooth = sheet(microTransformFromAlpha(0.01F, 0.01F));
    const ScatteringPoint point(smooth, Vec3(0, 0, 1));
    const auto down = point.sample({0.3F, 1e-4F}, 0.5F);
    REQUIRE(down);
    CHECK(down->transmitted);
    CHECK(down->wi.z < -0.999F);
    CHECK(down->etaScale == 1);
    CHECK(point.evaluate(mirrored(down->wi)).fCos.x / point.evaluate(down->wi).fCos.x ==
          Approx(0.08 / 1.04 / (1 - 0.08 / 1.04)).epsilon(1e-3));
}

TEST_CASE("Thin glass is reciprocal on both sides", "[bsdf][thin_glass]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    for (const MicroTransform &m : kSurfaces)
        for (const bool correlated : {true, false}) {
            Bsdf bsdf = sheet(m, Vec3(0.8F));
            bsdf.correlated = correlated;
            for (int i = 0; i < 200; ++i) {
                const Vec3 a = squareToCosineHemisphere({uniform(random), uniform(random)});
                const Vec3 b = squareToCosineHemisphere({uniform(random), uniform(random)});
                if (a.z < 1e-2F || b.z < 1e-2F) continue;
                const auto f = [&](const Vec3 &wo, const Vec3 &wi) {
                    return ScatteringPoint(bsdf, wo).evaluate(wi).fCos.x / std::fabs(wi.z);
                };
                CHECK(f(a, b) == Approx(f(b, a)).epsilon(1e-4).margin(1e-12));
                // Seen from behind the frame turns over; the surface that the mirrored
                // directions see is the same.
                CHECK(f(a, mirrored(b)) == Approx(f(b, mirrored(a))).epsilon(1e-4).margin(1e-12));
            }
        }
}

TEST_CASE("A thin sheet in a furnace cannot be told from nothing but for what "
          "facets lose to each other",
          "[bsdf][render][thin_glass]") {
    Material material = ggxMaterial(0.05F, 0.05F);
    material.type = BsdfType::ThinGlass;
    Scene scene = smallScene(makeObject(makeGrid(2, 2, 3)), material);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.render.maxEvents = 8;
    const auto mean = [&] {
        const std::vector<float> image = renderImage(scene, 1, 64);
        CHECK(*std::max_element(image.begin(), image.end()) < 1.001F);
        return std::accumulate(image.begin(), image.end(), 0.0) / static_cast<double>(image.size());
    };
    const double sheet = mean();
    // A mirror of such facets loses as much, and sends the rest where the furnace is as bright.
    scene.materials[0].type = BsdfType::Conductor;
    scene.materials[0].multiscatter = Multiscatter::Off;
    CHECK(sheet == Approx(mean()).epsilon(5e-4));
    CHECK(sheet > 0.99);
}
