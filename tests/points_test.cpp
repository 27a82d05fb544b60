/// Points from anywhere: arrays and functions of the caller move a mesh as deformers and files do; changes between two frames.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/base/error.h"

#include <iostream>
#include <malloc.h>

using namespace taut;
using namespace taut::test;

namespace {

/// x is displaced by `amount` times y.
std::vector<Vec3> sheared(const std::vector<Vec3> &rest, float amount) {
    std::vector<Vec3> out = rest;
    for (Vec3 &p : out) p.x += amount * p.y;
    return out;
}

/// 0 at frame 1, 1 at frame 3.
float amountAt(double frame) {
    return static_cast<float>(glm::clamp((frame - 1) / 2, 0.0, 1.0));
}

Object plate(int cells) {
    return makeObject(makeGrid(cells, cells, 2));
}

Object shearedPlate(int cells) {
    Object object = plate(cells);
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 1;
    shear.amount.keys = {{1, 0.0}, {3, 1.0}};
    object.deformers = {shear};
    return object;
}

/// From straight above, so that the way into camera space rounds nothing.
Scene fromAbove(Object object) {
    Scene scene = smallScene(std::move(object), ggxMaterial(0.1F, 0.4F));
    scene.camera.position = DVec3(0, 0, 4);
    scene.camera.lookAt = DVec3(0);
    scene.camera.up = DVec3(0, 1, 0);
    return scene;
}

std::vector<float> pictureOf(RenderScene &scene, double frame) {
    StageTimes times;
    scene.setFrame(frame, times);
    FrameOptions options;
    options.spp = 4;
    options.seed = 3;
    const std::string_view names[] = {"m", "stretch"};
    options.aovs = aovsNamed(names, "test");
    return renderFrame(scene, options).film.resolve();
}

} // namespace

TEST_CASE("points: a shear by a deformer, by the caller's arrays and by his function give the same bits", "[points]") {
    const Object deformed = shearedPlate(16);
    const std::vector<Vec3> rest = deformed.mesh->positions;
    // Sides of 1/8 m and amounts of halves: every position is exact, however it was reached.
    std::vector<std::vector<Vec3>> frames;
    for (const float amount : {0.0F, 0.5F, 1.0F}) frames.push_back(sheared(rest, amount));
    Object byArrays = plate(16);
    byArrays.points = pointFrames({frames[0], frames[1], frames[2]});
    Object byFunction = plate(16);
    byFunction.points = pointFunction(rest.size(), [&](double frame, std::span<Vec3> out) {
        const std::vector<Vec3> now = sheared(rest, amountAt(frame));
        std::copy(now.begin(), now.end(), out.begin());
    });
    for (const double shutter : {0.0, 1.0})
        for (const double frame : {1.0, 2.0, 2.5, 3.0}) {
            const auto picture = [&](const Object &object) {
                Scene scene = fromAbove(object);
                scene.render.shutter = shutter;
                RenderScene ready(std::move(scene), true);
                return pictureOf(ready, frame);
            };
            INFO("frame " << frame << ", shutter " << shutter);
            const std::vector<float> reference = picture(deformed);
            CHECK(picture(byArrays) == reference);
            CHECK(picture(byFunction) == reference);
        }
    // It is sheared indeed: greatest stretch 1.618 at amount 1.
    RenderScene ready(fromAbove(byArrays), true);
    const std::vector<float> last = pictureOf(ready, 3);
    const std::size_t middle = (24U * 48U + 24U) * 9U;
    CHECK(last[middle + 7] == Approx(1.6180339887));
}

TEST_CASE("points: on a curved mesh under any view they follow as deformers do, but for rounding and the fit", "[points]") {
    Object torus = shearedTorus(64, 32);
    const std::vector<Vec3> rest = torus.mesh->positions;
    RenderScene byDeformer(smallScene(torus, ggxMaterial(0.2F, 0.4F)), true);
    torus.deformers.clear();
    torus.points = pointFunction(rest.size(), [&](double frame, std::span<Vec3> out) {
        for (std::size_t i = 0; i < rest.size(); ++i) out[i] = rest[i] + Vec3(0.8F * amountAt(frame) * rest[i].z, 0, 0);
    });
    RenderScene byPoints(smallScene(torus, ggxMaterial(0.2F, 0.4F)), true);
    const std::vector<float> a = pictureOf(byDeformer, 3);
    const std::vector<float> b = pictureOf(byPoints, 3);
    REQUIRE(a.size() == b.size());
    double difference = 0;
    double stretch = 0;
    for (std::size_t p = 0; p < a.size(); p += 9) {
        if (a[p + 3] < 1 || b[p + 3] < 1) continue;
        difference = std::max(difference, std::fabs(static_cast<double>(a[p + 7] - b[p + 7])));
        stretch = std::max(stretch, static_cast<double>(a[p + 7]));
    }
    CHECK(stretch > 1.4);
    CHECK(difference < 2e-3);
}

TEST_CASE("points: a million vertices handed in are read where they are", "[points]") {
    Object object = plate(1000);
    std::vector<Vec3> mine = sheared(object.mesh->positions, 0.25F);
    REQUIRE(mine.size() > 1'000'000);
    object.points = pointFrames({mine});
    ObjectMotion motion;
    motionAtFrame(object, 7, 24, DMat4(1), motion);
    CHECK(motion.state.control.data() == mine.data());
    Scene scene = fromAbove(object);
    scene.render.width = scene.render.height = 8;
    RenderScene ready(std::move(scene), true);
    StageTimes times;
    ready.setFrame(1, times);
    const auto held = [] {
        const struct mallinfo2 info = mallinfo2();
        return info.uordblks + info.hblkhd;
    };
    // Not one more array of them is held, or was: malloc would have mapped it.
    const std::size_t before = held();
    const bool counts = mallopt(M_MMAP_THRESHOLD, 1 << 20) == 1;
    if (!counts) std::cout << "SKIPPED: the malloc of a sanitizer keeps no counts" << std::endl;
    const std::size_t maps = mallinfo2().hblks;
    for (Vec3 &p : mine) p.z = 0.125F;
    ready.setFrame(1, times); // the same frame: the arrays are the caller's, who wrote into them
    if (counts) {
        CHECK(held() <= before + (1U << 20U));
        CHECK(mallinfo2().hblks == maps);
    }
    CHECK(ready.objects().front().steps.front().positions[0].z == Approx(0.125 - 4));
}

