/// Choosing among many lights: the tree's choice against its own probabilities, its shape, and lights that degenerate.

#include "catch.h"
#include "many_lights.h"

#include "taut/render/place_lights.h"

#include <tbb/global_control.h>

#include <cstring>

using namespace taut;
using namespace taut::test;

TEST_CASE("Probabilities of all lights sum to one and are those of the choice", "[lights][tree]") {
    struct Case {
        int lights, triangles;
        bool everywhere;
    };
    for (const Case &c : {Case{300, 0, false}, Case{0, 400, false}, Case{200, 200, true}, Case{6, 4, true}, Case{3, 0, false}}) {
        INFO(c.lights << " lights, " << c.triangles << " triangles, everywhere " << c.everywhere);
        const Lit lit(manyLights(c.lights, c.triangles, c.everywhere));
        const LightTable &table = lit.table();
        const std::vector<LightPart> all = allChoices(table);
        CHECK(table.few == (all.size() <= kFewChoices));
        Uniform random(11);
        int turn = 0;
        for (const Vec3 &point : somePoints(random, 2)) {
            const Receiver at = receiverOf(point, random, turn++);
            std::vector<double> expected;
            double sum = 0;
            constexpr int kDraws = 20000;
            for (const LightPart &part : all) {
                expected.push_back(static_cast<double>(choiceProbability(table, part, at)));
                sum += expected.back();
                expected.back() *= kDraws;
            }
            std::vector<double> observed(all.size(), 0);
            int none = 0;
            for (int i = 0; i < kDraws; ++i) {
                const LightChoice choice = chooseLight(table, at, random.number());
                if (choice.entry == kNone) {
                    ++none;
                    continue;
                }
                const Index firstPart = table.entries[choice.entry].firstPart;
                std::size_t place = firstPart + choice.triangle;
                if (firstPart == kNone)
                    for (place = table.parts.size(); all[place].entry != choice.entry;) ++place;
                ++observed[place];
                if (i % 100 == 0)
                    CHECK(choiceProbability(table, {choice.entry, choice.triangle}, at) == Approx(choice.probability).epsilon(1e-5));
            }
            // Where the bounds of two lights together say that something may come and those of each say no, none is chosen.
            observed.push_back(none);
            expected.push_back((1 - sum) * kDraws);
            CHECK(sum <= 1 + 1e-5);
            CHECK(sum >= (at.normal == Vec3(0) ? 0.8 : 0.5)); // a horizon adds such
            CHECK(chiSquaredP(observed, expected) > sidak(0.01, 5 * 6));
        }
    }
}

TEST_CASE("Lights are chosen at many receivers at once as at each alone", "[lights][tree][lanes]") {
    struct Case {
        int lights, triangles;
        bool everywhere;
    };
    for (const Case &c : {Case{300, 0, false}, Case{0, 400, false}, Case{200, 200, true}, Case{3000, 0, true}}) {
        INFO(c.lights << " lights, " << c.triangles << " triangles, everywhere " << c.everywhere);
        const Lit lit(manyLights(c.lights, c.triangles, c.everywhere));
        const LightTable &table = lit.table();
        REQUIRE(!table.few);
        Uniform random(37);
        std::size_t found = 0;
        std::size_t inTree = 0;
        std::size_t nowhere = 0;
        for (int turn = 0; turn < 200; ++turn) {
            const int count = 1 + turn % LightChoices::kSize;
            LightChoices lanes;
            for (int i = 0; i < count; ++i) {
                const Vec3 corner = table.tree.nodes[static_cast<std::size_t>(turn) % table.tree.nodes.size()].lower; // of a box
                const Vec3 point = i % 9 == 0 ? corner : randomPoint(random, i % 2 == 0 ? 3.0F : 30.0F);
                lanes.add(receiverOf(point, random, i), i % 11 == 0 ? kOneMinusEpsilon : random.number());
            }
            for (const Instructions instructions : {Instructions::Sse2, Instructions::Avx2, Instructions::Avx512}) {
                chooseByTree(table, lanes, instructions);
                for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
                    const LightChoice alone = chooseLight(table, {lanes.position.at(i), lanes.normal.at(i)}, lanes.choose[i]);
                    CHECK(lanes.chosen[i].entry == alone.entry);
                    CHECK(lanes.chosen[i].triangle == alone.triangle);
                    CHECK(lanes.chosen[i].probability == alone.probability);
                    found += alone.entry != kNone ? 1 : 0;
                    nowhere += alone.entry == kNone ? 1 : 0;
                    inTree += alone.entry != kNone && table.entries[alone.entry].firstPart != kNone ? 1 : 0;
                }
            }
        }
        CHECK(found > 5000);
        CHECK(inTree > 5000);
        CHECK((found == inTree) != c.everywhere);
        CHECK(nowhere > 100); // bounds of two lights together promise what neither keeps
    }
    Scene scene = emptyScene();
    for (std::size_t i = 0; i <= kFewChoices; ++i) scene.lights.push_back({Vec3(1 + static_cast<float>(i)), DirectionalLight()});
    const Lit lit(scene);
    REQUIRE(lit.table().tree.nodes.empty());
    LightChoices lanes;
    for (int i = 0; i < 10; ++i) lanes.add({Vec3(0), Vec3(0)}, 0.1F * static_cast<float>(i));
    chooseByTree(lit.table(), lanes);
    for (std::size_t i = 0; i < 10; ++i) CHECK(lanes.chosen[i].entry == chooseLight(lit.table(), {Vec3(0)}, lanes.choose[i]).entry);
}

