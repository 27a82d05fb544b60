#include "scene_fixtures.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

/// A scene file, where its error is (line:column) and what the error says.
struct Malformed {
    const char *toml;
    const char *place;
    std::vector<std::string> parts;
};

const std::string kMesh = "[[mesh]]\nfile = \"panel.obj\"\n"; // two lines in front

/// Files of which the first error is in the head of the file.
const std::vector<Malformed> kSections{
    {"[render]\nwidht = 3\n", "2:1", {"'widht'", "one of width", "did you mean 'width'?"}},
    {"[rander]\nwidth = 3\n", "1:2", {"'rander'", "did you mean 'render'?"}},
    {"[render]\nwidth = 0\n", "2:9", {"found 0", "an integer in [1, 32768]"}},
    {"[render]\nwidth = 3.5\n", "2:9", {"found 3.5", "an integer"}},
    {"[render]\nwidth = \"wide\"\n", "2:9", {"found 'wide'", "an integer"}},
    {"[render]\nspp = -1\n", "2:7", {"found -1"}},
    {"[render]\nfps = 0\n", "2:7", {"found 0", "a number in (0,"}},
    {"[render]\nfps = nan\n", "2:7", {"nan"}},
    {"[render]\nseed = 4294967296\n", "2:8", {"found 4294967296"}},
    {"[render]\nfixed_seed = 1\n", "2:14", {"found 1", "true or false"}},
    {"[render]\nfilter = \"gauss\"\n", "2:10", {"'gauss'", "blackman-harris, box"}},
    {"[render]\nframes = \"1-\"\n", "2:10", {"'1-'", "a frame set"}},
    {"[render]\nframes = \"1-2000000000\"\n", "2:10", {"million"}},
    {"[render]\nframes = [1, 2]\n", "2:10", {"an array of 2 items", "a string"}},
    {"render = 3\n", "1:10", {"found 3", "a table [render]"}},
    {"[render\nwidth = 3\n", "1:8", {"not TOML"}},
    {"[render]\nwidth = 3\nwidth = 4\n", "3:", {"not TOML"}},
    {"[render]\nwidth = \n", "2:", {"not TOML"}},
    {"[render]\nspp = 1979-05-27\n", "2:7", {"a date or time"}},
    {"[camera]\nposition = [1, 2]\n", "2:12", {"an array of 2 items", "three numbers"}},
    {"[camera]\nposition = [[1, [0, 0, 1]], [1, [0, 0, 2]]]\n", "2:30", {"frame 1", "a frame after 1"}},
    {"[camera]\nposition = [[1, 2]]\n", "2:17", {"found 2", "three numbers"}},
    {"[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 0]\n", "1:1", {"position equal to look_at at frame 1"}},
    {"[camera]\nposition = [0, 0, 1]\nup = [0, 0, 0]\n", "1:1", {"up of no length"}},
    {"[camera]\nfov_deg = 180\n", "2:11", {"found 180", "a number in [0.01, 179]"}},
    {"[camera]\ngltf = \"figure.glb\"\nup = [0, 0, 1]\n", "3:1", {"'up' beside 'gltf'"}},
    {"[camera]\ngltf = \"figure.glb\"\nnode = \"eyes\"\n", "3:8", {"'eyes'", "did you mean 'eye'?"}},
    {"[camera]\ngltf = \"none.glb\"\n", "2:8", {"'none.glb'", "/none.glb", "an existing file"}},
    {"[camera]\nnode = \"eye\"\n", "2:1", {"'node'", "one of"}},
    {"[environment]\nfile = \"no.exr\"\n", "2:8", {"'no.exr'", "/no.exr"}},
    {"[environment]\nfile = \".\"\n", "2:8", {"is not a file"}},
    {"[environment]\nradiance = [1, -1, 1]\n", "2:16", {"found -1", "at least 0"}},
    {"[environment]\nradiance = 1\npreset = \"studio\"\n", "3:1", {"'preset' beside 'radiance'"}},
    {"[environment]\npreset = \"stadio\"\n", "2:10", {"'stadio'", "did you mean 'studio'?"}},
    {"[environment]\nrotation = 3\n", "2:1", {"'rotation'", "did you mean 'rotation_deg'?"}},
    {"[light]\ntype = \"quad\"\n", "1:1", {"found a table", "[[light]]"}},
    {"[[light]]\ntype = \"squad\"\n", "2:8", {"'squad'", "did you mean 'quad'?"}},
    {"[[light]]\ntype = \"sphere\"\ncorner = [0, 0, 0]\n", "3:1", {"'corner'", "centre"}},
    {"[[light]]\ntype = \"sphere\"\nradius = 0\n", "3:10", {"found 0", "a number above 0"}},
    {"[[light]]\nu = [1, 0, 0]\nv = [2, 0, 0]\n", "1:1", {"u and v along one line"}},
    {"[[light]]\ntype = \"directional\"\ndirection = [0, 0, 0]\n", "3:13", {"no length"}},
    {"[[light]]\ntype = \"spot\"\ninner_deg = 50\nouter_deg = 40\n", "1:1", {"inner_deg not below outer_deg"}},
    {"[[light]]\ntype = \"mesh\"\nmesh = \"panel\"\n", "3:8", {"'panel'", "there is no [[mesh]]"}},
    {"[[light]]\ntype = \"mesh\"\n", "1:1", {"no key 'mesh'"}},
};