TEST_CASE("points: what does not fit the mesh is refused by name", "[points]") {
    const std::vector<Vec3> one(1);
    const std::vector<Vec3> two(2);
    CHECK_THROWS_WITH(pointFrames({}), Catch::Contains("found no frame"));
    CHECK_THROWS_WITH(pointFrames({one, two}), Catch::Contains("found 2 positions in array 1, expected 1"));
    CHECK_THROWS_WITH(pointFunction(3, {}), Catch::Contains("found no function"));
    Object object = plate(2);
    const std::vector<Vec3> rest = object.mesh->positions;
    std::vector<Vec3> points = rest;
    object.points = pointFrames({points});
    points[4].y = std::numeric_limits<float>::quiet_NaN();
    ObjectMotion motion;
    CHECK_THROWS_WITH(motionAtFrame(object, 2.5, 24, DMat4(1), motion),
                      Catch::Contains("found a point that is not finite at frame 2.5 (point 4)"));
    // What the caller's function throws comes out as it is.
    object.points = pointFunction(rest.size(), [](double, std::span<Vec3>) { throw std::out_of_range("mine"); });
    RenderScene ready(fromAbove(object), true);
    StageTimes times;
    CHECK_THROWS_AS(ready.setFrame(1, times), std::out_of_range);
}

TEST_CASE("points: places among frames", "[points]") {
    const std::vector<double> frames{1, 2, 5};
    const auto at = [&](double frame) {
        const SamplePlace place = placeAmong(frames, frame);
        return static_cast<double>(place.before) + static_cast<double>(place.u);
    };
    CHECK(at(-4) == 0);
    CHECK(at(1) == 0);
    CHECK(at(1.5) == 0.5);
    CHECK(at(2) == 1);
    CHECK(at(4.25) == 1.75);
    CHECK(at(5) == 2);
    CHECK(at(99) == 2);
}

TEST_CASE("changes between two frames give the picture of a scene made so, and move nothing else", "[points][changes]") {
    Scene scene = smallScene(shearedTorus(32, 16), ggxMaterial(0.1F, 0.3F));
    scene.objects.push_back(plate(4));
    scene.objects[1].placement.translation = DVec3(0, 0, -0.5);
    const std::vector<Vec3> rest = scene.objects[0].mesh->positions;
    scene.objects[0].points = pointFrames({rest});
    RenderScene ready(scene, true);
    const std::vector<float> before = pictureOf(ready, 2);
    const auto anew = [&] {
        RenderScene fresh(scene, true);
        return pictureOf(fresh, 2);
    };
    CHECK(before == anew());
    const void *const stencils = ready.objects()[0].surface.stencilWeights.data();
    const Vec3 *const positions = ready.objects()[0].steps.front().positions.data();

    scene.materials[0].alphaX.value = 0.02F;
    ready.setMaterial(0, scene.materials[0]);
    const std::vector<float> glossy = pictureOf(ready, 2);
    CHECK(glossy == anew());
    CHECK(glossy != before);

    scene.lights[0].radiance = Vec3(1, 5, 9);
    ready.setLight(0, scene.lights[0]);
    CHECK(pictureOf(ready, 2) == anew());

    scene.camera.position = DVec3(1, -2, 2);
    ready.setCamera(scene.camera);
    CHECK(pictureOf(ready, 2) == anew());

    const std::vector<Vec3> moved = sheared(rest, 0.7F);
    scene.objects[0].points = pointFrames({moved});
    ready.setPoints(0, scene.objects[0].points);
    const std::vector<float> last = pictureOf(ready, 2);
    CHECK(last == anew());
    CHECK(last != glossy);
    // Topology and buffers are those of the beginning.
    CHECK(ready.objects()[0].surface.stencilWeights.data() == stencils);
    CHECK(ready.objects()[0].steps.front().positions.data() == positions);

    CHECK_THROWS_WITH(ready.setMaterial(3, scene.materials[0]), Catch::Contains("found material 3, expected one of 1"));
    CHECK_THROWS_WITH(ready.setLight(1, scene.lights[0]), Catch::Contains("found light 1"));
    CHECK_THROWS_WITH(ready.setPoints(2, nullptr), Catch::Contains("found object 2"));
    CHECK_THROWS_WITH(ready.setPoints(1, scene.objects[0].points), Catch::Contains("rigid"));
    CHECK_THROWS_WITH(ready.setPoints(0, pointFunction(5, [](double, std::span<Vec3>) {})), Catch::Contains("found 5 points"));
    // A value that makes the scene none is refused, and the old one stays.
    Material wrong = scene.materials[0];
    wrong.alphaX.value = -1;
    CHECK_THROWS_WITH(ready.setMaterial(0, wrong), Catch::Contains("alphaX: found -1"));
    Camera blind = scene.camera;
    blind.position = blind.lookAt;
    CHECK_THROWS_WITH(ready.setCamera(blind), Catch::Contains("position equal to look_at"));
    CHECK(pictureOf(ready, 2) == last);
}
