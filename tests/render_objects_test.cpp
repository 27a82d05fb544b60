/// Cameras, textures, subdivided meshes and sequences, through the renderer.

#include "assets.h"
#include "catch.h"
#include "render_fixtures.h"

#include "taut/formats/write_mesh.h"
#include "taut/render/pixel_filter.h"
#include "taut/scene/load_scene.h"

#include <fstream>

using namespace taut;
using namespace taut::test;

TEST_CASE("A thin lens spreads a point over its circle of confusion", "[render][camera]") {
    Scene scene;
    scene.render.width = scene.render.height = 64;
    scene.render.boxFilter = true;
    scene.materials = {Material{}};
    scene.objects = {makeObject(makeSphere(16, 8, 0.002F))};
    scene.objects[0].emission.value = Vec3(1);
    scene.camera.position = DVec3(0, -2, 0);
    scene.camera.fovY = 0.2;
    scene.camera.focusDistance = 1;
    const auto spread = [&](double aperture) {
        scene.camera.apertureRadius = aperture;
        const std::vector<float> image = renderImage(scene, 1, 1024);
        double weight = 0;
        double moment = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const double value = static_cast<double>(image[static_cast<std::size_t>((y * 64 + x) * 4)]);
                weight += value;
                moment += value * ((x - 31.5) * (x - 31.5) + (y - 31.5) * (y - 31.5));
            }
        CHECK(weight > 0);
        return moment / weight;
    };
    // A point at depth 2 seen through a lens of radius r focused at 1 covers a disk of radius r (2 - 1) / 2 in the plane of focus;
    // the mean square distance in a disk is half its radius squared.
    const double pixel = 2 * std::tan(0.1) / 64;
    const double radius = 0.05 * 0.5 / pixel;
    CHECK(spread(0.05) == Approx(radius * radius / 2).epsilon(0.03));
    CHECK(spread(0) < 1);
}

TEST_CASE("Textured alpha, rotation and colour are what their texels say", "[render][texture]") {
    const Scene plain = smallScene(makeObject(makeGrid(4, 4, 1.5F)), ggxMaterial(0.1F, 0.3F, 0.6F));
    Scene textured = plain;
    Texture half;
    half.width = half.height = 2;
    half.channels = 1;
    half.texels = {0.5F, 0.5F, 0.5F, 0.5F};
    textured.textures = {half};
    Material &material = textured.materials[0];
    material.alphaX = {0.2F, 0, 0};
    material.alphaY = {0.6F, 0, 0};
    material.rotation = {1.2F, 0, 0};
    material.color = {Vec3(2), 0};
    CHECK(greatestDifference(renderImage(plain, 1, 16), renderImage(textured, 1, 16)) < 1e-4F);
}

TEST_CASE("A subdivided mesh is at rest where it is not deformed, and follows where it is", "[render][subdivision]") {
    Object torus = makeObject(makeTorus(12, 8, 0.8F, 0.3F));
    torus.subdivision.level = 3;
    const auto stretchRange = [](const Object &object) {
        Scene scene = smallScene(object, ggxMaterial(0.2F, 0.2F));
        const DeformedVertices frame = surfaceOf(scene.objects[0], 1);
        Vec2 range(kInfinity, 0);
        for (std::size_t v = 0; v < frame.ds.size(); ++v) {
            const float a = glm::length(frame.ds[v]);
            const float b = glm::dot(frame.ds[v], frame.dt[v]) / a;
            const Vec2 sigma = singularValues(a, b, 0, std::sqrt(std::fmax(0.0F, glm::dot(frame.dt[v], frame.dt[v]) - b * b)));
            range = {std::fmin(range.x, sigma.y), std::fmax(range.y, sigma.x)};
        }
        return range;
    };
    const Vec2 rest = stretchRange(torus);
    CHECK(rest.x == Approx(1).epsilon(1e-3));
    CHECK(rest.y == Approx(1).epsilon(1e-3));
    torus.deformers = {stretchDeformer(DVec3(2, 2, 2))};
    const Vec2 doubled = stretchRange(torus);
    CHECK(doubled.x == Approx(2).epsilon(1e-3));
    CHECK(doubled.y == Approx(2).epsilon(1e-3));
    torus.deformers = {shearDeformer(1.0, 0, 2)};
    CHECK(stretchRange(torus).y > 1.3F);
}

