/// The light of many against quadrature over each alone, and its noise against choice by area.

#include "catch.h"
#include "many_lights.h"

using namespace taut;
using namespace taut::test;

TEST_CASE("The light of many is what quadrature over each alone says", "[lights][tree]") {
    const Lit lit(manyLights(400, 400, false));
    const LightTable &table = lit.table();
    REQUIRE(!table.few);
    Uniform random(3);
    for (const Vec3 &point : somePoints(random, 3)) {
        const Vec3 normal = randomDirection(random);
        double truth = 0;
        for (const LightPart &part : table.parts) truth += irradiance(table, part, point, normal);
        const Estimate e = sampledIrradiance(table, {point, normal}, normal, random, 100000);
        INFO("point " << point.x << " " << point.y << " " << point.z << ": " << e.mean << " +- " << e.error << ", truth " << truth);
        CHECK(std::fabs(e.mean - truth) < 4.5 * e.error + 1e-3 * truth + 1e-12); // quadrature's own error
        CHECK(e.error <= 0.05 * truth);
    }
}

TEST_CASE("No light that arrives is left out", "[lights][tree]") {
    const Lit lit(manyLights(300, 300, false));
    const LightTable &table = lit.table();
    Uniform random(5);
    for (int i = 0; i < 40; ++i) {
        const Vec3 point = randomPoint(random, i % 2 == 0 ? 2.0F : 6.0F);
        const Receiver at = receiverOf(point, random, i / 2);
        for (const LightPart &part : table.parts) {
            const LightSample s = sampleLight(table, {part.entry, part.triangle, 1}, point, 0, {0.3F, 0.4F});
            if (!(s.pdf > 0) || !(maxComponent(s.radiance) > 1e-3F)) continue;
            // A light that one is nearly in the plane of sends next to nothing.
            if (s.pdf > 1e4F && !s.delta) continue;
            if (at.normal != Vec3(0) && glm::dot(at.normal, s.direction) <= 1e-5F) continue;
            const float probability = choiceProbability(table, part, at);
            INFO("entry " << part.entry << ", triangle " << part.triangle);
            CHECK(probability > 0);
        }
    }
}

TEST_CASE("A large mesh emitter close by is noisy by area and quiet by the tree", "[lights][tree]") {
    // A glowing torus that nearly touches the plane z = -0.31: most of its area is far away or faces up.
    Scene scene = emptyScene();
    scene.objects.push_back(emitter(makeTorus(128, 64, 1, 0.3F), 1, false));
    const Lit lit(scene);
    const LightTable &table = lit.table();
    const LightEntry &entry = table.entries[0];
    const auto triangles = std::get<MeshEmitter>(entry.shape).triangles;
    const Vec3 normal(0, 0, 1);
    std::vector<double> below; // cumulative areas
    double area = 0;
    for (Index t = 0; t < triangles.size(); ++t) {
        const Corners c = cornersOf(entry, t);
        below.push_back(area += 0.5 * glm::length(glm::cross(c.b - c.a, c.c - c.a)));
    }
    Uniform random(13);
    for (const Vec3 &point : {Vec3(1, 0, -0.31F), Vec3(0.5F, 0.9F, -0.4F), Vec3(0, 0, -0.31F), Vec3(3, 0, -0.31F)}) {
        double truth = 0;
        for (const LightPart &part : table.parts) truth += irradiance(table, part, point, normal);
        const Estimate tree = sampledIrradiance(table, {point, normal}, normal, random, 100000);
        const Estimate byArea = estimate(100000, [&] {
            const double at = area * static_cast<double>(random.number());
            const auto found = std::upper_bound(below.begin(), below.end(), at) - below.begin();
            const auto triangle = static_cast<Index>(std::min<std::ptrdiff_t>(found, static_cast<std::ptrdiff_t>(below.size()) - 1));
            const Corners c = cornersOf(entry, triangle);
            const double share = 0.5 * glm::length(glm::cross(c.b - c.a, c.c - c.a)) / area;
            return received(sampleLight(table, {0, triangle, static_cast<float>(share)}, point, 0, random.pair()), normal);
        });
        INFO("truth " << truth << ", tree " << tree.mean << " variance " << tree.variance << ", by area " << byArea.mean << " variance "
                      << byArea.variance);
        CHECK(std::fabs(tree.mean - truth) < 4.5 * tree.error + 1e-3 * truth);
        CHECK(std::fabs(byArea.mean - truth) < 4.5 * byArea.error + 1e-3 * truth);
        CHECK(tree.variance < 0.4 * byArea.variance);
    }
}

