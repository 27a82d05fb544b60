// Rigid meshes of an animation are placed, not moved vertex by vertex: the picture is the same, and precision does not depend on where
// a mesh was modelled or how large its triangles are.

#include "catch.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"

using namespace taut;
using namespace taut::test;

namespace {

Object turningTorus() {
    Object torus = makeObject(makeTorus(40, 20, 0.7F, 0.25F));
    torus.placement.rotation.keys = {{1, DVec3(0)}, {5, DVec3(0.6, 0.4, 1.1)}};
    torus.placement.translation.keys = {{1, DVec3(0)}, {5, DVec3(0.2, -0.1, 0.1)}};
    torus.placement.scale = Keyed<DVec3>(DVec3(1.2, 0.8, 1));
    return torus;
}

std::vector<float> imageAt(RenderScene &ready, double frame, int spp) {
    StageTimes times;
    ready.setFrame(frame, times);
    FrameOptions options;
    options.spp = spp;
    options.seed = 1;
    return renderFrame(ready, options).film.resolve();
}

double meanOf(const std::vector<float> &rgba) {
    double sum = 0;
    for (std::size_t i = 0; i < rgba.size(); i += 4) sum += static_cast<double>(rgba[i]);
    return sum / (static_cast<double>(rgba.size()) / 4);
}

} // namespace

TEST_CASE("A frame of a rigid animation is the frame rendered by itself", "[render][rigid]") {
    const bool blurred = GENERATE(false, true);
    const bool mirrored = GENERATE(false, true);
    const bool emits = GENERATE(false, true);
    Object torus = turningTorus();
    if (mirrored) torus.placement.scale = Keyed<DVec3>(DVec3(-1.2, 0.8, 1));
    if (emits) torus.emission.value = Vec3(1, 0.5F, 0.2F);
    Scene scene = smallScene(torus, ggxMaterial(0.2F, 0.4F));
    scene.objects.push_back(makeObject(makeGrid(4, 4, 3)));
    scene.objects[1].placement.translation = Keyed<DVec3>(DVec3(0, 0, -0.5));
    if (blurred) scene.render.shutter = 0.8;
    RenderScene sequence(scene, true);
    imageAt(sequence, 1, 1);
    const std::vector<float> third = imageAt(sequence, 3, 64);
    CHECK(sequence.objects()[0].instanced);
    RenderScene alone(scene, false);
    // Rounding differs, and with it the odd path at an edge.
    INFO("blurred " << blurred << ", mirrored " << mirrored << ", emits " << emits);
    CHECK(chart::relativeRms(third, imageAt(alone, 3, 64)) < 0.02);
    CHECK(meanOf(third) == Approx(meanOf(imageAt(alone, 3, 64))).epsilon(2e-3));
}

TEST_CASE("A mesh modelled far from its origin is as sharp as one modelled at it", "[render][rigid][precision]") {
    const Scene near = smallScene(turningTorus(), ggxMaterial(0.2F, 0.4F));
    Scene far = near;
    Mesh mesh = makeTorus(40, 20, 0.7F, 0.25F);
    const Vec3 away(512, -256, 128); // multiples of a large power of two: the torus itself loses few digits
    for (Vec3 &p : mesh.positions) p += away;
    far.objects[0].mesh = std::make_shared<const Mesh>(mesh);
    // Placed back: its placement has to undo rotation and scale of the offset.
    Scene still = near;
    for (Scene *scene : {&still, &far}) {
        scene->objects[0].placement = {};
        scene->camera.lookAt = DVec3(0);
    }
    far.objects[0].placement.translation = Keyed<DVec3>(-DVec3(away));
    RenderScene a(still, true);
    RenderScene b(far, true);
    CHECK(chart::relativeRms(imageAt(b, 1, 64), imageAt(a, 1, 64)) < 0.02);
}

TEST_CASE("Large triangles close by do not shade themselves", "[render][rigid][precision]") {
    // A diffuse plane under a constant sky reflects its albedo everywhere; what meets itself again darkens.
    const double size = GENERATE(10.0, 1000.0, 30000.0);
    const bool animated = GENERATE(false, true);
    Scene scene = smallScene(makeObject(makeGrid(1, 1, static_cast<float>(size))), Material{});
    scene.materials[0].type = BsdfType::Diffuse;
    scene.materials[0].color.value = Vec3(0.5F);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.camera.position = DVec3(0.3, 0.1, 1);
    scene.camera.lookAt = DVec3(0.5, 0.7, 0);
    scene.objects[0].placement.rotation = Keyed<DVec3>(DVec3(0, 0, 0.3)); // no axis along a triangle's edge
    RenderScene ready(scene, animated);
    const std::vector<float> image = imageAt(ready, 1, 64);
    INFO("size " << size << ", animated " << animated);
    CHECK(meanOf(image) == Approx(0.5).epsilon(5e-4)); // noise: 1.2e-4
}
