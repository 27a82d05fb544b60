/// Light of several facets against its own noise: what a plan predicts, and what renders find.

#include "catch.h"
#include "render_fixtures.h"
#include "study/measures/render_image.h"

#include "taut/plan/light_coverage.h"
#include "taut/plan/plan.h"

#include <cstdio>

using namespace taut;
using namespace taut::test;

namespace {

Bounds pointBox(const Vec3 &p) {
    Bounds box;
    box.add(p);
    return box;
}

Light quadAbove(float height, float side, float radiance) {
    return {Vec3(radiance), QuadLight{DVec3(-side / 2, side / 2, height), DVec3(side, 0, 0), DVec3(0, -side, 0)}}; // facing down
}

/// A map of the sky of which one half is bright, the other black.
Environment halfBright(int columns) {
    Environment sky;
    sky.constant = false;
    sky.width = columns;
    sky.height = columns / 2;
    sky.texels.clear();
    for (int row = 0; row < sky.height; ++row)
        for (int column = 0; column < columns; ++column) sky.texels.emplace_back(column < columns / 2 ? 1.0F : 0.0F);
    buildSampling(sky);
    return sky;
}

/// A metal plate under a small lamp, a sky or both.
Scene plateUnder(float alpha, float lamp, float sky) {
    Scene scene = smallScene(makeObject(makeGrid(8, 8, 1.6F)), ggxMaterial(alpha, alpha), 24);
    scene.lights = {quadAbove(2, 0.5F, lamp)};
    if (lamp == 0) scene.lights.clear();
    scene.environment.reset();
    if (sky > 0) scene.environment = constantEnvironment(Vec3(sky));
    return scene;
}

/// Root mean square error of an image against a mean of many, both relative to that.
struct Study {
    std::vector<double> mean;
    double variance = 0; ///< of an image, sum over its values
};
Study study(const Scene &scene, Multiscatter model, int spp, std::uint32_t seeds) {
    ScenePlan plan = fullPlan(scene);
    for (MultiscatterPlan &material : plan.materials) material.model = model;
    Study s;
    std::vector<double> squares;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
        const std::vector<float> image = chart::renderImage(scene, plan, 1, spp, seed).values;
        s.mean.resize(image.size());
        squares.resize(image.size());
        for (std::size_t i = 0; i < image.size(); ++i) {
            s.mean[i] += static_cast<double>(image[i]) / seeds;
            squares[i] += sqr(static_cast<double>(image[i])) / seeds;
        }
    }
    for (std::size_t i = 0; i < squares.size(); ++i) s.variance += (squares[i] - sqr(s.mean[i])) * seeds / (seeds - 1);
    return s;
}

} // namespace

TEST_CASE("Coverage is the share of the hemisphere that lights fill", "[plan][noise]") {
    Scene scene;
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0) == 1);
    scene.environment = constantEnvironment(Vec3(0.3F));
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0) == Approx(1));
    // Half of the sphere bright, the other black.
    scene.environment = halfBright(64);
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0) == Approx(0.5).epsilon(0.03)); // bilinear at two edges
    // A lamp alone, from far: its solid angle over the hemisphere's; one that looks away lights nothing.
    scene.environment.reset();
    scene.lights = {quadAbove(10, 0.5F, 7)};
    const float angle = 0.25F / 100;
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0) == Approx(angle / (2 * kPi)).epsilon(0.01));
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0.1F) == Approx(0.1F / (2 * kPi)).epsilon(0.01));
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0, 0, 20)), 0) == 1); // dark: nothing to find
    scene.lights = {{Vec3(7), SphereLight{DVec3(0, 0, 10), 0.3}}};
    CHECK(lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0) == Approx(kPi * 0.09F / 100 / (2 * kPi)).epsilon(0.01));
    // Two of the same size: twice as much; a box reaches up to the light.
    scene.lights.push_back({Vec3(7), SphereLight{DVec3(10, 0, 0), 0.3}});
    const float both = lightCoverage(lightsOf(scene, 1), pointBox(Vec3(0)), 0);
    CHECK(both == Approx(kPi * 0.09F / 100 / kPi).epsilon(0.01));
    Bounds box = pointBox(Vec3(0));
    box.add(Vec3(0, 0, 9));
    CHECK(lightCoverage(lightsOf(scene, 1), box, 0) > 5 * both);
    // A mesh that shines is a light as well.
    Scene glowing;
    glowing.objects.push_back(makeObject(makeSphere(16, 8, 0.3F)));
    glowing.objects[0].placement.translation = DVec3(0, 0, 10);
    glowing.objects[0].emission.value = Vec3(5);
    CHECK(lightCoverage(lightsOf(glowing, 1), pointBox(Vec3(0)), 0) < 0.01F);
}

