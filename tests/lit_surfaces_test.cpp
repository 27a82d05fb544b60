/// Lights chosen by the surface that they shine on: nothing is lost of what comes from below a horizon, or past an interpolated normal.

#include "catch.h"
#include "lanes_fixtures.h"
#include "many_lights.h"

#include "taut/plan/plan.h"
#include "taut/render/light_candidates.h"

using namespace taut;
using namespace taut::test;

namespace {

/// Small balls and quads all around the origin, as many above z = 0 as below.
std::vector<Light> lightsAround(int count) {
    Uniform random(41);
    std::vector<Light> lights;
    for (int i = 0; i < count; ++i) {
        DVec3 at = 2.0 * DVec3(randomDirection(random));
        at.z = (i % 2 == 0 ? 1 : -1) * (0.3 + std::fabs(at.z));
        Light light;
        light.radiance = Vec3(20 + static_cast<float>(10 * (i % 3)));
        light.shape = SphereLight{at, 0.2};
        if (i % 3 == 0) light.shape = QuadLight{at, DVec3(0.4, 0, 0), DVec3(0, 0.3, 0.1), true};
        lights.push_back(light);
    }
    return lights;
}

/// A sheet in z = 0, seen from above or below.
Scene sheetUnder(const std::vector<Light> &lights, const Material &material, double eye) {
    Scene scene = smallScene(makeObject(makeGrid(1, 1, 0.2F)), material, 4);
    scene.environment.reset();
    scene.lights = lights;
    scene.camera.position = DVec3(0, -0.3, eye);
    scene.camera.lookAt = DVec3(0);
    scene.camera.fovY = 0.2;
    scene.render.maxEvents = 2; // through both sides of the sheet
    return scene;
}

/// Mean of a picture and its standard error, of seeds that know nothing of each other.
Estimate brightness(const Scene &scene, int spp) {
    RenderScene ready(scene, false);
    StageTimes times;
    ready.setFrame(1, times);
    FrameOptions options;
    options.spp = spp;
    return estimate(8, [&] {
        ++options.seed;
        const std::vector<float> image = renderFrame(ready, options).film.resolve();
        double sum = 0;
        for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]);
        return sum / static_cast<double>(image.size() / 4);
    });
}

} // namespace

TEST_CASE("Under many lights a surface is as bright as under each alone, from whatever side they shine", "[lights][receiver][render]") {
    struct Case {
        const char *name;
        Material material;
    };
    Material grey;
    grey.color.value = Vec3(0.6F);
    Material sheet = ggxMaterial(0.3F, 0.3F);
    sheet.type = BsdfType::ThinGlass;
    Material glass = ggxMaterial(0.4F, 0.4F);
    glass.type = BsdfType::Dielectric;
    Material passing = ggxMaterial(0.5F, 0.5F);
    passing.type = BsdfType::MetallicRoughness;
    passing.transmission.value = 0.8F;
    passing.thinWalled = true;
    for (const Case &c : {Case{"diffuse", grey}, Case{"metal", ggxMaterial(0.4F, 0.4F)}, Case{"thin glass", sheet}, Case{"glass", glass},
                          Case{"transmission", passing}})
        for (const int count : {12, 24}) // weighed one by one, and by the tree
            for (const double eye : {0.3, -0.3}) {
                INFO(c.name << ", " << count << " lights, eye " << eye);
                const std::vector<Light> lights = lightsAround(count);
                Estimate alone; // nothing to choose
                double variance = 0;
                for (const Light &light : lights) {
                    const Estimate one = brightness(sheetUnder({light}, c.material, eye), 128);
                    alone.mean += one.mean;
                    variance += sqr(one.error);
                }
                const Estimate all = brightness(sheetUnder(lights, c.material, eye), 512);
                const double error = std::sqrt(variance + sqr(all.error));
                INFO("together " << all.mean << ", each alone " << alone.mean << " +- " << error);
                CHECK(std::fabs(all.mean - alone.mean) < 5 * error + 1e-4 * alone.mean);
                CHECK(error < 0.03 * alone.mean);
            }
}

TEST_CASE("A normal that leans from the triangle's sees all that is above the triangle", "[lights][receiver]") {
    const Lit lit(manyLights(200, 200, false));
    Uniform random(43);
    int seen = 0;
    for (const Vec3 &point : somePoints(random, 3)) {
        const Vec3 geometric = randomDirection(random);
        const Vec3 shading = glm::normalize(geometric + 0.9F * randomDirection(random));
        // As the renderer does: nothing from below the triangle, then the shading normal's cosine.
        const auto above = [&](const Receiver &at) {
            return estimate(200000, [&] {
                const float choose = random.number();
                const LightSample s = sampleLight(lit.table(), at, 0, choose, random.pair());
                return glm::dot(s.direction, geometric) > 0 ? received(s, shading) : 0.0;
            });
        };
        const Estimate knowing = above({point, geometric});
        const Estimate blind = above({point});
        INFO("knowing " << knowing.mean << " +- " << knowing.error << ", blind " << blind.mean << " +- " << blind.error);
        CHECK(std::fabs(knowing.mean - blind.mean) <= 4.5 * std::sqrt(sqr(knowing.error) + sqr(blind.error)));
        CHECK(knowing.error <= 0.05 * knowing.mean);
        seen += knowing.mean > 0 ? 1 : 0;
    }
    CHECK(seen >= 6);
}