const std::vector<Malformed> kMaterials{
    {"[material]\nbrushed = 3\n", "2:11", {"found 3", "a table [material.brushed]"}},
    {"[material.a]\ntype = \"conducter\"\n", "2:8", {"'conducter'", "did you mean 'conductor'?"}},
    {"[material.a]\ntype = \"conductor\"\nmetal = \"Av\"\n", "3:9", {"'Av'", "Al, Ag, Au", "did you mean"}},
    {"[material.a]\ntype = \"conductor\"\nalpha = 12\n", "3:9", {"found 12, expected a number in [1e-4, 10]"}},
    {"[material.a]\ntype = \"conductor\"\nalpha = [0.1, 1e-5]\n", "3:15", {"found 1e-5, expected a number in [1e-4, 10]"}},
    {"[material.a]\ntype = \"conductor\"\nalpha = [0.1]\n", "3:9", {"an array of 1 item"}},
    {"[material.a]\ntype = \"conductor\"\nmetal = \"Al\"\nf0 = 1\n", "4:1", {"'f0' beside 'metal'"}},
    {"[material.a]\ntype = \"conductor\"\nf0 = -0.5\n", "3:6", {"found -0.5", "at least 0"}},
    {"[material.a]\ntype = \"conductor\"\ncolor = 1\n", "3:1", {"'color'"}},
    {"[material.a]\ntype = \"diffuse\"\nalpha = 0.1\n", "3:1", {"'alpha'", "one of preset, type, color, normal, bump, height"}},
    {"[material.a]\ntype = \"conductor\"\nroughness = 0.1\n", "3:1", {"'roughness'", "one of"}},
    {"[material.a]\ntype = \"coated\"\nior = 0\n", "3:7", {"found 0"}},
    {"[material.a]\ntype = \"coated\"\npoisson = 0.6\n", "3:11", {"found 0.6", "[-1, 0.5]"}},
    {"[material.a]\ntype = \"coated\"\nmasking = \"none\"\n", "3:11", {"'none'", "correlated, separable"}},
    {"[material.a]\ntype = \"coated\"\nmultiscatter = \"walk\"\n",
     "3:16",
     {"'walk', which this version does not have yet", "'off' or 'auto'"}},
    {"[material.a]\ntype = \"coated\"\nmultiscatter = \"compensation\"\n", "3:16", {"does not have yet"}},
    {"[material.a]\ntype = \"dielectric\"\nmultiscatter = \"compensation\"\n", "3:16", {"for a dielectric", "'walk'"}},
    {"[material.a]\ntype = \"conductor\"\nmasking = \"separable\"\nmultiscatter = \"walk\"\n",
     "4:16",
     {"'walk' with separable masking", "masking = 'correlated'"}},
    {"[material.a]\ntype = \"coated\"\nmultiscatter = \"wolk\"\n", "3:16", {"did you mean 'walk'?"}},
    {"[material.a]\ntype = \"coated\"\nrotation_deg = \"90\"\n", "3:16", {"found '90'", "a number"}},
    {"[material.a]\ntype = \"metallic_roughness\"\nroughness = 1.2\n", "3:13", {"found 1.2"}},
    {"[material.a]\ntype = \"metallic_roughness\"\nalpha = 1\nroughness = 1\n", "4:1", {"'roughness' beside 'alpha'"}},
    {"[material.a]\ncolor = { file = \"brushed.png\", chanel = \"r\" }\n", "2:33", {"'chanel'", "did you mean 'channel'?"}},
    {"[material.a]\ncolor = { scale = 2 }\n", "2:9", {"no key 'file'"}},
    {"[material.a]\ncolor = { file = \"absent.png\" }\n", "2:18", {"'absent.png'", "/absent.png"}},
    {"[material.a]\ncolor = { file = \"panel.obj\" }\n", "", {"panel.obj: found a file of another format", "PNG"}},
    {"[material.a]\ncolor = { file = \"brushed.png\", color_space = \"rgb\" }\n", "2:47", {"'rgb'", "did you mean 'srgb'?"}},
    {"[material.a]\ncolor = { file = \"brushed.png\", channel = \"r\" }\n", "2:43", {"a channel of a colour"}},
    {"[material.a]\ntype = \"coated\"\nalpha = { file = \"brushed.png\", channel = \"x\" }\n", "3:43", {"'x'", "r, g, b, a"}},
};

