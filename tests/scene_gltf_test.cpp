#include "scene_fixtures.h"

#include <set>

using namespace taut;
using namespace taut::test;

TEST_CASE("a glTF file is a scene", "[scene][gltf]") {
    const std::string folder = sceneFolder("scene");
    Warnings warnings;
    const Scene scene = loadScene(folder + "/figure.glb", {}, warnings);
    CHECK(warnings.lines.empty());
    REQUIRE(scene.objects.size() == 1);
    const Object &body = scene.objects[0];
    CHECK(body.name == "figure/body");
    REQUIRE(body.rig);
    CHECK(body.rig->clip == 0);
    const Material &paint = scene.materials.at(body.materials.at(0));
    CHECK(paint.name == "paint");
    CHECK(paint.type == BsdfType::MetallicRoughness);
    CHECK(paint.alphaIsRoughness);
    CHECK(paint.alphaX.value == 0.5F);
    CHECK(paint.metallic.value == 0.75F);
    CHECK(paint.color.value == Vec3(0.5F, 0.25F, 0.125F));
    // y up becomes z up; after half a second the body has risen by 5.
    CHECK(close(DVec3(worldPositions(scene, body, 13).at(2)), DVec3(0, 0, 6), 1e-5));
    const CameraState camera = cameraAtFrame(scene.camera, 1, 24);
    CHECK(camera.fovY == Approx(0.75));
    CHECK(close(DVec3(camera.worldFromCamera[3]), DVec3(0, -5, 1)));
    CHECK(close(-DVec3(camera.worldFromCamera[2]), DVec3(0, 1, 0)));
    CHECK(scene.environment);
    // Its camera gives way to one in the scene; single settings do not displace it.
    CHECK(!loadScene(folder + "/figure.glb", {"camera.position=[1,2,3]"}, warnings).camera.rig);
    CHECK(loadScene(folder + "/figure.glb", {"camera.fov_deg=20"}, warnings).camera.fovY.first() == Approx(radians(20)));
    CHECK(loadScene(folder + "/figure.glb", {"mesh.0.clip=none"}, warnings).objects.at(0).rig->clip == kNone);
    CHECK(loadScene(folder + "/figure.glb", {"mesh.0.clip=rise", "mesh.0.loop=true"}, warnings).objects.at(0).rig->loop);
}

TEST_CASE("a glTF file within a scene", "[scene][gltf]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, R"(
[material.red]
color = [1, 0, 0]
[[mesh]]
file = "figure.glb"
name = "twin"
[[mesh]]
file = "figure.glb"
name = "twin"
material = { paint = "red" }
translate = [1, 0, 0]
[[light]]
type = "mesh"
mesh = "twin_2"
radiance = 3
[camera]
gltf = "figure.glb"
node = "eye"
translate = [0, 0, 10]
)");
    REQUIRE(scene.objects.size() == 2);
    CHECK(scene.objects[0].name == "twin/body");
    CHECK(scene.objects[1].name == "twin_2/body");
    CHECK(scene.objects[0].mesh == scene.objects[1].mesh); // read once
    CHECK(scene.materials.at(scene.objects[0].materials.at(0)).name == "paint");
    CHECK(scene.materials.at(scene.objects[1].materials.at(0)).name == "red");
    CHECK(scene.objects[0].emission.value == Vec3(0));
    CHECK(scene.objects[1].emission.value == Vec3(3));
    CHECK(!scene.environment);
    CHECK(close(DVec3(cameraAtFrame(scene.camera, 1, 24).worldFromCamera[3]), DVec3(0, -5, 11)));
}

