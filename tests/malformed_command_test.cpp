/// Broken input handed to the command: one line that says what and where, exit code 2, no file touched, whatever is broken:
/// the scene, a mesh, a glTF file or an image. The readers' own tests look at each mistake more closely.

#include "command.h"
#include "mesh_samples.h"

#include "taut/render/image_file.h"

#include <atomic>
#include <random>
#include <thread>

using namespace taut;
using namespace taut::test;

namespace {

constexpr const char *kBefore = "the image of yesterday";

/// A folder of files, the one that is handed to the command, and what the error must name.
struct Case {
    std::vector<std::pair<std::string, std::string>> files; ///< name, bytes
    std::string says;                                       ///< empty: it may also be valid
    Arguments more = {};
    std::string scene = "scene.toml";
};

const std::string kRest = "[render]\nwidth = 6\nheight = 4\nspp = 1\n[camera]\nposition = [0, -4, 3]\n";
const std::string kLit = "[environment]\nradiance = 1\n";
const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

/// A scene of this text on top of a valid rest, with a mesh beside it.
Case badScene(const std::string &text, const std::string &says) {
    return {{{"scene.toml", text}, {"mesh.obj", kTriangle}}, says};
}
/// A valid scene with one mesh file.
Case withMesh(const std::string &name, const std::string &bytes, const std::string &says) {
    return {{{"scene.toml", kRest + kLit + "[[mesh]]\nfile = \"" + name + "\"\n"}, {name, bytes}}, says};
}
Case withEnvironment(const std::string &name, const std::string &bytes, const std::string &says) {
    return {{{"scene.toml", kRest + "[environment]\nfile = \"" + name + "\"\n[[mesh]]\nfile = \"mesh.obj\"\n"},
             {"mesh.obj", kTriangle},
             {name, bytes}},
            says};
}
Case withTexture(const std::string &name, const std::string &bytes, const std::string &says) {
    return {{{"scene.toml",
              kRest + kLit + "[material.m]\ncolor = { file = \"" + name + "\" }\n[[mesh]]\nfile = \"mesh.obj\"\nmaterial = \"m\"\n"},
             {"mesh.obj", kTriangle},
             {name, bytes}},
            says};
}
/// The file itself as the scene.
Case bare(const std::string &name, const std::string &bytes, const std::string &says) {
    return {{{name, bytes}}, says, {"-D", "render.width=6", "-D", "render.height=4", "-D", "render.spp=1"}, name};
}

std::string caseFolder(const std::string &group, std::size_t i) {
    return outputFolder("malformed_" + group) + "/" + std::to_string(i);
}

std::vector<std::string> namesOf(const Case &c) {
    std::vector<std::string> names{"out.exr"};
    for (const auto &[name, bytes] : c.files) names.push_back(name);
    std::sort(names.begin(), names.end());
    return names;
}

CommandResult run(const Case &c, const std::string &folder) {
    Arguments arguments{"render", c.scene, "-o", "out.exr", "--progress", "json", "-t", "1"};
    arguments.insert(arguments.end(), c.more.begin(), c.more.end());
    return runTaut(arguments, folder, 60);
}

/// Runs all cases, two at a time: most of a run is the start of the process.
std::vector<CommandResult> runAll(const std::string &group, const std::vector<Case> &cases) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
        freshFolder("malformed_" + group + "/" + std::to_string(i));
        for (const auto &[name, bytes] : cases[i].files) writeBytes(caseFolder(group, i) + "/" + name, bytes);
        writeBytes(caseFolder(group, i) + "/out.exr", kBefore);
    }
    std::vector<CommandResult> results(cases.size());
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t i = 0; (i = next++) < cases.size();) results[i] = run(cases[i], caseFolder(group, i));
    };
    std::thread other(work);
    work();
    other.join();
    return results;
}

/// Standard error without the frame events of a render that went through.
CommandResult withoutEvents(CommandResult result) {
    std::string lines;
    for (const std::string &line : linesOf(result.err))
        if (line.rfind("{\"", 0) != 0) lines += line + "\n";
    result.err = lines;
    return result;
}