/// Files that go on after kMesh: the first line here is line 3.
const std::vector<Malformed> kMeshes{
    {"material = \"brush\"\n", "3:12", {"'brush'", "there is no [material.NAME]"}},
    {"material = \"brush\"\n[material.brushed]\n", "3:12", {"'brush'", "did you mean 'brushed'?"}},
    {"material = { Body = \"a\" }\n[material.a]\n", "3:12", {"a table of materials for a file that names none"}},
    {"subdivision = 6\n", "3:15", {"found 6", "[0, 5]"}},
    {"rest = \"frame\"\n", "3:8", {"'frame'", "'bind' or 'frame N'"}},
    {"rest = \"frame 1x\"\n", "3:8", {"'frame 1x'"}},
    {"scale = [1, 1]\n", "3:9", {"an array of 2 items", "a number or three numbers"}},
    {"translate = [[1, [0, 0, 0]], 2]\n", "3:30", {"found 2", "a key [frame, value]"}},
    {"up = \"x\"\n", "3:6", {"'x'", "z, y"}},
    {"clip = \"run\"\n", "3:1", {"'clip'"}},
    {"[[mesh]]\nname = \"b\"\n", "3:1", {"no key 'file'", "file = \"mesh.obj\""}},
    {"[[mesh]]\nfile = \"none.obj\"\n", "4:8", {"'none.obj'", "/none.obj", "an existing file"}},
    {"[[mesh]]\nfile = \"none.####.obj\"\n", "4:8", {"none.0001.obj", "sequence"}},
    {"[[mesh]]\nfile = \"brushed.png\"\n", "4:8", {"'brushed.png'", ".obj"}},
    {"[[mesh]]\nfile = \"bad.obj\"\n", "", {"bad.obj:2:"}},
    {"[[mesh]]\nfile = \"\"\n", "4:8", {"''"}},
    {"[[mesh]]\nfile = \"figure.glb\"\nclip = \"raise\"\n", "5:8", {"'raise'", "did you mean 'rise'?"}},
    {"[[mesh]]\nfile = \"figure.glb\"\nclip = 1\n", "5:8", {"found 1", "[0, 0]"}},
    {"[[mesh]]\nfile = \"figure.glb\"\nmaterial = { pant = \"a\" }\n[material.a]\n", "5:14", {"'pant'", "paint"}},
    {"[[mesh]]\nfile = \"parts.obj\"\nmaterial = { Bodi = \"a\" }\n[material.a]\n", "5:14", {"'Bodi'", "did you mean 'Body'?"}},
    {"[[light]]\ntype = \"mesh\"\nmesh = \"panal\"\n", "5:8", {"'panal'", "panel"}},
    {"[[light]]\ntype = \"mesh\"\nmesh = \"panel\"\nslot = \"Trim\"\n", "6:8", {"'Trim'", "a mesh with several materials"}},
    {"[[mesh]]\nfile = \"parts.obj\"\n[[light]]\ntype = \"mesh\"\nmesh = \"parts\"\nslot = \"Trin\"\n",
     "8:8",
     {"'Trin'", "did you mean 'Trim'?"}},
    {"[mesh.deform]\ntype = \"shear\"\n", "3:1", {"found a table", "[[mesh.deform]]"}},
    {"[[mesh.deform]]\ntype = \"sheer\"\n", "4:8", {"'sheer'", "did you mean 'shear'?"}},
    {"[[mesh.deform]]\ntype = \"shear\"\nangle_deg = 3\n", "5:1", {"'angle_deg'", "one of type, centre, plane, amount"}},
    {"[[mesh.deform]]\ntype = \"shear\"\nplane = \"xx\"\n", "5:9", {"'xx'", "xy"}},
    {"[[mesh.deform]]\ntype = \"stretch\"\nfactor = [[1, 1], [2, 0]]\n", "5:23", {"found 0", "a number above 0"}},
    {"[[mesh.deform]]\ntype = \"bend\"\naxis = \"x\"\ntowards = \"x\"\n", "3:1", {"axis and towards alike"}},
    {"[[mesh.deform]]\ntype = \"bend\"\nrange = [1, 1]\n", "5:9", {"[1, 1]", "lower below upper"}},
    {"[[mesh.deform]]\ntype = \"taper\"\namount = -1\n", "5:10", {"found -1", "a number above -1"}},
    {"[[mesh.deform]]\ntype = \"wave\"\nwavelength = 0\n", "5:14", {"found 0"}},
    {"[[mesh.deform]]\ntype = \"lattice\"\npoints = [2, 2, 17]\n", "5:17", {"found 17", "[2, 16]"}},
    {"[[mesh.deform]]\ntype = \"lattice\"\nupper = [0, 1, 1]\n", "3:1", {"a lattice box without volume"}},
    {"[[mesh.deform]]\ntype = \"lattice\"\noffsets = [[2, 0, 0, 0, 0, 1]]\n", "5:13", {"found 2", "[0, 1]"}},
    {"[[mesh.deform]]\ntype = \"lattice\"\noffsets = [{ at = [0, 0] }]\n", "5:19", {"an array of 2 items"}},
};

