/// Scene files beside the small files that they may name, and every writer by way of a scene.

#include "harness.h"
#include "harness_list.h"

#include "mesh_samples.h"

#include "taut/formats/write_mesh.h"
#include "taut/mesh/shapes.h"
#include "taut/plan/plan.h"
#include "taut/render/image_file.h"
#include "taut/scene/load_scene.h"
#include "taut/exporter.h"

#include <filesystem>

namespace taut::fuzz {

namespace {

constexpr std::size_t kMostFaces = 20000;

/// What scenes of the corpus refer to; written once.
void writeCompanions() {
    static const bool done = [] {
        scratchFile("quad.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n");
        writeObj(makeTorus(6, 5, 0.7F, 0.25F), scratchFolder() + "/torus.obj");
        scratchFile("mesh.ply", test::plyAsciiSample());
        scratchFile("mesh.stl", test::stlAsciiSample());
        scratchFile("box.glb", test::gltfSample().glb());
        for (int frame = 1; frame <= 3; ++frame)
            scratchFile("seq.00" + std::to_string(frame) + ".obj",
                        "v 0 0 0\nv 1 0 0\nv 0 1 " + std::to_string(frame) + "\nf 1 2 3\n");
        std::vector<std::string> caches = pc2Seeds();
        scratchFile("two.pc2", caches.front());
        scratchFile("map.png", pngSeeds().front());
        scratchFile("sky.hdr", environmentSeeds().front());
        scratchFile("show.ocio", ocioSeeds().front());
        return true;
    }();
    static_cast<void>(done);
}

/// Whether a scene is small enough to be evaluated many times a second.
bool isSmall(const Scene &scene) {
    std::size_t faces = 0;
    for (const Object &object : scene.objects) {
        if (object.subdivision.level > 2) return false;
        faces += object.mesh->faceCount() << (2 * static_cast<std::size_t>(object.subdivision.level));
    }
    return faces <= kMostFaces && scene.objects.size() <= 8;
}

constexpr const char *kPlain = R"([render]
width = 16
height = 9
spp = 1
frames = "1-2"
shutter = 0.5
motion_steps = 3
[camera]
position = [0, -3, 2]
look_at = [[1, [0, 0, 0]], [4, [0, 0, 1]]]
fov_deg = 40
[environment]
preset = "studio"
scale = 0.5
[[light]]
type = "quad"
corner = [-1, 1, 2]
radiance = 5
[material.brushed]
type = "conductor"
metal = "Al"
alpha = [0.1, 0.3]
rotation_deg = 30
[[mesh]]
file = "torus.obj"
material = "brushed"
subdivision = 1
crease_deg = 60
[[mesh.deform]]
type = "twist"
axis = "z"
angle_deg = [[1, 0], [10, 90]]
range = [-1, 1]
[[mesh.deform]]
type = "lattice"
points = [2, 3, 2]
offsets = [[0, 0, 0, 0.1, 0.2, 0.3], { at = [1, 1, 1], offset = [[1, [0, 0, 0]], [3, [0, 0, 0.5]]] }]
)";

constexpr const char *kMixed = R"(render = { width = 8, height = 8, frames = 3 }
camera = { gltf = "box.glb" }
environment = { file = "sky.hdr", rotation_deg = 40, camera_visible = false }
[material]
a = { type = "coated", color = { file = "map.png" }, alpha = 0.2, normal = { file = "map.png" }, detail = "moments" }
b = { type = "dielectric", ior = 1.3, alpha = 0.1, multiscatter = "walk" }
c = { preset = "rubber" }
d = { type = "metallic_roughness", metallic = 0.5, clearcoat = 1, sheen_color = 0.5, alpha_mode = "blend", opacity = 0.5, bump = { file = "map.png" } }
[[mesh]]
file = "box.glb"
rest = "frame 2"
[[mesh]]
file = "seq.###.obj"
material = "b"
[[mesh]]
file = "quad.obj"
material = { a = "a" }
subdivision = "auto"
deform = [{ type = "wave", axis = "x", direction = "z", amplitude = 0.1 }, { type = "bend", axis = "x", towards = "z", angle_deg = 20 }]
[[mesh]]
file = "mesh.ply"
material = "c"
gradient = "analytic"
lean = true
deform = [{ type = "stretch", factor = [2, 1, 1] }, { type = "shear", plane = "xy", amount = 0.5 }, { type = "taper", amount = 0.5 }]
[[light]]
type = "spot"
position = [0, 0, 3]
direction = [0, 0, -1]
intensity = [1, 2, 3]
[[light]]
type = "mesh"
mesh = "quad"
radiance = 2
)";