TEST_CASE("A light sample's density is that of meeting the same light", "[lights][tree][mis]") {
    for (const bool few : {false, true}) {
        const Lit lit(few ? manyLights(4, 6, true) : manyLights(200, 300, true));
        const LightTable &table = lit.table();
        REQUIRE(table.few == few);
        Uniform random(9);
        int compared = 0;
        for (int i = 0; i < 4000; ++i) {
            const Vec3 point = randomPoint(random, 5);
            const Receiver at = receiverOf(point, random, i);
            const LightChoice choice = chooseLight(table, at, random.number());
            if (choice.entry == kNone) continue;
            const LightEntry &entry = table.entries[choice.entry];
            const LightSample s = sampleLight(table, choice, point, 0, random.pair());
            if (!(s.pdf > 0) || s.pdf > 1e5F) continue;
            float pdf = s.pdf;
            if (std::holds_alternative<MeshEmitter>(entry.shape)) {
                const Corners t = cornersOf(entry, choice.triangle);
                const DVec3 n = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
                const auto cosine = static_cast<float>(std::fabs(glm::dot(n, DVec3(s.direction))));
                pdf = emitterHitPdf(table, {choice.entry, choice.triangle}, at, 0, s.distance, cosine);
            } else if (std::holds_alternative<PlacedQuad>(entry.shape) || std::holds_alternative<PlacedSphere>(entry.shape)) {
                const LightHit hit = intersectLight(table, choice.entry, point, s.direction, kInfinity);
                if (hit.entry == kNone) continue; // at the edge
                pdf = lightHitPdf(table, hit, at);
            } else {
                continue;
            }
            ++compared;
            CHECK(pdf == Approx(s.pdf).epsilon(2e-3));
        }
        CHECK(compared > 250);
    }
}

TEST_CASE("Rays meet the lights that a loop over all finds", "[lights][tree]") {
    const Lit lit(manyLights(400, 200, true));
    const LightTable &table = lit.table();
    REQUIRE(!table.few);
    Uniform random(19);
    int met = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 origin = randomPoint(random, i % 2 == 0 ? 3.0F : 30.0F);
        Vec3 direction = i % 5 == 0 ? glm::normalize(randomPoint(random, 3) - origin) : randomDirection(random);
        if (i % 7 == 0) direction = Vec3(0, 0, i % 2 == 0 ? 1.0F : -1.0F);
        const float farthest = i % 3 == 0 ? 2.0F : kInfinity;
        std::vector<Index> expected;
        for (Index entry = 0; entry < table.entries.size(); ++entry)
            if (intersectLight(table, entry, origin, direction, farthest).entry != kNone) expected.push_back(entry);
        std::vector<Index> found;
        float nearest = kInfinity; // where each hit ends the ray
        visitLightsMet(table, origin, direction, farthest, [&](Index entry, float end) {
            const LightHit hit = intersectLight(table, entry, origin, direction, end);
            if (hit.entry != kNone) found.push_back(entry);
            return end;
        });
        visitLightsMet(table, origin, direction, farthest, [&](Index entry, float end) {
            const LightHit hit = intersectLight(table, entry, origin, direction, end);
            return hit.entry != kNone ? nearest = hit.t : end;
        });
        std::sort(found.begin(), found.end());
        CHECK(found == expected);
        float least = kInfinity;
        for (const Index entry : expected) least = std::min(least, intersectLight(table, entry, origin, direction, farthest).t);
        CHECK(nearest == least);
        met += static_cast<int>(expected.size());
    }
    CHECK(met > 200);
}