struct MalformedOverride {
    const char *text;
    std::vector<std::string> parts;
};

const std::vector<MalformedOverride> kOverrides{
    {"render.width", {"-D render.width", "no '='"}},
    {"=3", {"no '='"}},
    {"#a=3", {"a dotted key"}},
    {"render..width=3", {"a dotted key"}},
    {"render.width=wide", {"-D render.width=wide: found 'wide'", "an integer"}},
    {"render.widht=3", {"-D render.widht=3: found 'widht'", "did you mean 'width'?"}},
    {"mesh.5.file=a.obj", {"'5'", "an index from 0 to 1"}},
    {"mesh.first.file=a.obj", {"'first'", "an index"}},
    {"mesh.0.file=gone.obj", {"-D mesh.0.file=gone.obj", "'gone.obj'"}},
    {"material.a.alpha=11", {"found 11, expected a number in [1e-4, 10]"}},
    {"render.width.x=3", {"found a table"}},
};

std::string folderOfMalformed() {
    const std::string folder = sceneFolder("malformed_scene");
    writeTo(folder, "bad.obj", "v 0 0 0\nv 0 zero 0\n");
    return folder;
}

std::string flipped(std::string bytes, std::mt19937 &random, int flips) {
    for (int i = 0; i < flips && !bytes.empty(); ++i) bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
    return bytes;
}

std::string truncated(const std::string &bytes, std::mt19937 &random) {
    return bytes.substr(0, random() % bytes.size());
}

} // namespace

TEST_CASE("every malformed scene file says where and what", "[scene][malformed]") {
    const std::string folder = folderOfMalformed();
    const auto check = [&](const Malformed &test, const std::string &before) {
        const std::string line = errorOfText(folder, before + test.toml);
        INFO(before << test.toml << "-> " << line);
        const std::string place = *test.place == '\0' ? "" : "scene.toml:" + std::string(test.place);
        CHECK(says(line, place, test.parts));
    };
    for (const Malformed &test : kSections) check(test, "");
    for (const Malformed &test : kMaterials) check(test, "");
    for (const Malformed &test : kMeshes) check(test, kMesh);
}

TEST_CASE("malformed overrides name themselves", "[scene][malformed]") {
    const std::string folder = folderOfMalformed();
    for (const MalformedOverride &test : kOverrides) {
        const std::string line = errorOfText(folder, kMesh + "[material.a]\ntype = \"coated\"\n[render]\nwidth = 3\n", {test.text});
        INFO(test.text << " -> " << line);
        CHECK(says(line, "-D ", test.parts));
    }
}