void checkAll(const std::string &group, const std::vector<Case> &cases) {
    const std::vector<CommandResult> results = runAll(group, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const std::string folder = caseFolder(group, i);
        const CommandResult result = withoutEvents(results[i]);
        const bool mayBeValid = cases[i].says.empty();
        INFO(folder << ": exit code " << result.exitCode << ": " << result.err.substr(0, 2000));
        CHECK(namesIn(folder) == namesOf(cases[i]));
        if (mayBeValid && result.exitCode == 0) {
            for (const std::string &line : linesOf(result.err)) CHECK(line.rfind("taut: warning: ", 0) == 0);
            CHECK(readImage(folder + "/out.exr").width == 6);
            continue;
        }
        CHECK(result.exitCode == 2);
        CHECK(result.out.empty());
        CHECK(errorLine(result).rfind("taut: error: ", 0) == 0);
        CHECK(errorLine(result).size() < 1000);
        CHECK(errorLine(result).find(cases[i].says) != std::string::npos);
        CHECK(readBytes(folder + "/out.exr") == kBefore);
    }
}

/// The file cut at random places, and with a few of its bits turned. One seed for all.
std::vector<std::string> damaged(const std::string &bytes, int cuts, int flips) {
    std::mt19937 random(static_cast<unsigned>(bytes.size()));
    const auto below = [&](std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); };
    std::vector<std::string> all;
    for (int i = 0; i < cuts; ++i) all.push_back(bytes.substr(0, below(bytes.size())));
    for (int i = 0; i < flips; ++i) {
        std::string turned = bytes;
        for (int k = 0; k < 3; ++k) turned[below(bytes.size())] ^= static_cast<char>(1 << below(8));
        all.push_back(turned);
    }
    return all;
}

/// A skinned, animated square with a morph; nothing in it that is not read.
GltfBuilder smallGltf() {
    GltfBuilder builder = gltfSample();
    for (const char *key : {"images", "textures", "samplers", "materials"}) builder.json.erase(key);
    builder.json["meshes"][0]["primitives"][0].erase("material");
    return builder;
}

/// Bytes of a small image in the format of the extension.
std::string imageBytes(const std::string &extension) {
    const std::string path = freshFolder("malformed_images") + "/a." + extension;
    Image image;
    image.window = {0, 0, 9, 5};
    image.width = 9;
    image.height = 5;
    image.channels = {"R", "G", "B"};
    for (int i = 0; i < 9 * 5 * 3; ++i) image.values.push_back(static_cast<float>(i % 17) / 17);
    writeImage(path, image, {});
    std::string bytes = readBytes(path);
    fs::remove_all(fs::path(path).parent_path());
    return bytes;
}

/// Radiance HDR, rows without run lengths.
std::string hdrBytes() {
    std::string out = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 5\n";
    for (int i = 0; i < 15; ++i) out += std::string("\x40\x80\x60\x81", 4);
    return out;
}

} // namespace