TEST_CASE("Lights that degenerate are harmless", "[lights][tree]") {
    Uniform random(23);
    SECTION("a thousand at one place") {
        Scene scene = emptyScene();
        for (int i = 0; i < 1000; ++i) {
            Light light = randomLight(random, i);
            if (i % 2 == 0)
                light.shape = PointLight{DVec3(1, 2, 3)};
            else
                light.shape = SphereLight{DVec3(1, 2, 3), 0.1};
            scene.lights.push_back(light);
        }
        const Lit lit(scene);
        const Vec3 normal = glm::normalize(Vec3(1, 2, 3));
        double truth = 0;
        for (const LightPart &part : lit.table().parts) truth += irradiance(lit.table(), part, Vec3(0), normal);
        const Estimate e = sampledIrradiance(lit.table(), {Vec3(0), normal}, normal, random, 20000);
        CHECK(std::fabs(e.mean - truth) < 4.5 * e.error + 1e-3 * truth);
        const LightChoice atThem = chooseLight(lit.table(), {Vec3(1, 2, 3)}, 0.5F);
        CHECK(atThem.entry != kNone);
        CHECK(std::isfinite(atThem.probability));
    }
    SECTION("a mesh of triangles without area") {
        Scene scene = emptyScene();
        scene.objects.push_back(emitter(randomTriangles(random, 100, 1, 1), 5, false));
        const Lit lit(scene);
        CHECK(chooseLight(lit.table(), {Vec3(0)}, 0.5F).entry == kNone);
    }
    SECTION("some triangles without area are never chosen") {
        Scene scene = emptyScene();
        scene.objects.push_back(emitter(randomTriangles(random, 100, 1, 2), 5, true));
        const Lit lit(scene);
        for (Index t = 0; t < 100; t += 2) CHECK(choiceProbability(lit.table(), {0, t}, {Vec3(0.1F, 0, 0)}) == 0);
        for (Index t = 1; t < 100; t += 2) CHECK(choiceProbability(lit.table(), {0, t}, {Vec3(9, 0, 0)}) > 0);
    }
    SECTION("all face away") {
        Scene scene = emptyScene();
        scene.objects.push_back(emitter(makeGrid(10, 10, 2), 5, false)); // faces +z
        const Lit lit(scene);
        CHECK(chooseLight(lit.table(), {Vec3(0, 0, -4)}, 0.5F).entry == kNone);
        CHECK(sampleLight(lit.table(), {Vec3(0, 0, -4)}, 0, 0.5F, {0.5F, 0.5F}).pdf == 0);
        CHECK(chooseLight(lit.table(), {Vec3(0, 0, 4)}, 0.5F).entry == 0);
        CHECK(choiceProbability(lit.table(), {0, 3}, {Vec3(0, 0, -4)}) == 0);
    }
    SECTION("black and dim lights among bright ones") {
        Scene scene = manyLights(40, 0, false);
        for (std::size_t i = 0; i < 20; ++i) scene.lights[i].radiance = Vec3(i % 2 == 0 ? 0.0F : 1e-30F);
        const Lit lit(scene);
        for (int i = 0; i < 1000; ++i) {
            const LightChoice choice = chooseLight(lit.table(), {randomPoint(random, 5)}, random.number());
            if (choice.entry != kNone) CHECK(choice.probability > 0);
        }
    }
}

TEST_CASE("The tree is the same for any number of threads and as deep as its paths allow", "[lights][tree][determinism]") {
    Uniform random(29);
    std::vector<LightBounds> lights(20000);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        // Places that halve towards a corner: bins of equal width peel off a few at a time.
        const float scale = std::ldexp(1.0F, -static_cast<int>(i % 100));
        lights[i].lower = lights[i].upper = scale * randomPoint(random, 2);
        lights[i].axis = randomDirection(random);
        lights[i].cosSpread = i % 3 == 0 ? -1.0F : 0.9F;
        lights[i].power = random.number() + 0.01F;
    }
    const auto build = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return buildLightTree(lights);
    };
    const LightTree one = build(1);
    const LightTree two = build(2);
    REQUIRE(one.nodes.size() == 2 * lights.size() - 1);
    REQUIRE(two.nodes.size() == one.nodes.size());
    CHECK(std::memcmp(one.nodes.data(), two.nodes.data(), one.nodes.size() * sizeof(LightNode)) == 0);
    CHECK(one.paths == two.paths);
    // Every path leads to its light.
    std::size_t astray = 0;
    for (Index light = 0; light < lights.size(); ++light) {
        Index at = 0;
        for (std::uint64_t path = one.paths[light]; !one.nodes[at].isLeaf(); path >>= 1)
            at = one.nodes[at].link + static_cast<Index>(path & 1);
        astray += one.nodes[at].link != light ? 1 : 0;
    }
    CHECK(astray == 0);
    CHECK(sizeof(LightNode) == 44);
}