TEST_CASE("A plane under a glowing mesh is as bright as its triangles say", "[lights][tree][render]") {
    Mesh ball = makeSphere(96, 48, 0.5F);
    for (Vec3 &p : ball.positions) p.z += 1;
    double truth = 0;
    {
        Scene alone = emptyScene();
        alone.objects.push_back(emitter(ball, 3, false));
        const Lit lit(alone);
        // A closed convex mesh: what faces the point is seen from it.
        for (const LightPart &part : lit.table().parts) truth += irradiance(lit.table(), part, Vec3(0), Vec3(0, 0, 1));
    }
    Material grey;
    grey.color.value = Vec3(0.6F);
    for (const bool byRays : {false, true}) { // a rough metal finds the ball by scattered rays as well: white in a furnace of 1
        Scene scene = smallScene(makeObject(makeGrid(1, 1, 0.02F)), byRays ? ggxMaterial(1, 1) : grey, 8);
        scene.environment.reset();
        scene.lights.clear();
        scene.objects.push_back(emitter(ball, 3, false));
        scene.camera.position = DVec3(0, -0.02, 0.02);
        scene.camera.fovY = 0.2;
        scene.render.maxEvents = 1;
        const auto centre = [&](const Scene &s) { // all pixels are within millimetres of it
            const std::vector<float> image = renderImage(s, 1, 1024);
            double sum = 0;
            for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]);
            return sum / 64;
        };
        if (!byRays) {
            CHECK(centre(scene) == Approx(0.6 * truth / kPiD).epsilon(5e-3));
            continue;
        }
        Scene asSphere = scene;
        asSphere.objects.pop_back();
        Light sphere;
        sphere.shape = SphereLight{DVec3(0, 0, 1), 0.5};
        sphere.radiance = Vec3(3);
        asSphere.lights = {sphere};
        // The faceted ball is smaller than the sphere by what truth says of the irradiance below it: 3 pi (r / h)^2.
        const double smaller = truth / (3 * kPiD * 0.25);
        CHECK(centre(scene) == Approx(centre(asSphere) * smaller).epsilon(5e-3));
    }
}

TEST_CASE("Mesh emitters that move are sampled where they are", "[lights][tree][motion_blur]") {
    // Rotated, scaled and carried through the shutter, rigid or deforming: light by quadrature over triangles and times.
    for (const bool deforms : {false, true}) {
        INFO("deforms " << deforms);
        Scene scene = emptyScene();
        Object torus = emitter(makeTorus(12, 8, 0.5F, 0.2F), 2, false);
        torus.placement.translation.keys = {{0, DVec3(-1, 0.2, 1)}, {2, DVec3(1.5, 0, 1)}};
        torus.placement.rotation.keys = {{0, DVec3(0)}, {2, DVec3(1, 2, 0.5)}};
        if (deforms) {
            torus.deformers = {stretchDeformer(DVec3(1))};
            torus.deformers[0].factor.keys = {{0, DVec3(0.3, 1, 1)}, {2, DVec3(2.5, 1, 1)}};
        }
        scene.objects.push_back(torus);
        scene.render.shutter = 1;
        scene.render.motionSteps = 5;
        const Lit lit(scene);
        const LightTable &table = lit.table();
        const LightEntry &entry = table.entries[0];
        const auto &mesh = std::get<MeshEmitter>(entry.shape);
        REQUIRE(std::max(mesh.steps.size(), mesh.placements.size()) == 5);
        Uniform random(17);
        for (const Vec3 &point : {Vec3(0), Vec3(0.4F, 0.1F, -0.6F), Vec3(0, -5, 0)}) {
            const Vec3 normal = glm::normalize(Vec3(0, 0.3F, 1));
            double truth = 0;
            constexpr int kTimes = 128;
            for (int k = 0; k < kTimes; ++k)
                for (Index t = 0; t < mesh.triangles.size(); ++t)
                    truth +=
                        2.0 / kTimes *
                        fromTriangle(DVec3(point), DVec3(normal), cornersOf(entry, t, (static_cast<float>(k) + 0.5F) / kTimes), false, 3);
            const Estimate e = sampledIrradiance(table, {point, normal}, normal, random, 200000);
            INFO(e.mean << " +- " << e.error << ", truth " << truth);
            CHECK(std::fabs(e.mean - truth) < 4.5 * e.error + 2e-3 * truth);
            CHECK(e.error < 0.02 * truth);
        }
    }
}