TEST_CASE("malformed input: scene files", "[malformed_command]") {
    const std::string mesh = "[[mesh]]\nfile = \"mesh.obj\"\n";
    std::string deep = kRest + "[x]\ny = ";
    deep.append(20000, '[');
    checkAll("scene", {
                          badScene("render", "scene.toml:1:"),
                          badScene("[render\nwidth = 6\n", "scene.toml:1:"),
                          badScene("[rendr]\n", "did you mean 'render'?"),
                          badScene("[render]\nwidth = 6\nwidth = 7\n", "scene.toml:3:"),
                          badScene("[render]\nwidth = \"wide\"\n", "scene.toml:2:9: found 'wide'"),
                          badScene("[render]\nwidth = 0\n", "scene.toml:2:9: found 0"),
                          badScene("[render]\nwidth = 99999999999999999999\n", "scene.toml:2:"),
                          badScene("[render]\nspp = -1\n", "scene.toml:2:7: found -1"),
                          badScene("[render]\nframes = \"9-1-2\"\n", "9-1-2"),
                          badScene("[render]\nframes = \"1-2000000000\"\n", "1-2000000000"),
                          badScene("[render]\nfps = nan\n", "scene.toml:2:7:"),
                          badScene("render = 5\n", "scene.toml:1:10: found 5"),
                          badScene("[camera]\nposition = [0, 0]\n", "scene.toml:2:12: found an array of 2"),
                          badScene("[camera]\nposition = [1, 1, 1]\nlook_at = [1, 1, 1]\n", "position equal to look_at"),
                          badScene("[camera]\nup = [0, 0, 0]\n", "up of no length"),
                          badScene("[camera]\nfov_deg = [[1, 40], [1, 50]]\n", "a frame after 1"),
                          badScene("[environment]\nradiance = -1\n", "scene.toml:2:12: found -1"),
                          badScene("[environment]\nradiance = inf\n", "scene.toml:2:12:"),
                          badScene("[environment]\nfile = \"gone.exr\"\n", "gone.exr"),
                          badScene("[environment]\nfile = \".\"\n", "is not a file"),
                          badScene("[environment]\nfile = \"mesh.obj\"\n", "mesh.obj"),
                          badScene("[[light]]\ntype = \"quda\"\n", "did you mean 'quad'?"),
                          badScene("[[light]]\ntype = \"sphere\"\ncorner = [0, 0, 0]\n", "'corner'"),
                          badScene("[[light]]\nu = [1, 0, 0]\nv = [2, 0, 0]\n", "along one line"),
                          badScene("[[light]]\ntype = \"mesh\"\nmesh = \"lamp\"\n", "'lamp'"),
                          badScene("[material.m]\ntype = \"metal\"\n", "'metal'"),
                          badScene("[material.m]\ntype = \"conductor\"\nmetal = \"Cq\"\n", "did you mean 'Cu'?"),
                          badScene("[material.m]\ntype = \"conductor\"\nalpha = 0\n", "scene.toml:3:9: found 0"),
                          badScene("[material.m]\ncolor = { file = \"mesh.obj\", scael = 2 }\n", "did you mean 'scale'?"),
                          badScene("[[mesh]]\nfollow = true\n", "no key 'file'"),
                          badScene("[[mesh]]\nfile = \"mesh.obj\\u0000\"\n", "scene.toml:2:8:"),
                          badScene("[[mesh]]\nfile = \"scene.toml\"\n", "'scene.toml'"),
                          badScene("[[mesh]]\nfile = \"mesh.####.obj\"\n", "mesh.####.obj"),
                          badScene(mesh + "material = \"m\"\n", "'m'"),
                          badScene(mesh + "rest = \"frame x\"\n", "'frame x'"),
                          badScene(mesh + "subdivision = 9\n", "scene.toml:3:15: found 9"),
                          badScene(mesh + "[[mesh.deform]]\ntype = \"bendd\"\n", "did you mean 'bend'?"),
                          badScene(mesh + "[[mesh.deform]]\ntype = \"bend\"\naxis = \"x\"\ntowards = \"x\"\n", "two different axes"),
                          badScene(mesh + "[[mesh.deform]]\ntype = \"lattice\"\npoints = [2, 1, 2]\n", "scene.toml:5:"),
                          badScene("[render]\nwidth = 6 # \xff\xfe\n", "scene.toml:2:"),
                          badScene(std::string("[render]\0\nwidth = 6\n", 20), "scene.toml:1:"),
                          badScene(deep, "scene.toml:"),
                          {{{"scene.txt", kRest}}, "scene.txt", {}, "scene.txt"},
                          {{{"mesh.obj", kTriangle}}, "scene.toml", {}, "scene.toml"},
                          bare("mesh.obj", "v 0 0 0\nf 1 2 3\n", "mesh.obj:2:"),
                          bare("scene.glb", "glTF", "scene.glb"),
                      });
}

TEST_CASE("malformed input: mesh files", "[malformed_command]") {
    checkAll("mesh",
             {
                 withMesh("a.obj", "v 0 0\nf 1 1 1\n", "a.obj:1:6:"),
                 withMesh("a.obj", kTriangle + "f 1 2 99\n", "a.obj:8:7:"),
                 withMesh("a.obj", "v nan 0 0\n", "a.obj:1:3:"),
                 withMesh("a.obj", "", "a.obj"),
                 withMesh("a.ply", "plx\n", "a.ply:1:1:"),
                 withMesh("a.ply", replaced(plyAsciiSample(), "element vertex 5", "element vertex 4000000000"), "a.ply:5:16:"),
                 withMesh("a.ply", replaced(plyBinarySample(false), "element face 3", "element face 2000000000"), "a.ply:15:14:"),
                 withMesh("a.ply", plyBinarySample(true).substr(0, 420), "a.ply"),
                 withMesh("a.off", "OFF\n5 2\n", "a.off"),
                 withMesh("a.off", replaced(offSample(), "3 3 2 4", "3 3 2 5"), "a.off"),
                 withMesh("a.stl", stlBinarySample().substr(0, 100), "a.stl"),
                 withMesh("a.stl", replaced(stlAsciiSample(), "endloop", "endlop"), "a.stl"),
                 withMesh("a.glb", smallGltf().glb().substr(0, 60), "a.glb"),
                 withMesh("a.glb", GltfBuilder::container("{\"asset\": {\"version\": \"3.0\"}}", ""), "a.glb"),
                 withMesh("a.gltf", "{\"asset\": {", "a.gltf"),
                 withMesh("a.gltf", "[]", "a.gltf"),
                 withMesh("a.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 4}], "scenes": [{"nodes": [0]}]})", "a.gltf"),
                 withMesh("a.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]})", "a.gltf"),
                 withMesh("a.gltf", R"({"asset": {"version": "2.0"}})", "a.gltf"),
                 withMesh("a.gltf", replaced(smallGltf().gltf(), "\"count\": 4", "\"count\": 4000000000"), "a.gltf"),
                 withMesh("a.gltf", replaced(smallGltf().gltf(), "base64,", "base64,#"), "a.gltf"),
             });
}