TEST_CASE("lights, emission and extensions of a glTF file", "[scene][gltf]") {
    const std::string folder = sceneFolder("scene");
    GltfBuilder b = triangleGltf();
    const std::string image = readBytes(folder + "/brushed.png");
    b.json["images"] = {{{"bufferView", b.addView(image)}, {"mimeType", "image/png"}}};
    b.json["textures"] = {{{"source", 0}}};
    b.json["materials"][0]["emissiveFactor"] = {1, 0.5, 0};
    b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    b.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
    b.json["materials"][0]["extensions"] = {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 0.25}}},
                                            {"KHR_materials_ior", {{"ior", 1.75}}},
                                            {"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}};
    b.json["nodes"].push_back({{"name", "lamp"}, {"translation", {1, 2, 3}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    b.json["scenes"][0]["nodes"].push_back(2);
    b.json["extensions"] = {{"KHR_lights_punctual",
                             {{"lights",
                               {{{"type", "spot"},
                                 {"intensity", 20},
                                 {"color", {1, 0.5, 0.25}},
                                 {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}}}}}};
    b.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_ior", "KHR_materials_emissive_strength"};
    Warnings warnings;
    const Scene scene = loadScene(writeTo(folder, "lit.gltf", b.gltf()), {}, warnings);
    CHECK(!scene.environment);
    const Object &body = scene.objects.at(0);
    CHECK(body.emission.value == Vec3(4, 2, 0));
    const Material &paint = scene.materials.at(body.materials.at(0));
    CHECK(paint.anisotropyStrength == 0.5F);
    CHECK(paint.rotation.value == 0.25F);
    CHECK(paint.ior == 1.75F);
    CHECK(paint.alphaX.channel == 1);
    CHECK(paint.metallic.channel == 2);
    CHECK(scene.textures.size() == 2); // one image as sRGB, once as numbers
    CHECK(lookup(scene.textures.at(paint.color.texture), {0.25F, 0.75F}).z == Approx(0.2158605).epsilon(1e-3));
    CHECK(lookup(scene.textures.at(paint.metallic.texture), {0.25F, 0.75F}).z == Approx(128 / 255.0));
    REQUIRE(scene.lights.size() == 1);
    const Light &lamp = scene.lights[0];
    const auto &spot = std::get<SpotLight>(lamp.shape);
    CHECK(close(spot.position, DVec3(1, -3, 2)));
    CHECK(close(spot.direction, DVec3(0, 1, 0)));
    CHECK(lamp.radiance == Vec3(20, 10, 5));
    CHECK(spot.outerAngle == Approx(0.5));
    CHECK(loadScene(folder + "/lit.gltf", {"mesh.0.lights=false"}, warnings).lights.empty());

    b.json["materials"][0]["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
    b.json["extensionsUsed"].push_back("KHR_materials_transmission");
    b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}, {"texCoord", 1}};
    warnings.lines.clear();
    const Scene glass = loadScene(writeTo(folder, "glass.gltf", b.gltf()), {}, warnings);
    const Material &clear = glass.materials.at(glass.objects.at(0).materials.at(0));
    CHECK(clear.type == BsdfType::MetallicRoughness);
    CHECK(clear.transmission.value == 1);
    CHECK(clear.thinWalled);
    CHECK(glass.textures.at(clear.color.texture).sampler.uvSet == 1);
    CHECK(glass.textures.at(clear.color.texture).texels.begin() != glass.textures.at(clear.metallic.texture).texels.begin());
}

TEST_CASE("real glTF files are scenes", "[scene][gltf]") {
    for (const char *name : {"anim/khronos/Fox.glb", "anim/khronos/CesiumMan.glb", "anim/khronos/AnisotropyRotationTest.glb",
                             "anim/khronos/SimpleSkin.gltf", "anim/khronos/AnimatedMorphCube.glb", "static/suzi.glb"}) {
        const auto path = asset(name);
        if (!path) continue;
        INFO(name);
        Warnings warnings;
        const Scene scene = loadScene(*path, {}, warnings);
        CHECK(!scene.objects.empty());
        std::set<std::string> names;
        for (const Object &object : scene.objects) {
            CHECK(names.insert(object.name).second);
            for (const Index material : object.materials) CHECK(material < scene.materials.size());
        }
        if (!scene.camera.rig) CHECK(fillOfView(scene) < 1);
        if (!scene.camera.rig) CHECK(fillOfView(scene) > 0.3);
    }
}
