/// The reader of glTF, and a file as a scene: its objects at a frame, its images.

#include "harness.h"
#include "harness_list.h"

#include "mesh_samples.h"

#include "taut/scene/ground.h"
#include "taut/scene/load_scene.h"
#include "taut/scene/object_surface.h"

namespace taut::fuzz {

namespace {

void readGltfFile(const std::string &name, std::string_view bytes) {
    const std::string path = scratchFile(name, bytes);
    survive([&] {
        Warnings warnings;
        for (const Mesh &mesh : readGltf(path, warnings).meshes) test::requireValid(mesh);
    });
    survive([&] {
        Warnings warnings;
        Scene scene = loadScene(path, {"environment.radiance=1"}, warnings); // the studio takes longer than the file
        constexpr std::size_t kMostObjects = 8;
        for (std::size_t i = 0; i < std::min(kMostObjects, scene.objects.size()); ++i) {
            ObjectSurface surface;
            prepareObjectSurface(scene.objects[i], scene.render.fps, surface);
            double ignored = 0;
            surfaceAtFrame(surface, 7, scene.render.fps, DMat4(1), ignored, ignored);
        }
        static_cast<void>(cameraAtFrame(scene.camera, 7, scene.render.fps));
        scene.render.frames.resize(std::min<std::size_t>(2, scene.render.frames.size()));
        if (const std::optional<Ground> ground = groundOf(scene)) standOn(*ground, scene);
    });
}

/// What the sample lacks: instances, variants, layers, texture transforms, strips, an orthographic camera.
test::GltfBuilder richSample() {
    test::GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5F});
    const int uvs = b.addFloats("VEC2", {0, 0, 1, 0, 0, 1, 1, 1});
    const int colors = b.add<std::uint8_t>("VEC4", 5121, {255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 255, 9, 9, 9, 9}, true);
    const int places = b.addFloats("VEC3", {0, 0, 0, 2, 0, 0});
    b.json["meshes"] = {{{"primitives",
                          {{{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}, {"TEXCOORD_1", uvs}, {"COLOR_0", colors}}},
                            {"mode", 5},
                            {"material", 0},
                            {"extensions",
                             {{"KHR_materials_variants", {{"mappings", {{{"material", 1}, {"variants", {0}}}}}}}}}},
                           {{"attributes", {{"POSITION", positions}}}, {"mode", 6}, {"material", 1}}}}}};
    b.json["nodes"] = {{{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}},
                       {{"camera", 0}, {"translation", {0, 0, 5}}},
                       {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
    b.json["scenes"] = {{{"nodes", {0, 1, 2}}}};
    b.json["cameras"] = {{{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}}};
    const nlohmann::json map = {{"index", 0}, {"texCoord", 1}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {2, 2}}}}}}};
    b.json["materials"] = {
        {{"name", "layers"},
         {"alphaMode", "MASK"},
         {"normalTexture", map},
         {"extensions",
          {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", map}}},
           {"KHR_materials_sheen", {{"sheenColorFactor", {1, 0, 0}}}},
           {"KHR_materials_iridescence", {{"iridescenceFactor", 1}, {"iridescenceThicknessTexture", map}}},
           {"KHR_materials_specular", {{"specularFactor", 0.5}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 2}}}}}},
        {{"name", "flat"}, {"alphaMode", "BLEND"}, {"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}}};
    b.json["textures"] = {{{"source", 0}}};
    b.json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg=="}}};
    b.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}}, {{"type", "directional"}}}}}},
                            {"KHR_materials_variants", {{"variants", {{{"name", "red"}}}}}}};
    b.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_variants", "EXT_mesh_gpu_instancing", "KHR_materials_unlit"};
    return b;
}

} // namespace

void runGltf(std::string_view bytes) {
    readGltfFile("fuzz.gltf", bytes);
}
void runGlb(std::string_view bytes) {
    readGltfFile("fuzz.glb", bytes);
}

std::vector<std::string> gltfSeeds() {
    return {test::gltfSample().gltf(), richSample().gltf()};
}
std::vector<std::string> glbSeeds() {
    return {test::gltfSample().glb(), richSample().glb()};
}

} // namespace taut::fuzz
