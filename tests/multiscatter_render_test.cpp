/// Multiple scattering within the microsurface, seen through the renderer: furnaces that lose nothing, and what the scene file may ask.

#include "catch.h"
#include "render_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

/// Mean radiance of the inner part of a sphere, sheared along x by its height, under a constant sky of radiance one.
double furnace(const Material &material, int spp, bool sun = false) {
    Object sphere = makeObject(makeSphere(256, 128, 0.8F));
    sphere.deformers = {shearDeformer(0.5, 0, 2)};
    Scene scene = smallScene(sphere, material, 32);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    if (sun) scene.lights = {{Vec3(1), DirectionalLight{glm::normalize(DVec3(0.2, 1, -1))}}};
    scene.render.maxEvents = 32;
    const std::vector<float> image = renderImage(scene, 1, spp, {"shading_normal", "position"});
    const DVec3 eye = scene.camera.position.first();
    double sum = 0;
    int count = 0;
    for (std::size_t p = 0; p < image.size(); p += 10) {
        const DVec3 n(image[p + 4], image[p + 5], image[p + 6]);
        const DVec3 position(image[p + 7], image[p + 8], image[p + 9]);
        if (n == DVec3(0) || glm::dot(glm::normalize(n), glm::normalize(eye - position)) < 0.3) continue;
        sum += static_cast<double>(image[p]);
        ++count;
    }
    CHECK(count > 50);
    return sum / count;
}

Material skewed(Multiscatter multiscatter) {
    Material material = ggxMaterial(1, 0.2F, 0.4F);
    material.multiscatter = multiscatter;
    return material;
}

} // namespace

TEST_CASE("White furnace of a sheared sphere, alpha (1, 0.2): walk and compensation give back what is lost", "[render][furnace]") {
    CHECK(furnace(skewed(Multiscatter::Off), 64) < 0.8);
    CHECK(furnace(skewed(Multiscatter::Walk), 256) == Approx(1).margin(0.005));
    CHECK(furnace(skewed(Multiscatter::Compensation), 256) == Approx(1).margin(0.02));
    CHECK(furnace(skewed(Multiscatter::Auto), 256) == Approx(1).margin(0.02));
}

TEST_CASE("White furnace of metallic-roughness: rough metal loses nothing, nothing makes light", "[render][furnace][gltf]") {
    Material metal = skewed(Multiscatter::Walk);
    metal.type = BsdfType::MetallicRoughness;
    metal.metallic.value = 1;
    CHECK(furnace(metal, 256) == Approx(1).margin(0.005));
    metal.multiscatter = Multiscatter::Compensation;
    CHECK(furnace(metal, 256) == Approx(1).margin(0.02));
    metal.multiscatter = Multiscatter::Auto;
    CHECK(furnace(metal, 256) == Approx(1).margin(0.02));
    for (const Multiscatter multiscatter : {Multiscatter::Off, Multiscatter::Auto, Multiscatter::Walk})
        for (const float metallic : {0.0F, 0.5F}) {
            INFO("metallic " << metallic);
            metal.multiscatter = multiscatter;
            metal.metallic.value = metallic;
            const double light = furnace(metal, 256);
            CHECK(light < 1.005);
            CHECK(light > (multiscatter == Multiscatter::Off ? 0.75 : 0.95));
        }
}

TEST_CASE("White furnace of rough glass loses nothing with the walk", "[render][furnace]") {
    Material glass = skewed(Multiscatter::Walk);
    glass.type = BsdfType::Dielectric;
    CHECK(furnace(glass, 256) == Approx(1).margin(0.01));
    glass.multiscatter = Multiscatter::Off;
    CHECK(furnace(glass, 64) < 0.9);
}

TEST_CASE("The walk's light sampling: a sun on rough metal agrees with compensation and beats single scattering", "[render][mis]") {
    const double sky = 1;
    const double walk = furnace(skewed(Multiscatter::Walk), 512, true) - sky;
    const double compensation = furnace(skewed(Multiscatter::Compensation), 256, true) - sky;
    const double off = furnace(skewed(Multiscatter::Off), 64, true) - furnace(skewed(Multiscatter::Off), 64);
    CHECK(walk > 1.1 * off);
    CHECK(compensation == Approx(walk).epsilon(0.3));
}

TEST_CASE("Auto does nothing about smooth materials: the same image as off", "[render][multiscatter]") {
    Material material = ggxMaterial(0.03F, 0.05F);
    const Scene automatic = smallScene(makeObject(makeSphere(32, 16, 0.8F)), material);
    material.multiscatter = Multiscatter::Off;
    CHECK(renderImage(automatic, 1, 4) == renderImage(smallScene(makeObject(makeSphere(32, 16, 0.8F)), material), 1, 4));
    // And leaves separable masking alone, which table and walk know nothing of.
    material = skewed(Multiscatter::Auto);
    material.masking = Masking::Separable;
    const Scene separable = smallScene(makeObject(makeSphere(32, 16, 0.8F)), material);
    material.multiscatter = Multiscatter::Off;
    CHECK(renderImage(separable, 1, 4) == renderImage(smallScene(makeObject(makeSphere(32, 16, 0.8F)), material), 1, 4));
}