TEST_CASE("Images lit by many emitters are the same bits for one and two threads", "[lights][tree][render][determinism]") {
    Scene scene = smallScene(makeObject(makeGrid(4, 4, 3)), ggxMaterial(0.3F, 0.3F), 24);
    Uniform random(31);
    scene.objects.push_back(emitter(randomTriangles(random, 300, 2), 3, true));
    for (int i = 0; i < 60; ++i) scene.lights.push_back(randomLight(random, i));
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return renderImage(scene, 1, 8);
    };
    CHECK(onThreads(1) == onThreads(2));
}

TEST_CASE("The tree is kept where nothing moves, and is that of a fresh scene where something has", "[lights][tree]") {
    Scene scene = manyLights(60, 40, true);
    StageTimes times;
    LightTable table;
    const auto placedAt = [&](RenderScene &ready, double frame, LightTable &into) {
        ready.setFrame(frame, times);
        return placeLights(scene, ready.objects(), ready.worldFromRender(), glm::inverse(ready.worldFromRender()), into);
    };
    const auto isKept = [&](RenderScene &ready, double frame) {
        const bool kept = placedAt(ready, frame, table);
        RenderScene again(scene, true);
        LightTable fresh;
        CHECK_FALSE(placedAt(again, frame, fresh));
        REQUIRE(!table.few);
        const LightTable &a = table;
        const LightTable &b = fresh;
        REQUIRE(a.tree.nodes.size() == b.tree.nodes.size());
        CHECK(std::memcmp(a.tree.nodes.data(), b.tree.nodes.data(), a.tree.nodes.size() * sizeof(LightNode)) == 0);
        CHECK(a.tree.paths == b.tree.paths);
        CHECK(a.everywhere == b.everywhere);
        for (std::size_t i = 0; i < a.entries.size(); ++i) CHECK(a.entries[i].firstPart == b.entries[i].firstPart);
        return kept;
    };
    SECTION("nothing, then a light of the scene") {
        RenderScene ready(scene, true);
        CHECK_FALSE(isKept(ready, 1));
        CHECK(isKept(ready, 2));
        CHECK(isKept(ready, 2));
        scene.lights[7].radiance *= 2;
        CHECK_FALSE(isKept(ready, 3));
        CHECK(isKept(ready, 4));
        scene.lights[6].shape = PointLight{DVec3(1, 0, 2)};
        CHECK_FALSE(isKept(ready, 5));
        scene.lights[5].cameraVisible = !scene.lights[5].cameraVisible;
        CHECK(isKept(ready, 6));
        CHECK(table.entries[6].cameraVisible == scene.lights[5].cameraVisible); // the sky comes first
        scene.lights.pop_back();
        CHECK_FALSE(isKept(ready, 7));
    }
    SECTION("the camera until frame 3") {
        scene.camera.position.keys = {{1, DVec3(0)}, {3, DVec3(0, 0, 2)}};
        RenderScene ready(scene, true);
        CHECK_FALSE(isKept(ready, 1));
        CHECK_FALSE(isKept(ready, 2));
        CHECK_FALSE(isKept(ready, 3));
        CHECK(isKept(ready, 4));
    }
    SECTION("an emitter until frame 3") {
        for (const bool deforms : {false, true}) {
            scene = manyLights(60, 40, true);
            if (deforms) {
                scene.objects[1].deformers = {stretchDeformer(DVec3(1))};
                scene.objects[1].deformers[0].factor.keys = {{1, DVec3(1)}, {3, DVec3(2, 1, 1)}};
            } else {
                scene.objects[1].placement.translation.keys = {{1, DVec3(0)}, {3, DVec3(1, 0, 0)}};
            }
            RenderScene ready(scene, true);
            CHECK_FALSE(isKept(ready, 1));
            CHECK_FALSE(isKept(ready, 2));
            CHECK_FALSE(isKept(ready, 3));
            if (!deforms) CHECK(isKept(ready, 4));
        }
    }
    SECTION("another mesh, which shines not") {
        scene.objects.push_back(makeObject(makeTorus(8, 8, 0.5F, 0.2F)));
        scene.objects.back().placement.translation.keys = {{1, DVec3(0)}, {3, DVec3(1, 0, 0)}};
        RenderScene ready(scene, true);
        CHECK_FALSE(isKept(ready, 1));
        CHECK(isKept(ready, 2));
    }
}