constexpr const char *kCache = R"([[mesh]]
file = "quad.obj"
cache = "two.pc2"
translate = [[1, [0, 0, 0]], [5, [1, 0, 0]]]
rotate_deg = [0, 0, 45]
scale = -1
up = "y"
follow = false
smooth = false
scheme = "catmull-clark"
boundary = "edge"
interpolation = "ds-dt"
[material.x]
type = "diffuse"
color = [1, 0.5, 0]
)";

constexpr const char *kSeen = R"([image]
exposure = -1.5
view = "aces"
display = "sRGB"
bits = [16, "half"]
compression = "dwaa:45"
[render]
width = 8
height = 8
[[light]]
type = "point"
position = [0, 0, 2]
intensity = 3
group = "key"
[material.shines]
type = "diffuse"
unlit = true
[[mesh]]
file = "quad.obj"
material = "shines"
group = "signs"
)";

} // namespace

void runToml(std::string_view bytes) {
    survive([&] {
        TomlValue root = parseToml(bytes, "fuzz.toml");
        applyOverride(root, "render.width=320");
    });
    survive([&] {
        TomlValue root;
        applyOverride(root, std::string(bytes));
    });
}

/// Reads and plans a scene.
void runScene(std::string_view bytes) {
    writeCompanions();
    survive([&] {
        Warnings warnings;
        const Scene scene = loadScene(scratchFile("fuzz.toml", bytes), {}, warnings);
        for (const std::string &line : warnings.lines) require(line.find('\n') == std::string::npos, "a warning is one line");
        checkColours(scene.image.view);
        if (!isSmall(scene)) return;
        static_cast<void>(planScene(scene, {}));
    });
}

/// The first byte chooses the writer.
void runWriters(std::string_view bytes) {
    static constexpr std::string_view kOutputs[] = {"####.ply", "####.csv", "####.npz", "####.glb", "####.gltf", "out.usda", "out.pc2", "out.mdd"};
    static constexpr std::string_view kConventions[] = {"matrix", "alpha", "blender", "blender_anisotropic", "openpbr", "materialx", "khr"};
    if (bytes.empty()) return;
    writeCompanions();
    const auto choice = static_cast<unsigned char>(bytes.front());
    survive([&] {
        Warnings warnings;
        Scene scene = loadScene(scratchFile("written.toml", bytes.substr(1)), {}, warnings);
        constexpr std::size_t kMostFrames = 3;
        if (!isSmall(scene)) return;
        scene.render.frames.resize(std::min(kMostFrames, scene.render.frames.size()));
        app::ExportRequest request;
        const std::string folder = scratchFolder() + "/written";
        request.outputs = {folder + '/' + std::string(kOutputs[choice % std::size(kOutputs)])};
        request.convention = kConventions[choice / std::size(kOutputs) % std::size(kConventions)];
        request.positions = choice % 3 == 0 ? "rest" : "deformed";
        request.ascii = choice % 2 == 0;
        const nlohmann::json report = exportFiles(scene, request, warnings);
        for (const auto &file : report["files"]) { // what is written can be read
            const std::string path = file.get<std::string>();
            if (isMeshPath(path)) static_cast<void>(readMesh(path, warnings));
            if (isGltfPath(path)) static_cast<void>(readGltf(path, warnings));
        }
        writeObj(*scene.objects.front().mesh, folder + "/mesh.obj");
        static_cast<void>(readMesh(folder + "/mesh.obj", warnings));
        std::filesystem::remove_all(folder);
    });
}

std::vector<std::string> tomlSeeds() {
    return {kPlain, kMixed, "a.b.c = 1\n[x.y]\n[[z]]\n'q' = \"\"\"\nl\n\"\"\"\nd = 1979-05-27T07:32:00Z\nh = [0xff, 1e5, inf]\n"};
}
std::vector<std::string> sceneSeeds() {
    return {kPlain, kMixed, kCache, kSeen};
}
std::vector<std::string> writerSeeds() {
    std::vector<std::string> seeds;
    for (char choice = 0; choice < 8; ++choice)
        for (const std::string &scene : sceneSeeds()) seeds.push_back(static_cast<char>(choice * 9 % 56) + scene);
    return seeds;
}

} // namespace taut::fuzz