TEST_CASE("A sequence of OBJ files moves, interpolates and carries its stretch", "[render][sequence]") {
    const std::string folder = outputFolder("sequence");
    for (const int frame : {1, 3}) {
        Mesh mesh = makeGrid(6, 6, 1);
        for (Vec3 &p : mesh.positions) p.x *= static_cast<float>(frame); // stretched by 1 and 3, so by 2 between
        writeObj(mesh, folder + "/sheet.000" + std::to_string(frame) + ".obj");
    }
    std::ofstream(folder + "/scene.toml") << "[[mesh]]\nfile = \"sheet.####.obj\"\n";
    Warnings warnings;
    const Scene scene = loadScene(folder + "/scene.toml", {}, warnings);
    for (const auto &[frame, stretch] : {std::pair(1.0, 1.0F), std::pair(2.0, 2.0F), std::pair(3.0, 3.0F), std::pair(2.5, 2.5F)}) {
        const DeformedVertices surface = surfaceOf(scene.objects[0], frame);
        for (const Vec3 &ds : surface.ds) REQUIRE(glm::length(ds) == Approx(stretch).epsilon(1e-4));
        for (const Vec3 &dt : surface.dt) REQUIRE(glm::length(dt) == Approx(1).epsilon(1e-4));
    }
}

TEST_CASE("A captured sequence renders", "[render][sequence]") {
    const auto first = asset("seq/kick_obj/kick.0000.obj");
    if (!first) return;
    std::string pattern = *first;
    pattern.replace(pattern.find("0000"), 4, "####");
    Warnings warnings;
    const Scene scene = loadScene(pattern, {"render.width=48", "render.height=64", "mesh.0.up=\"y\""}, warnings);
    CHECK(warnings.lines.empty());
    for (const double frame : {0.0, 4.5, 12.0}) {
        const std::vector<float> image = renderImage(scene, frame, 4);
        CHECK(std::all_of(image.begin(), image.end(), [](float v) { return std::isfinite(v); }));
    }
}

TEST_CASE("The filter is Blackman-Harris: its samples have the window's moments", "[render][camera]") {
    // Independent truth: moments of the window by quadrature in double.
    double weight = 0;
    double second = 0;
    double fourth = 0;
    for (int i = 0; i < 20000; ++i) {
        const double x = (i + 0.5) / 20000;
        const double w = 6.283185307179586 * x;
        const double value = 0.35875 - 0.48829 * std::cos(w) + 0.14128 * std::cos(2 * w) - 0.01168 * std::cos(3 * w);
        const double offset = 1.5 * (2 * x - 1);
        weight += value;
        second += value * offset * offset;
        fourth += value * offset * offset * offset * offset;
    }
    double sampledSecond = 0;
    double sampledFourth = 0;
    double mean = 0;
    constexpr int kSamples = 1 << 16;
    for (int i = 0; i < kSamples; ++i) {
        const float u = (static_cast<float>(i) + 0.5F) / kSamples;
        const double x = static_cast<double>(sampleFilter(false, {u, 0.5F}).x);
        mean += x / kSamples;
        sampledSecond += x * x / kSamples;
        sampledFourth += x * x * x * x / kSamples;
    }
    CHECK(mean == Approx(0).margin(1e-4));
    CHECK(sampledSecond == Approx(second / weight).epsilon(2e-3));
    CHECK(sampledFourth == Approx(fourth / weight).epsilon(5e-3));
    CHECK(std::fabs(sampleFilter(false, {0, kOneMinusEpsilon}).x) <= 1.5F);
    CHECK(std::fabs(sampleFilter(false, {0, kOneMinusEpsilon}).y) <= 1.5F);
}

TEST_CASE("A scene file's poisson reaches the gloss", "[render][rest]") {
    const std::string folder = outputFolder("poisson");
    writeObj(makeGrid(4, 4, 2), folder + "/sheet.obj");
    std::ofstream(folder + "/scene.toml") << "[render]\nwidth = 16\nheight = 16\n[material.m]\ntype = \"conductor\"\nalpha = 0.2\n"
                                          << "[[mesh]]\nfile = \"sheet.obj\"\nmaterial = \"m\"\nscale = [[1, 1], [2, 2]]\n";
    for (const auto &[poisson, expected] : {std::pair("0", 0.1F), std::pair("-1", 0.2F), std::pair("0.5", 0.025F)}) {
        Warnings warnings;
        const Scene scene = loadScene(folder + "/scene.toml", {std::string("material.m.poisson=") + poisson}, warnings);
        const std::vector<float> image = renderImage(scene, 2, 2, {"alpha"});
        const std::size_t centre = (8 * 16 + 8) * 7;
        INFO("poisson " << poisson); // lambda = 4^(-nu / (1 - nu)): 1, 2 and 1/4; alpha = 0.2 lambda / 2
        CHECK(image[centre + 4] == Approx(expected).epsilon(1e-4));
    }
}