TEST_CASE("Without a tolerance a plan leaves light of several facets out where it would be noise", "[plan][noise]") {
    const auto planAt = [](Scene scene, int spp, std::optional<float> tolerance) {
        scene.render.spp = spp;
        return makePlan(scene, tolerance);
    };
    const Scene lamp = plateUnder(0.15F, 20, 0);
    const ScenePlan few = planAt(lamp, 2, {});
    CHECK(few.materials[0].model == Multiscatter::Off);
    CHECK(few.errorInNoise > kDefaultTolerance);
    CHECK(few.predictedError <= kDefaultTolerance);
    REQUIRE(few.materials[0].question);
    CHECK(few.materials[0].question->choices.back().noise > few.errorInNoise);
    const ScenePlan many = planAt(lamp, 4096, {});
    CHECK(many.materials[0].model == Multiscatter::Walk);
    CHECK(many.errorInNoise == 0);
    // Four times the samples, half the noise.
    CHECK(planAt(lamp, 8, {}).materials[0].question->choices.back().noise ==
          Approx(0.5F * few.materials[0].question->choices.back().noise));
    // A tolerance that is asked for is kept, whatever the noise; even light brings none.
    CHECK(planAt(lamp, 2, kDefaultTolerance).materials[0].model == Multiscatter::Walk);
    CHECK(planAt(plateUnder(0.15F, 0, 1), 1, {}).materials[0].model == Multiscatter::Walk);
    // What is asked for by name stays.
    Scene named = lamp;
    named.materials[0].multiscatter = Multiscatter::Walk;
    CHECK_FALSE(planAt(named, 1, {}).materials[0].question);
}

TEST_CASE("The default plan errs no more than the better of single scattering and the walk", "[plan][noise]") {
    std::printf("%-22s %4s %8s %10s %10s\n", "scene", "spp", "plan", "off", "walk");
    const std::pair<const char *, Scene> scenes[] = {{"smooth under a lamp", plateUnder(0.15F, 20, 0)},
                                                     {"smooth, lamp and sky", plateUnder(0.2F, 20, 0.3F)},
                                                     {"rough under a lamp", plateUnder(0.5F, 20, 0)},
                                                     {"smooth under a sky", plateUnder(0.15F, 0, 1)}};
    for (const auto &[name, base] : scenes)
        for (const int spp : {4, 64, 256}) {
            Scene scene = base;
            scene.render.spp = spp;
            const Study off = study(scene, Multiscatter::Off, spp, spp > 64 ? 8 : 24);
            const Study walk = study(scene, Multiscatter::Walk, spp, spp > 64 ? 8 : 24);
            double bias = 0;
            double size = 0;
            for (std::size_t i = 0; i < off.mean.size(); ++i) {
                bias += sqr(off.mean[i] - walk.mean[i]);
                size += sqr(walk.mean[i]);
            }
            const double single = std::sqrt((bias + off.variance) / size);
            const double walked = std::sqrt(walk.variance / size);
            const Multiscatter model = makePlan(scene).materials[0].model;
            std::printf("%-22s %4d %8s %10.4f %10.4f\n", name, spp, model == Multiscatter::Off ? "off" : "walk", single, walked);
            INFO(name << " at " << spp);
            CHECK((model == Multiscatter::Off ? single : walked) <= 1.15 * std::min(single, walked) + 1e-6);
        }
}

TEST_CASE("Reflections lose no samples to the horizon where the sky alone brings less noise than that", "[plan][noise]") {
    Scene scene = plateUnder(0.3F, 0, 1);
    const float even = defaultPlan(scene).bearableWaste;
    CHECK(even < 0.01F);
    CHECK(fullPlan(scene).bearableWaste == even);
    scene.environment = halfBright(64);
    CHECK(defaultPlan(scene).bearableWaste == Approx(0.5 * kBearableWaste).epsilon(0.05));
    scene = plateUnder(0.3F, 5, 1);
    CHECK(defaultPlan(scene).bearableWaste == kBearableWaste);
    scene.lights.clear();
    scene.objects[0].emission.value = Vec3(1);
    CHECK(defaultPlan(scene).bearableWaste == kBearableWaste);
}

TEST_CASE("Under an even sky the sampler that loses nothing leaves less than half of the variance", "[plan][noise]") {
    Scene scene = plateUnder(0.04F, 0, 1);
    scene.materials[0] = ggxMaterial(0.04F, 0.12F); // round gloss seen from its normal: both samplers are the same
    scene.materials[0].multiscatter = Multiscatter::Off;
    const auto varianceOf = [&](float waste) {
        ScenePlan plan = defaultPlan(scene);
        plan.bearableWaste = waste;
        double variance = 0;
        for (std::uint32_t seed = 1; seed <= 8; seed += 2) {
            const std::vector<float> a = chart::renderImage(scene, plan, 1, 4, seed).values;
            const std::vector<float> b = chart::renderImage(scene, plan, 1, 4, seed + 1).values;
            for (std::size_t i = 0; i < a.size(); ++i) variance += sqr(static_cast<double>(a[i]) - static_cast<double>(b[i]));
        }
        return variance;
    };
    const double planned = varianceOf(defaultPlan(scene).bearableWaste);
    const double caps = varianceOf(1);
    INFO(planned / caps);
    CHECK(planned > 0);
    CHECK(planned < 0.5 * caps);
}
