/// Surfaces of glTF files that are not there, in part or as a whole: alpha masks, blends, single sides, thin glass.

#include "render_fixtures.h"
#include "scene_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

/// Mean of a channel, weighted with `weight(x, y)`.
template <class Weight> double meanOf(const std::vector<float> &image, int size, std::size_t channel, const Weight &weight) {
    double sum = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            sum += weight(x, y) * static_cast<double>(image[4 * static_cast<std::size_t>(y * size + x) + channel]);
    return sum / (size * size);
}
double meanOf(const std::vector<float> &image, int size, std::size_t channel) {
    return meanOf(image, size, channel, [](int, int) { return 1.0; });
}

/// A white floor of 4 x 4 in the glTF's xy plane and a square of 2 x 2 half a metre above it, with a texture of this alpha.
Scene coveredFloor(const std::string &folder, const std::string &mode, float alpha, bool withCover, bool turned = false) {
    writeImage(folder, "alpha.png", 1, 1, 4, {1, 1, 1, alpha});
    GltfBuilder b;
    const auto square = [&](float half, float z, bool flipped) {
        const int positions = b.addFloats("VEC3", {-half, -half, z, half, -half, z, half, half, z, -half, half, z});
        const int uvs = b.addFloats("VEC2", {0, 1, 1, 1, 1, 0, 0, 0});
        const int indices = flipped ? b.add<std::uint16_t>("SCALAR", 5123, {0, 2, 1, 0, 3, 2})
                                    : b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
        return nlohmann::json{{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}}, {"indices", indices}};
    };
    b.json["meshes"][0]["primitives"] = {square(2, 0, false)};
    b.json["meshes"][0]["primitives"][0]["material"] = 0;
    if (withCover) {
        b.json["meshes"][0]["primitives"].push_back(square(1, 0.5F, turned));
        b.json["meshes"][0]["primitives"][1]["material"] = 1;
    }
    b.json["images"] = {{{"uri", "alpha.png"}}};
    b.json["textures"] = {{{"source", 0}}};
    b.json["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0}}}, {"doubleSided", true}},
                           {{"alphaMode", mode},
                            {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"baseColorTexture", {{"index", 0}}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    Scene scene = loadFile(writeTo(folder, "covered.gltf", b.gltf()),
                           {"camera.position=[0,-6,0]", "camera.look_at=[0,0,0]", "camera.fov_deg=30", "render.width=24", "render.height=24",
                            "environment.radiance=1", "environment.camera_visible=false"});
    return scene;
}

} // namespace

TEST_CASE("case alpha-mask: what lies below the cutoff is no surface", "[gltf][cases][opacity]") {
    const auto path = caseFile("alpha-mask/a.gltf");
    if (!path) return;
    const Scene scene = loadFile(*path, {"render.width=16", "render.height=16", "environment.radiance=1", "environment.camera_visible=false"});
    CHECK(meanOf(renderImage(scene, 1, 16), 16, 3) == 0);
}

TEST_CASE("a mask of a glTF file hides nothing and casts no shadow, a blend its share, a back face nothing", "[gltf][opacity]") {
    const std::string folder = outputFolder("gltf_surface");
    const auto mean = [&](const std::string &mode, float alpha, bool cover, bool turned = false) {
        return meanOf(renderImage(coveredFloor(folder, mode, alpha, cover, turned), 1, 256), 24, 0);
    };
    const double open = mean("MASK", 0.2F, false);
    const double covered = mean("OPAQUE", 0.2F, true);
    CHECK(open > 0.8);
    CHECK(covered < 0.9 * open);
    CHECK(mean("MASK", 0.2F, true) == Approx(open).epsilon(0.005));
    CHECK(mean("MASK", 0.8F, true) == Approx(covered).epsilon(0.005));
    // Turned over, rays from the camera pass, those from the floor meet its front: darker than the open floor, brighter than the cover.
    const double turned = mean("OPAQUE", 0.2F, true, true);
    CHECK(turned > covered + 0.01);
    CHECK(turned < 0.9 * open);
    const double blended = mean("BLEND", 0.5F, true);
    CHECK(blended > covered + 0.3 * (open - covered));
    CHECK(blended < open - 0.3 * (open - covered));
}

TEST_CASE("case thin-glass: transmission without a volume leaves the light where it is", "[gltf][cases][opacity]") {
    const auto pane = caseFile("thin-glass/pane.toml");
    const auto none = caseFile("thin-glass/none.toml");
    if (!pane || !none) return;
    const std::vector<std::string> small{"render.width=64", "render.height=64"};
    const std::vector<float> through = renderImage(loadFile(*pane, small), 1, 64);
    const std::vector<float> bare = renderImage(loadFile(*none, small), 1, 64);
    const auto centre = [&](const std::vector<float> &image) {
        const double sum = meanOf(image, 64, 0);
        return DVec2(meanOf(image, 64, 0, [](int x, int) { return x; }), meanOf(image, 64, 0, [](int, int y) { return y; })) / sum;
    };
    CHECK(meanOf(bare, 64, 0) > 0);
    CHECK(glm::length(centre(through) - centre(bare)) < 0.3);
    // Two faces reflect some 4 % each, more from the side.
    CHECK(meanOf(through, 64, 0) > 0.75 * meanOf(bare, 64, 0));
    CHECK(meanOf(through, 64, 0) < meanOf(bare, 64, 0));
}