TEST_CASE("paths that are no scene", "[scene][malformed]") {
    const std::string folder = folderOfMalformed();
    Warnings warnings;
    const auto error = [&](const std::string &path) { return errorOf([&] { loadScene(path, {}, warnings); }); };
    CHECK(says(error(folder + "/none.toml"), "none.toml: found no such file", {}));
    CHECK(says(error(folder + "/none.obj"), "none.obj", {"no file"}));
    CHECK(says(error(folder + "/none.glb"), "none.glb", {"no file"}));
    CHECK(says(error(folder + "/brushed.png"), "brushed.png: found a file of unknown kind", {".toml", ".glb", ".obj"}));
    CHECK(!error(folder).empty());
    CHECK(!error("").empty());
    std::filesystem::create_directories(folder + "/folder.toml");
    CHECK(says(error(folder + "/folder.toml"), "folder.toml", {"not a file"}));
}

TEST_CASE("keys and values nested without end are refused", "[scene][malformed]") {
    const std::string folder = folderOfMalformed();
    std::string deep;
    for (int i = 0; i < 300000; ++i) deep += "a.";
    CHECK(says(errorOfText(folder, "\n" + deep + "a = 1\n"), "scene.toml:2", {"nested more than 64 deep"}));
    CHECK(!errorOfText(folder, "[" + deep + "a]\n").empty());
    CHECK(!errorOfText(folder, "a = " + std::string(100000, '[') + "\n").empty());
    CHECK(!errorOfText(folder, "a = " + std::string(100, '[') + std::string(100, ']') + "\n").empty());
    CHECK(!errorOfText(folder, "", {deep + "a=1"}).empty());
}

TEST_CASE("damaged scene files never do more than throw InputError", "[scene][malformed]") {
    const std::string folder = folderOfMalformed();
    const std::string scene = R"([render]
width = 8
frames = "1-4x2"
[camera]
position = [[1, [0, -3, 1]], [2, [1, -3, 1]]]
look_at = [0, 0, 0]
[environment]
file = "studio.exr"
[material.brushed]
type = "conductor"
f0 = { file = "brushed.png", scale = 0.5 }
alpha = [0.08, 0.4]
[[light]]
type = "sphere"
radius = 0.5
[[mesh]]
file = "panel.obj"
material = "brushed"
rest = "frame 2"
[[mesh.deform]]
type = "lattice"
points = [2, 3, 2]
offsets = [{ at = [0, 1, 0], offset = [[1, [0, 0, 0]], [2, [0, 0, 1]]] }]
[[mesh]]
file = "cloth.####.obj"
)";
    REQUIRE(errorOfText(folder, scene).empty());
    std::mt19937 random(11);
    int refused = 0;
    for (int i = 0; i < 400; ++i) {
        const std::string damaged = i % 4 == 0 ? truncated(scene, random) : flipped(scene, random, 1 + i % 3);
        if (!errorOfText(folder, damaged).empty()) ++refused;
    }
    CHECK(refused > 200);
}

TEST_CASE("damaged image files never do more than throw InputError", "[texture][environment][malformed]") {
    Warnings warnings;
    const std::string folder = folderOfMalformed();
    std::vector<float> texels(static_cast<std::size_t>(32 * 16 * 3));
    std::mt19937 random(29);
    for (float &texel : texels) texel = static_cast<float>(random() % 256) / 255;
    for (const char *name : {"image.png", "image.exr", "image.hdr", "image.tif", "image.jpg", "image.webp", "image.tga", "image.bmp"}) {
        const bool isFloat = std::string(name) == "image.exr" || std::string(name) == "image.hdr";
        const std::string whole = readBytes(writeImage(folder, name, 32, 16, 3, texels, isFloat ? SampleType::Float : SampleType::UInt8));
        const std::string path = folder + "/damaged_" + name;
        int refused = 0;
        for (int i = 0; i < 120; ++i) {
            const bool cut = i % 2 == 0;
            writeTo(folder, std::string("damaged_") + name, cut ? truncated(whole, random) : flipped(whole, random, 1 + i % 5));
            if (!errorOf([&] { readTexture(path, ColorSpace::Auto, warnings); }).empty()) ++refused;
            errorOf([&] { readEnvironment(path, 0, Vec3(1), warnings); });
        }
        INFO(name);
        CHECK(refused > 10);
    }
}
