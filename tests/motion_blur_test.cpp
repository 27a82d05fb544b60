/// Motion blur: shutters against closed forms and against the mean of still images.

#include "catch.h"
#include "render_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

/// A white square of side 0.5 that crosses a camera looking straight down, 2 m of the plane z = 0 to 64 pixels.
Scene crossingSquare(double travel) {
    Scene scene;
    scene.render.width = 64;
    scene.render.height = 8;
    scene.render.boxFilter = true;
    scene.render.shutter = 0.5;
    scene.materials = {Material{}};
    scene.objects = {makeObject(makeGrid(1, 1, 0.5F))};
    scene.objects[0].emission.value = Vec3(1);
    scene.objects[0].placement.translation.keys = {{0, DVec3(-travel, 0, 0)}, {2, DVec3(travel, 0, 0)}}; // travel a frame, centred on 1
    scene.camera.position = DVec3(0, 0, 100);
    scene.camera.up = Keyed<DVec3>(DVec3(0, 1, 0));
    scene.camera.fovY = 2 * std::atan(0.125 / 100);
    return scene;
}

/// Share of the shutter for which [x - w, x + w] holds points between a - half and a + half, a uniform over [-shift, shift]: what
/// a box-filtered pixel of half width w sees of the moving square.
double coverage(double x, double w, double half, double shift) {
    // Integrate the square's cover of the pixel over the shutter: piecewise linear, so a fine sum does.
    double sum = 0;
    const int steps = 4000;
    for (int i = 0; i < steps; ++i) {
        const double a = shift * (2 * (i + 0.5) / steps - 1);
        sum += std::max(0.0, std::min(x + w, a + half) - std::max(x - w, a - half)) / (2 * w);
    }
    return sum / steps;
}

double meanDifference(const std::vector<float> &a, const std::vector<float> &b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::fabs(static_cast<double>(a[i] - b[i]));
    return sum / static_cast<double>(a.size());
}

} // namespace

TEST_CASE("A square that crosses the view leaves the closed-form trail", "[render][motion_blur]") {
    for (const bool cameraMoves : {false, true}) {
        INFO((cameraMoves ? "the camera moves" : "the square moves"));
        Scene scene = crossingSquare(0.8);
        if (cameraMoves) {
            scene.objects[0].placement.translation = Keyed<DVec3>(DVec3(0));
            scene.camera.position.keys = {{0, DVec3(0.8, 0, 100)}, {2, DVec3(-0.8, 0, 100)}};
            scene.camera.lookAt.keys = {{0, DVec3(0.8, 0, 0)}, {2, DVec3(-0.8, 0, 0)}};
        }
        const std::vector<float> image = renderImage(scene, 1, 4096);
        for (int x = 0; x < 64; ++x) {
            const double centre = (x + 0.5) / 32 - 1;
            // Half a frame of 0.8 m a frame: 0.2 m to either side.
            const double expected = coverage(centre, 1.0 / 64, 0.25, 0.2);
            INFO("pixel " << x);
            CHECK(image[static_cast<std::size_t>((4 * 64 + x) * 4)] == Approx(expected).margin(0.02));
        }
    }
}

TEST_CASE("M is interpolated over the shutter: a blurred frame is the mean of the frames within it", "[render][motion_blur]") {
    Object plate = makeObject(makeGrid(8, 8, 1.6F));
    DeformerKeys stretch;
    stretch.type = DeformerType::Stretch;
    stretch.factor.keys = {{0, DVec3(0.4, 1, 1)}, {2, DVec3(3.2, 1, 1)}};
    plate.deformers = {stretch};
    Scene scene = smallScene(plate, ggxMaterial(0.15F, 0.15F), 32);
    scene.render.shutter = 1.6;
    scene.render.motionSteps = 17;
    const std::vector<float> blurred = renderImage(scene, 1, 2048);
    scene.render.shutter = 0;
    constexpr int kFrames = 16;
    std::vector<float> mean(blurred.size(), 0);
    for (int i = 0; i < kFrames; ++i) {
        const std::vector<float> still =
            renderImage(scene, 1 + 1.6 * ((i + 0.5) / kFrames - 0.5), 256, {}, static_cast<std::uint32_t>(100 + i));
        for (std::size_t p = 0; p < mean.size(); ++p) mean[p] += still[p] / kFrames;
    }
    const std::vector<float> sharp = renderImage(scene, 1, 2048);
    CHECK(meanDifference(blurred, mean) < 0.01);
    CHECK(meanDifference(sharp, mean) > 2 * meanDifference(blurred, mean)); // the test can tell them apart
}

