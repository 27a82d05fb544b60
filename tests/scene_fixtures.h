#pragma once
/// Small scenes as files: meshes, images and TOML written to the output folder, and what an InputError says of them.

#include "assets.h"
#include "mesh_samples.h"
#include "output_folder.h"

#include "taut/base/file_bytes.h"
#include "taut/images/image_codec.h"
#include "taut/scene/load_scene.h"
#include "taut/scene/object_motion.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace taut::test {

inline std::string writeTo(const std::string &folder, const std::string &name, const std::string &bytes) {
    const std::string path = folder + "/" + name;
    std::ofstream(path, std::ios::binary | std::ios::trunc).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
}

/// One quad in the plane z = `height`, corners (+-1, +-1); two material slots where `twoMaterials`.
inline std::string quadObj(float height = 0, bool twoMaterials = false) {
    const std::string z = std::to_string(height);
    const std::string corners = "v -1 -1 " + z + "\nv 1 -1 " + z + "\nv 1 1 " + z + "\nv -1 1 " + z + "\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    if (twoMaterials) return corners + "usemtl Body\nf 1/1 2/2 3/3\nusemtl Trim\nf 1/1 3/3 4/4\n";
    return corners + "f 1/1 2/2 3/3 4/4\n";
}

/// Writes an image of floats in [0, 1] (or any, for float formats); the name's ending chooses the format.
inline std::string writeImage(const std::string &folder, const std::string &name, int width, int height, int channels,
                              const std::vector<float> &texels, SampleType type = SampleType::UInt8) {
    ImagePart part;
    part.width = part.fullWidth = width;
    part.height = part.fullHeight = height;
    const std::vector<std::string> names{"R", "G", "B", "A"};
    part.channels = channels < 3 ? std::vector<std::string>{"Y", "A"} : names;
    part.channels.resize(static_cast<std::size_t>(channels));
    std::string format = lowerExtension(name);
    for (const auto &[extension, known] :
         {std::pair("exr", "openexr"), std::pair("jpg", "jpeg"), std::pair("tif", "tiff"), std::pair("tga", "targa")})
        if (format == extension) format = known;
    const std::vector<unsigned char> bytes = imageCodec().encode(format, {part, type, texels.data()});
    return writeTo(folder, name, {bytes.begin(), bytes.end()});
}

/// One triangle in the glTF's xy plane under the node "body", a camera, a lamp and an animation of the body.
inline GltfBuilder triangleGltf() {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int times = b.addFloats("SCALAR", {0, 1});
    const int places = b.addFloats("VEC3", {0, 0, 0, 0, 10, 0});
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", 0}}}}}};
    b.json["materials"] = {
        {{"name", "paint"},
         {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0.125, 1}}, {"metallicFactor", 0.75}, {"roughnessFactor", 0.5}}}}};
    b.json["nodes"] = {{{"name", "body"}, {"mesh", 0}}, {{"name", "eye"}, {"camera", 0}, {"translation", {0, 1, 5}}}};
    b.json["scenes"] = {{{"nodes", {0, 1}}}};
    b.json["scene"] = 0;
    b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.1}}}}};
    b.json["animations"] = {{{"name", "rise"},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                             {"samplers", {{{"input", times}, {"output", places}}}}}};
    return b;
}

/// A folder with every file that the examples name.
inline std::string sceneFolder(const std::string &name) {
    const std::string folder = outputFolder(name);
    writeTo(folder, "panel.obj", quadObj());
    writeTo(folder, "parts.obj", quadObj(0, true));
    writeTo(folder, "triangles.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    for (const int frame : {1, 2, 5}) writeTo(folder, "cloth.000" + std::to_string(frame) + ".obj", quadObj(static_cast<float>(frame)));
    writeTo(folder, "figure.glb", triangleGltf().glb());
    writeImage(folder, "brushed.png", 2, 2, 3, {0, 0.25F, 0.5F, 1, 1, 1, 0.5F, 0.5F, 0.5F, 0, 0, 0});
    writeImage(folder, "studio.exr", 4, 2, 3, std::vector<float>(24, 0.5F), SampleType::Float);
    return folder;
}

inline Scene loadFile(const std::string &path, const std::vector<std::string> &overrides = {}) {
    Warnings warnings;
    return loadScene(path, overrides, warnings);
}

inline Scene loadText(const std::string &folder, const std::string &toml, const std::vector<std::string> &overrides = {}) {
    Warnings warnings;
    return loadScene(writeTo(folder, "scene.toml", toml), overrides, warnings);
}

/// What the InputError of `action` says; empty where it does not throw. Any other exception fails the test.
inline std::string errorOf(const std::function<void()> &action) {
    try {
        action();
    } catch (const InputError &error) {
        const std::string line = error.what();
        CHECK(!line.empty());
        CHECK(line.find('\n') == std::string::npos);
        return line;
    } catch (const std::exception &error) {
        FAIL("not an InputError: " << error.what());
    }
    return "";
}

inline std::string errorOfText(const std::string &folder, const std::string &toml, const std::vector<std::string> &overrides = {}) {
    return errorOf([&] { loadText(folder, toml, overrides); });
}

/// True where `line` begins (after the folder) with scene.toml:LINE:COLUMN: and holds every part.
inline bool says(const std::string &line, const std::string &place, const std::vector<std::string> &parts) {
    if (line.find(place) == std::string::npos) return false;
    return std::all_of(parts.begin(), parts.end(), [&](const std::string &part) { return line.find(part) != std::string::npos; });
}

inline bool close(const DVec3 &a, const DVec3 &b, double tolerance = 1e-6) {
    return glm::length(a - b) <= tolerance;
}

inline DVec3 transformed(const DMat4 &m, const DVec3 &p) {
    return DVec3(m * glm::dvec4(p, 1));
}

inline std::vector<Vec3> worldPositions(const Scene &scene, const Object &object, double frame) {
    ObjectMotion motion;
    motionAtFrame(object, frame, scene.render.fps, DMat4(1), motion);
    std::vector<Vec3> positions;
    evaluatePositions(motion.state, object.mesh->skin, positions);
    return positions;
}

/// The largest |tangent of the view angle| / (that of the image's edge) over all points; above 1: out of the picture.
inline double fillOfView(const Scene &scene) {
    const double frame = scene.render.frames.front();
    const CameraState camera = cameraAtFrame(scene.camera, frame, scene.render.fps);
    const DMat4 cameraFromWorld = glm::inverse(camera.worldFromCamera);
    const double tanY = std::tan(camera.fovY / 2);
    const double tanX = tanY * scene.render.width / scene.render.height;
    double fill = 0;
    for (const Object &object : scene.objects)
        for (const Vec3 &p : worldPositions(scene, object, frame)) {
            const DVec3 c = transformed(cameraFromWorld, DVec3(p));
            fill = std::max(fill, c.z < 0 ? std::max(std::fabs(c.x) / (-c.z * tanX), std::fabs(c.y) / (-c.z * tanY)) : 1e9);
        }
    return fill;
}

} // namespace taut::test