TEST_CASE("malformed input: images", "[malformed_command]") {
    const std::string png = imageBytes("png");
    const std::string exr = imageBytes("exr");
    const std::string hdr = hdrBytes();
    checkAll("image", {
                          withTexture("a.png", "", "a.png"),
                          withTexture("a.png", "no image at all", "a.png"),
                          withTexture("a.png", png.substr(0, 40), "a.png"),
                          withTexture("a.png", exr, ""), // told apart by its bytes, not by its name
                          withTexture("a.jpg", "\xff\xd8\xff\xe0", "a.jpg"),
                          withTexture("a.exr", exr.substr(0, exr.size() / 2), "a.exr"),
                          withTexture("a.tif", std::string("II*\0\x08\0\0\0\xff\xff", 10), "a.tif"),
                          withEnvironment("a.exr", exr.substr(0, 100), "a.exr"),
                          withEnvironment("a.exr", exr, ""),
                          withEnvironment("a.hdr", hdr, ""),
                          withEnvironment("a.hdr", hdr.substr(0, hdr.size() - 9), "a.hdr"),
                          withEnvironment("a.hdr", replaced(hdr, "+X 5", "+X 50000000"), "a.hdr"),
                          withEnvironment("a.hdr", replaced(hdr, "-Y 3", "-Y -3"), "a.hdr"),
                      });
}

TEST_CASE("malformed input: files cut short or with bits turned", "[malformed_command]") {
    const auto obj = [](const std::string &bytes) { return withMesh("a.obj", bytes, ""); };
    const auto ply = [](const std::string &bytes) { return withMesh("a.ply", bytes, ""); };
    const auto off = [](const std::string &bytes) { return withMesh("a.off", bytes, ""); };
    const auto stl = [](const std::string &bytes) { return withMesh("a.stl", bytes, ""); };
    const auto glb = [](const std::string &bytes) { return withMesh("a.glb", bytes, ""); };
    const auto gltf = [](const std::string &bytes) { return withMesh("a.gltf", bytes, ""); };
    const auto toml = [](const std::string &bytes) {
        Case c = badScene(bytes, "");
        c.more = {"-D", "render.width=6", "-D", "render.height=4", "-D", "render.spp=1", "-D", "render.max_events=2", "--frames", "1"};
        return c;
    };
    const auto texture = [](const std::string &bytes) { return withTexture("a.png", bytes, ""); };
    const auto environment = [](const std::string &bytes) { return withEnvironment("a.exr", bytes, ""); };
    const auto radianceHdr = [](const std::string &bytes) { return withEnvironment("a.hdr", bytes, ""); };
    std::vector<Case> cases;
    const auto add = [&](const auto &make, const std::string &bytes, int cuts, int flips) {
        for (const std::string &broken : damaged(bytes, cuts, flips)) cases.push_back(make(broken));
    };
    add(obj, objSample(), 1, 3);
    add(ply, plyAsciiSample(), 1, 2);
    add(ply, plyBinarySample(false), 1, 3);
    add(off, offSample(), 1, 2);
    add(stl, stlAsciiSample(), 1, 2);
    add(stl, stlBinarySample(), 1, 3);
    add(glb, smallGltf().glb(), 1, 4);
    add(gltf, smallGltf().gltf(), 1, 3);
    add(toml,
        kRest + kLit + "[material.m]\nalpha = [0.1, 0.2]\ntype = \"conductor\"\n[[mesh]]\nfile = \"mesh.obj\"\nmaterial = \"m\"\n" +
            "[[mesh.deform]]\ntype = \"shear\"\namount = [[1, 0.0], [9, 1.0]]\n",
        1, 5);
    add(texture, imageBytes("png"), 1, 3);
    add(environment, imageBytes("exr"), 1, 3);
    add(radianceHdr, hdrBytes(), 1, 2);
    checkAll("damage", cases);
}
