// Nothing in the way: glass of the index of air is not there, a camera straight down looks down, and what no face has is not framed.

#include "catch.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

/// Largest difference from `value` over the colours of a picture of RGBA.
float greatestFrom(const std::vector<float> &rgba, float value) {
    float worst = 0;
    for (std::size_t i = 0; i < rgba.size(); ++i)
        if (i % 4 != 3 && !(std::fabs(rgba[i] - value) <= worst)) worst = std::fabs(rgba[i] - value);
    return worst;
}

} // namespace

TEST_CASE("Glass of index 1 is not there: the case", "[glass][furnace][cases]") {
    const auto path = caseFile("glass-ior-1/a.toml");
    if (!path) return;
    for (const std::string ior : {"1", "1.0000001"})
        for (const std::string alpha : {"0.0001", "0.1", "1", "[0.05, 0.8]"})
            for (const std::string multiscatter : {"auto", "off", "walk"}) {
                Warnings warnings;
                const Scene scene = loadScene(*path,
                                              {"material.m.ior=" + ior, "material.m.alpha=" + alpha,
                                               "material.m.multiscatter='" + multiscatter + "'", "render.width=16", "render.height=12"},
                                              warnings);
                INFO("ior " << ior << ", alpha " << alpha << ", multiscatter " << multiscatter);
                CHECK(greatestFrom(renderImage(scene, 1, 4), 1) < 1e-5F);
            }
}

TEST_CASE("Glass of about the index of what is around it shows what is behind it, through its tint", "[glass]") {
    const float ior = GENERATE(1.0F, 0.99999994F, 1.00005F);
    const Multiscatter model = GENERATE(Multiscatter::Off, Multiscatter::Walk);
    Material clear = ggxMaterial(0.3F, 0.6F);
    clear.type = BsdfType::Dielectric;
    clear.ior = ior;
    clear.multiscatter = model;
    clear.color.value = Vec3(0.5F, 1, 0.25F);
    Object ball = makeObject(makeSphere(24, 12, 0.5F));
    ball.deformers = {stretchDeformer(DVec3(2, 0.5, 1))};
    Scene scene = smallScene(ball, clear, 24);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.camera.position = DVec3(0, -1.5, 0);
    const std::vector<float> image = renderImage(scene, 1, 4);
    const std::size_t middle = (12 * 24 + 12) * 4;
    for (std::size_t c = 0; c < 3; ++c)
        CHECK(image[middle + c] == Approx(sqr(clear.color.value[static_cast<int>(c)])).epsilon(1e-5)); // in and out
}

TEST_CASE("Glass that bends light a little keeps it all", "[glass][furnace]") {
    const float ior = GENERATE(1.0002F, 1.001F, 1.02F);
    const float alpha = GENERATE(1e-4F, 0.1F, 1.0F);
    Material clear = ggxMaterial(alpha, alpha);
    clear.type = BsdfType::Dielectric;
    clear.ior = ior;
    clear.multiscatter = Multiscatter::Walk;
    Scene scene = smallScene(makeObject(makeSphere(48, 24, 0.5F)), clear, 16);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.render.maxEvents = 64;
    const std::vector<float> image = renderImage(scene, 1, 64);
    double sum = 0;
    for (std::size_t i = 0; i < image.size(); i += 4) sum += static_cast<double>(image[i]);
    INFO("ior " << ior << ", alpha " << alpha);
    CHECK(sum / (static_cast<double>(image.size()) / 4) == Approx(1).epsilon(5e-3));
}

TEST_CASE("A camera straight down or up looks there, whichever way is up", "[camera]") {
    const DVec3 up = GENERATE(DVec3(0, 0, 1), DVec3(0, 1, 0), DVec3(1, 0, 0), DVec3(0, 0, 2), DVec3(0, 0, -1));
    const double side = GENERATE(1.0, -1.0);
    const double tilt = GENERATE(0.0, 1e-12, 1e-7); // nearly straight is no worse
    Camera camera;
    camera.lookAt = Keyed<DVec3>(DVec3(1, 2, 3));
    camera.position = Keyed<DVec3>(DVec3(1, 2, 3) + side * 4.0 * glm::normalize(up) + tilt * DVec3(0.3, 0.4, 0.5));
    camera.up = Keyed<DVec3>(up);
    const CameraState state = cameraAtFrame(camera, 1, 24);
    const DMat3 axes(state.worldFromCamera);
    const DMat3 gram = glm::transpose(axes) * axes;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) CHECK(gram[c][r] == Approx(c == r ? 1 : 0).margin(1e-9));
    CHECK(glm::determinant(axes) == Approx(1));
    CHECK(glm::length(axes[2] - side * glm::normalize(up)) < 1e-6);
    Scene scene = smallScene(makeObject(makeSphere(12, 6, 0.5F)), ggxMaterial(0.2F, 0.2F), 8);
    scene.camera = camera;
    scene.objects[0].placement.translation = Keyed<DVec3>(DVec3(1, 2, 3));
    const std::vector<float> image = renderImage(scene, 1, 4);
    for (const float value : image) REQUIRE(std::isfinite(value));
    CHECK(image[(4 * 8 + 4) * 4] > 0); // the ball is in the middle
}

TEST_CASE("The default view is over the vertices of faces: the case", "[camera][cases]") {
    const auto none = caseFile("stray-vertex/none.obj");
    const auto stray = caseFile("stray-vertex/stray.obj");
    if (!none || !stray) return;
    Warnings warnings;
    const Scene a = loadScene(*none, {}, warnings);
    const Scene b = loadScene(*stray, {}, warnings);
    CHECK(a.camera.position.first() == b.camera.position.first());
    CHECK(a.camera.lookAt.first() == b.camera.lookAt.first());
}

TEST_CASE("The default view leaves out stray points of any object, deformed or placed", "[camera]") {
    const std::string folder = outputFolder("stray_view");
    const std::string quad = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n";
    writeTo(folder, "a.obj", quad + "f 1 2 3 4\n");
    writeTo(folder, "b.obj", "v 900 -700 1e5\n" + quad + "v 0 0 -1e6\nf 2 3 4 5\n");
    const auto cameraOf = [&](const std::string &mesh) {
        return loadText(folder, "[[mesh]]\nfile = \"" + mesh +
                                    "\"\nscale = 2\ntranslate = [1, 2, 3]\n[[mesh.deform]]\ntype = \"stretch\"\nfactor = [1, 1, 3]\n")
            .camera;
    };
    CHECK(glm::length(cameraOf("a.obj").position.first() - cameraOf("b.obj").position.first()) < 1e-6);
}
