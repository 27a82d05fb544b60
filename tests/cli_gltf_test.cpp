/// Animated glTF files on the command line: frames of a clip, and what `taut info` tells of a file.

#include "cli_fixtures.h"
#include "mesh_samples.h"

using namespace taut;
using namespace taut::test;

namespace {

/// A triangle that rises for half a second, a camera, a variant, and an occlusion map that is not shown.
std::string risingGlb() {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int times = b.addFloats("SCALAR", {0, 0.5F});
    const int places = b.addFloats("VEC3", {0, 0, 0, 0, 10, 0});
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", 0}}}}}};
    b.json["materials"] = {{{"occlusionTexture", {{"index", 0}}}}};
    b.json["textures"] = {nlohmann::json::object()};
    b.json["nodes"] = {{{"mesh", 0}}, {{"name", "eye"}, {"camera", 0}, {"translation", {0, 1, 5}}}};
    b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.1}}}}};
    b.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "dusk"}}};
    b.json["extensionsUsed"] = {"KHR_materials_variants"};
    b.json["animations"] = {{{"name", "rise"},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                             {"samplers", {{{"input", times}, {"output", places}}}}}};
    return b.glb();
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("info lists clips, cameras, variants and what is left out; --frames clip is the clip's length", "[cli][gltf]") {
    const std::string folder = freshFolder("cli_gltf");
    const std::string path = folder + "/rising.glb";
    writeBytes(path, risingGlb());
    const CommandResult text = runTaut({"info", path, "--frames", "clip"});
    requireSuccess(text);
    for (const char *part : {"12 frames (1 to 12)", "clip 'rise': 0.5 s", "camera 'eye'", "variant 'dusk'", "occlusionTexture (1)"})
        CHECK(contains(text.out, part));
    CHECK(contains(text.err, "used, but not shown in the picture: occlusionTexture (1)"));
    CHECK(!contains(text.err, "--frames clip"));
    const CommandResult json = runTaut({"info", path, "--json"});
    requireSuccess(json);
    CHECK(contains(json.err, "is animated for 0.5 s; this is frame 1 alone (--frames clip: all)"));
    const nlohmann::json file = nlohmann::json::parse(json.out)["files"][0];
    CHECK(file["clips"][0]["name"] == "rise");
    CHECK(file["clips"][0]["seconds"] == 0.5);
    CHECK(file["cameras"][0] == "eye");
    CHECK(file["variants"][0] == "dusk");
    CHECK(file["left_out"] == "occlusionTexture (1)");
    checkUsageError(runTaut({"info", TAUT_SOURCE_DIR "/meshes/plate.obj", "--frames", "clip"}), "found 'clip', but no clip plays");
}