TEST_CASE("More steps follow a turning object more closely", "[render][motion_blur]") {
    Scene scene = crossingSquare(0);
    scene.render.height = 64;
    scene.camera.fovY = 2 * std::atan(1.0 / 100);
    scene.render.shutter = 1;
    scene.objects[0].placement.translation = Keyed<DVec3>(DVec3(0));
    scene.objects[0].placement.rotation.keys = {{0, DVec3(0)}, {2, DVec3(0, 0, 4)}}; // two radians in the shutter
    const auto withSteps = [&](int steps) {
        scene.render.motionSteps = steps;
        return renderImage(scene, 1, 1024);
    };
    const std::vector<float> fine = withSteps(65);
    const double two = meanDifference(withSteps(2), fine);
    const double five = meanDifference(withSteps(5), fine);
    CHECK(two > 0.01); // corners cut the arc
    CHECK(five < 0.4 * two);
}

TEST_CASE("What stands still is the same bits with the shutter open", "[render][motion_blur]") {
    Scene scene = smallScene(makeObject(makeTorus(24, 12, 0.8F, 0.3F)), ggxMaterial(0.1F, 0.3F), 24);
    const std::vector<float> closed = renderImage(scene, 1, 16);
    scene.render.shutter = 0.5;
    CHECK(renderImage(scene, 1, 16) == closed);
}

TEST_CASE("A mesh light that moves and grows lights what light sampling and scattered rays agree on", "[render][motion_blur][mis]") {
    // A rough mirror under a growing, moving light panel: MIS weights of both techniques must know the time.
    Scene scene = smallScene(makeObject(makeGrid(2, 2, 3)), ggxMaterial(0.4F, 0.4F), 16);
    scene.lights.clear();
    scene.environment.reset();
    Object panel = makeObject(makeGrid(1, 1, 0.8F));
    panel.emission.value = Vec3(4);
    panel.emissionTwoSided = true;
    panel.placement.translation.keys = {{0, DVec3(-0.5, 0.4, 0.9)}, {2, DVec3(0.5, 0.4, 0.9)}};
    panel.placement.scale.keys = {{0, DVec3(0.3)}, {2, DVec3(2)}};
    scene.objects.push_back(panel);
    scene.render.shutter = 1;
    scene.render.motionSteps = 33;
    const std::vector<float> blurred = renderImage(scene, 1, 1024);
    scene.render.shutter = 0;
    constexpr int kFrames = 32;
    std::vector<float> mean(blurred.size(), 0);
    for (int i = 0; i < kFrames; ++i) {
        const std::vector<float> still = renderImage(scene, 0.5 + (i + 0.5) / kFrames, 128, {}, static_cast<std::uint32_t>(7 + i));
        for (std::size_t p = 0; p < mean.size(); ++p) mean[p] += still[p] / kFrames;
    }
    double a = 0;
    double b = 0;
    for (std::size_t p = 0; p < mean.size(); p += 4) {
        a += static_cast<double>(blurred[p]);
        b += static_cast<double>(mean[p]);
    }
    CHECK(a == Approx(b).epsilon(0.01));
    CHECK(meanDifference(blurred, mean) < 0.02);
}