TEST_CASE("What is below the horizon is never chosen, and its share falls to what is above", "[lights][receiver]") {
    for (const int count : {12, 200}) {
        Scene scene = emptyScene();
        scene.lights = lightsAround(count);
        const Lit lit(scene);
        REQUIRE(lit.table().few == (count <= 16));
        const Receiver up{Vec3(0), Vec3(0, 0, 1)};
        double sum = 0;
        for (const LightPart &part : lit.table().parts) {
            const bool above = part.entry % 2 == 0;
            const double probability = static_cast<double>(choiceProbability(lit.table(), part, up));
            CHECK((probability > 0) == above);
            sum += probability;
        }
        CHECK(sum == Approx(1).epsilon(0.02));
        Uniform random(47);
        double truth = 0;
        for (const LightPart &part : lit.table().parts) truth += irradiance(lit.table(), part, Vec3(0), up.normal);
        const Estimate knowing = sampledIrradiance(lit.table(), up, up.normal, random, 100000);
        const Estimate blind = sampledIrradiance(lit.table(), {Vec3(0)}, up.normal, random, 100000);
        INFO(count << ": variance " << knowing.variance << " against " << blind.variance << ", mean " << knowing.mean << ", truth "
                   << truth);
        CHECK(std::fabs(knowing.mean - truth) < 4.5 * knowing.error + 1e-3 * truth);
        CHECK(std::fabs(blind.mean - truth) < 4.5 * blind.error + 1e-3 * truth);
        CHECK(knowing.variance < 0.25 * blind.variance);
    }
}

TEST_CASE("One light is chosen with probability one, wherever it is", "[lights][receiver]") {
    Scene scene = emptyScene();
    scene.lights = {lightsAround(1)};
    const Lit lit(scene);
    for (const float z : {-1.0F, 1.0F}) {
        const LightChoice choice = chooseLight(lit.table(), {Vec3(0), Vec3(0, 0, z)}, 0.7F);
        CHECK(choice.entry == 0);
        CHECK(choice.probability == 1);
        CHECK(choiceProbability(lit.table(), {0, 0}, {Vec3(0), Vec3(0, 0, z)}) == 1);
    }
}

TEST_CASE("Of several candidates each is kept by its weight, and the mean is that of all", "[lights][receiver]") {
    const std::vector<float> weights{0.5F, 0, 3, 1.5F};
    const auto count = static_cast<int>(weights.size());
    constexpr int kDraws = 40000;
    std::vector<double> observed(weights.size(), 0);
    std::vector<double> expected;
    for (const float weight : weights) expected.push_back(kDraws * static_cast<double>(weight) / 5);
    double leastLeft = 1;
    double mostLeft = 0;
    for (int i = 0; i < kDraws; ++i) {
        CandidateChoice choice{(static_cast<float>(i) + 0.5F) / kDraws};
        std::size_t kept = weights.size();
        for (std::size_t k = 0; k < weights.size(); ++k)
            if (choice.takes(weights[k])) kept = k;
        REQUIRE(kept < weights.size());
        ++observed[kept];
        CHECK(choice.kept == weights[kept]);
        CHECK(weights[kept] * choice.scale(count) == Approx(5.0 / 4).epsilon(1e-6));
        leastLeft = std::min(leastLeft, static_cast<double>(choice.number));
        mostLeft = std::max(mostLeft, static_cast<double>(choice.number));
    }
    CHECK(observed[1] == 0);
    for (const std::size_t k : {0U, 2U, 3U}) CHECK(std::fabs(observed[k] - expected[k]) <= 2);
    CHECK(leastLeft < 0.01);
    CHECK(mostLeft > 0.99);
    CHECK(mostLeft <= 1);
    // Candidates are uniform one by one, and their choices lie in equal parts.
    const Vec3 u(0.9F, 0.3F, 0.6F);
    CHECK(candidateNumbers(u, 0, 1) == u);
    for (int k = 0; k < count; ++k) {
        const Vec3 numbers = candidateNumbers(u, k, count);
        CHECK(static_cast<int>(numbers.z * 4) == k);
        CHECK(std::min(numbers.x, numbers.y) >= 0);
        CHECK(std::max(numbers.x, numbers.y) < 1);
    }
}

TEST_CASE("Under many lights shading at once gives the picture of shading one by one", "[lights][receiver][lanes]") {
    std::vector<LaneCase> cases;
    Material separable = plain(BsdfType::Dielectric, 0.1F, 0.4F, 0.3F);
    Material sheet = plain(BsdfType::ThinGlass, 0.2F, 0.2F, 0);
    for (const auto &[name, material] : {std::pair<const char *, Material>{"diffuse", plain(BsdfType::Diffuse, 1, 1, 0)},
                                         {"metal", plain(BsdfType::Metal, 0.2F, 0.4F, 0.3F)},
                                         {"glass", separable},
                                         {"thin glass", sheet}}) {
        Scene scene = laneScene(material);
        scene.lights = lightsAround(40);
        Uniform random(53);
        scene.objects.push_back(emitter(randomTriangles(random, 60, 2), 3, false));
        cases.push_back({name, std::move(scene)});
    }
    checkPictures(cases);
}

TEST_CASE("A walk prepares no sampler of its own reflections, but that of a coat", "[receiver][plan]") {
    Scene scene = smallScene(makeObject(makeGrid(1, 1, 1)), ggxMaterial(0.3F, 0.3F), 8);
    const float planned = defaultPlan(scene).bearableWaste;
    const auto waste = [&] { return prepareMaterials(scene, defaultPlan(scene))[0].bearableWaste; };
    scene.materials[0].multiscatter = Multiscatter::Off;
    CHECK(waste() == planned);
    scene.materials[0].multiscatter = Multiscatter::Walk;
    CHECK(waste() == 1);
    scene.materials[0].clearcoat.value = 0.5F;
    CHECK(waste() == planned);
}
