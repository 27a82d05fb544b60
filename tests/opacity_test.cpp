/// Surfaces that are not there: opacity tested and blended, culling, for rays of the camera, scattered rays and shadow rays; what has no
/// light of its own to scatter; and what is lost inside a volume.

#include "catch.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

#include <numeric>

using namespace taut;
using namespace taut::test;

namespace {

constexpr int kSize = 24;
constexpr std::size_t kChannels = 4;

double meanOf(const std::vector<float> &image, std::size_t channel) {
    double sum = 0;
    for (std::size_t i = channel; i < image.size(); i += kChannels) sum += static_cast<double>(image[i]);
    return sum * kChannels / static_cast<double>(image.size());
}
double brightness(const std::vector<float> &image) {
    return meanOf(image, 1);
}

Material diffuse(float albedo) {
    Material material;
    material.color.value = Vec3(albedo);
    return material;
}
Material veil(AlphaMode mode, float opacity, float albedo = 0) {
    Material material = diffuse(albedo);
    material.alphaMode = mode;
    material.opacity.value = opacity;
    return material;
}

Object gridAt(double height, Index material, float size = 8, bool turned = false) {
    Object object = makeObject(makeGrid(1, 1, size), material);
    object.placement.translation = DVec3(0, 0, height);
    if (turned) object.placement.rotation = DVec3(kPi, 0, 0);
    return object;
}

/// Looking straight down from 10 on a floor at 0 under a point light at 4; the camera hides nothing.
Scene floorScene(const Material &floor) {
    Scene scene;
    scene.render.width = scene.render.height = kSize;
    scene.render.boxFilter = true;
    scene.materials = {floor};
    scene.objects = {gridAt(0, 0)};
    scene.camera.position = DVec3(0, 0, 10);
    scene.camera.up = DVec3(0, 1, 0);
    scene.camera.fovY = 0.35;
    scene.lights.push_back({Vec3(50), PointLight{DVec3(0, 0, 4)}});
    return scene;
}

/// One mesh of two layers: a ray meets two triangles of one object.
Mesh twoLayers(float size, float apart) {
    Mesh out = makeGrid(1, 1, size);
    const Mesh layer = out;
    const auto count = static_cast<Index>(layer.positions.size());
    for (const Vec3 &p : layer.positions) out.positions.push_back(p + Vec3(0, 0, apart));
    for (const Index corner : layer.cornerPositions) out.cornerPositions.push_back(corner + count);
    out.cornerUvs.insert(out.cornerUvs.end(), layer.cornerUvs.begin(), layer.cornerUvs.end());
    out.cornerNormals.insert(out.cornerNormals.end(), layer.cornerNormals.begin(), layer.cornerNormals.end());
    for (std::size_t f = 1; f < layer.faceOffsets.size(); ++f)
        out.faceOffsets.push_back(static_cast<Index>(layer.cornerPositions.size()) + layer.faceOffsets[f]);
    return out;
}

} // namespace

TEST_CASE("A surface whose opacity is below the cutoff is none, for the camera and for shadows", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    const std::vector<float> bare = renderImage(scene, 1, 16);
    REQUIRE(brightness(bare) > 0.05);
    scene.materials.push_back(veil(AlphaMode::Mask, 0.49F));
    scene.objects.push_back(gridAt(2, 1)); // between light and floor
    scene.objects.push_back(gridAt(6, 1)); // between camera and light
    CHECK(greatestDifference(renderImage(scene, 1, 16), bare) < 1e-5F);
    scene.materials[1].opacity.value = 0.5F; // at the cutoff it is there
    CHECK(brightness(renderImage(scene, 1, 16)) == 0);
    scene.materials[1].alphaMode = AlphaMode::Opaque; // glTF: opacity has no say
    scene.materials[1].opacity.value = 0;
    CHECK(brightness(renderImage(scene, 1, 16)) == 0);
}

TEST_CASE("Opacity is tested by the texel that a ray meets", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    const std::vector<float> bare = renderImage(scene, 1, 16);
    Texture texture; // left half clear
    texture.channels = 4;
    texture.width = 2;
    texture.texels = {1, 1, 1, 0, 1, 1, 1, 1};
    scene.textures.push_back(texture);
    scene.materials.push_back(veil(AlphaMode::Mask, 1));
    scene.materials[1].opacity = {1, 0, 3};
    scene.objects.push_back(gridAt(6, 1));
    const std::vector<float> image = renderImage(scene, 1, 16);
    int wrong = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const std::size_t at = static_cast<std::size_t>(y * kSize + x) * kChannels;
            const float expected = x < kSize / 2 ? bare[at] : 0;
            wrong += std::fabs(image[at] - expected) <= 1e-5F ? 0 : 1;
        }
    CHECK(wrong == 0);
}

TEST_CASE("Blended layers let pass the product of what each lets pass, and count so in the picture's alpha", "[opacity][render]") {
    Scene scene = floorScene(veil(AlphaMode::Blend, 0.25F));
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.environment->cameraVisible = true;
    const auto expect = [&](double passes) {
        CHECK(brightness(renderImage(scene, 1, 256)) == Approx(passes).margin(0.004));
        scene.environment->cameraVisible = false;
        CHECK(meanOf(renderImage(scene, 1, 256), 3) == Approx(1 - passes).margin(0.004));
        scene.environment->cameraVisible = true;
    };
    expect(0.75);
    scene.objects.push_back(gridAt(1, 0));
    expect(0.75 * 0.75);
    scene.objects = {makeObject(twoLayers(8, 1), 0)};
    expect(0.75 * 0.75);
    scene.materials[0].opacity.value = 0;
    expect(1);
}

TEST_CASE("Blended surfaces throw the share of a shadow that is their opacity", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    const double bare = brightness(renderImage(scene, 1, 64));
    scene.materials.push_back(veil(AlphaMode::Blend, 0.25F));
    scene.objects.push_back(gridAt(2, 1));
    // From the camera it is crossed as well, and its dark side shows nothing.
    CHECK(brightness(renderImage(scene, 1, 256)) / bare == Approx(0.75 * 0.75).epsilon(0.01));
    scene.camera.position = DVec3(0, 0, 1.5);
    const double below = brightness(renderImage(scene, 1, 256));
    scene.objects.pop_back();
    CHECK(below / brightness(renderImage(scene, 1, 256)) == Approx(0.75).epsilon(0.01));
}

TEST_CASE("An emitter gives the share of its light that is its opacity", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    scene.lights.clear();
    scene.materials.push_back(veil(AlphaMode::Opaque, 0.5F));
    Object lamp = gridAt(5, 1, 6, true);
    lamp.emission.value = Vec3(1);
    scene.objects.push_back(lamp);
    scene.camera.position = DVec3(0, 0, 4);
    const double opaque = brightness(renderImage(scene, 1, 256));
    REQUIRE(opaque > 0.1);
    scene.materials[1].alphaMode = AlphaMode::Blend;
    CHECK(brightness(renderImage(scene, 1, 256)) / opaque == Approx(0.5).epsilon(0.02));
    scene.materials[1].alphaMode = AlphaMode::Mask;
    scene.materials[1].alphaCutoff = 0.6F;
    CHECK(brightness(renderImage(scene, 1, 64)) == 0);
}

TEST_CASE("Single-sided surfaces are not there from behind, for any ray, mirrored and instanced ones too", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    const std::vector<float> bare = renderImage(scene, 1, 16);
    Material oneSided = diffuse(0);
    oneSided.doubleSided = false;
    scene.materials.push_back(oneSided);
    const auto withSheet = [&](double height, bool facesDown, const DVec3 &scale, bool moves) {
        Scene with = scene;
        Object sheet = gridAt(height, 1, 8, facesDown);
        sheet.placement.scale = scale;
        if (moves) sheet.placement.translation.keys = {{1, DVec3(0, 0, height)}, {2, DVec3(0.1, 0, height)}};
        with.objects.push_back(sheet);
        RenderScene ready(with, moves);
        ready.setFrame(1);
        FrameOptions options;
        options.spp = 16;
        options.seed = 1;
        return renderFrame(ready, options).film.resolve();
    };
    for (const DVec3 &scale : {DVec3(1), DVec3(-1, 1, 1)})
        for (const bool moves : {false, true}) {
            INFO("scale " << scale.x << (moves ? ", moving" : ""));
            CHECK(greatestDifference(withSheet(6, true, scale, moves), bare) < 1e-5F); // its back to the camera
            CHECK(brightness(withSheet(6, false, scale, moves)) == 0);
            // Between light and floor: shadow rays leave the floor, and see the back of what faces up.
            CHECK(brightness(withSheet(2, true, scale, moves)) == 0);
        }
    // Facing up it hides the floor from the camera, which is why that is below.
    scene.camera.position = DVec3(0, 0, 1.5);
    scene.materials[1].doubleSided = true;
    const std::vector<float> dark = withSheet(2, false, DVec3(1), false);
    CHECK(brightness(dark) == 0);
    scene.materials[1].doubleSided = false;
    CHECK(brightness(withSheet(2, false, DVec3(1), false)) > 0.05);
}

TEST_CASE("A material that becomes transparent between two frames is so in the next", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    const std::vector<float> bare = renderImage(scene, 1, 16);
    scene.materials.push_back(veil(AlphaMode::Opaque, 0));
    scene.objects.push_back(gridAt(6, 1));
    RenderScene ready(scene, true);
    FrameOptions options;
    options.spp = 16;
    options.seed = 1;
    const auto image = [&] {
        ready.setFrame(1);
        return renderFrame(ready, options).film.resolve();
    };
    CHECK(brightness(image()) == 0);
    ready.setMaterial(1, veil(AlphaMode::Mask, 0));
    CHECK(greatestDifference(image(), bare) < 1e-5F);
    ready.setMaterial(1, veil(AlphaMode::Opaque, 0));
    CHECK(brightness(image()) == 0);
}

TEST_CASE("Unlit materials show their colour, and nothing else", "[opacity][render]") {
    Scene scene = floorScene(diffuse(0.5F));
    scene.materials[0].color.value = Vec3(0.25F, 0.5F, 0.75F);
    scene.materials[0].unlit = true;
    for (const BsdfType type : {BsdfType::Diffuse, BsdfType::MetallicRoughness, BsdfType::Conductor}) {
        scene.materials[0].type = type;
        const std::vector<float> image = renderImage(scene, 1, 4);
        for (std::size_t c = 0; c < 3; ++c) CHECK(meanOf(image, c) == Approx(0.25 * static_cast<double>(c + 1)).epsilon(1e-5));
        CHECK(meanOf(image, 3) == Approx(1));
    }
}

TEST_CASE("Light is lost inside a volume by Beer's law", "[opacity][render]") {
    // A slab two units thick in a furnace, seen along its normal: with a left of the light after one way, R = 0.04 and T = 0.96 the
    // bounces between both faces add up to R + (T^2 a + R T^2 a^2) / (1 - R^2 a^2), reflections out and in.
    Material glass;
    glass.type = BsdfType::MetallicRoughness;
    glass.alphaX.value = glass.alphaY.value = 1e-3F;
    glass.transmission.value = 1;
    glass.thinWalled = false;
    glass.attenuationColor = Vec3(0.25F, 0.5F, 1);
    glass.attenuationDistance = 4;
    Scene scene = floorScene(glass);
    scene.objects.push_back(gridAt(-2, 0, 8, true));
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.camera.fovY = 0.05;
    scene.render.maxEvents = 12;
    const std::vector<float> image = renderImage(scene, 1, 256);
    for (std::size_t c = 0; c < 3; ++c) {
        const double a = std::pow(static_cast<double>(glass.attenuationColor[static_cast<int>(c)]), 2.0 / 4.0);
        CHECK(meanOf(image, c) == Approx(0.04 + 0.96 * 0.96 * (a + 0.04 * a * a) / (1 - 0.0016 * a * a)).margin(0.005));
    }
}

TEST_CASE("Scene files say what is there of a surface, and which layers it has", "[opacity][scene]") {
    const std::string folder = sceneFolder("opacity");
    Warnings warnings;
    const auto materialOf = [&](const std::string &keys) {
        writeTo(folder, "scene.toml", "[material.a]\n" + keys + "[[mesh]]\nfile = \"panel.obj\"\nmaterial = \"a\"\n");
        return loadScene(folder + "/scene.toml", {}, warnings).materials.at(0);
    };
    const Material blended = materialOf("opacity = 0.5\ndouble_sided = false\n");
    CHECK(blended.alphaMode == AlphaMode::Blend);
    CHECK(blended.opacity.value == 0.5F);
    CHECK(!blended.doubleSided);
    const Material masked = materialOf("opacity = {file = \"brushed.png\", channel = \"a\"}\nalpha_mode = \"mask\"\nalpha_cutoff = 0.2\n");
    CHECK(masked.alphaMode == AlphaMode::Mask);
    CHECK(masked.opacity.channel == 3);
    CHECK(masked.alphaCutoff == 0.2F);
    CHECK(materialOf("").alphaMode == AlphaMode::Opaque);
    const Material amber = materialOf("type = \"metallic_roughness\"\ntransmission = 1\nthin_walled = false\nattenuation_color = "
                                      "[1, 0.5, 0.25]\nattenuation_distance = 2\nclearcoat = 0.5\nsheen_color = [1, 0, 0]\nunlit = true\n");
    CHECK(amber.transmission.value == 1);
    CHECK(!amber.thinWalled);
    CHECK(amber.attenuationColor == Vec3(1, 0.5F, 0.25F));
    CHECK(amber.attenuationDistance == 2);
    CHECK(amber.clearcoat.value == 0.5F);
    CHECK(amber.sheenColor.value == Vec3(1, 0, 0));
    CHECK(amber.unlit);
    CHECK(warnings.lines.empty());
}

TEST_CASE("A colour above 1 is held at 1 and counted, of numbers and texels alike", "[opacity][scene]") {
    const std::string folder = sceneFolder("above_one");
    std::string first;
    for (const std::string color : {"1", "3", "[2, 2, 2]", "{file = \"brushed.png\", scale = 1000}"})
        for (const std::string type : {"diffuse", "coated", "metallic_roughness"}) {
            INFO(type << ", color " << color);
            writeTo(folder, "scene.toml",
                    "[render]\nwidth = 8\nheight = 8\n[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nfov_deg = 5\n"
                    "[environment]\nradiance = 1\n[material.a]\ntype = \"" +
                        type + "\"\ncolor = " + color + "\n[[mesh]]\nfile = \"panel.obj\"\nmaterial = \"a\"\n");
            Warnings warnings;
            Scene scene = loadScene(folder + "/scene.toml", {}, warnings);
            CHECK(warnings.lines.size() == (color == "1" ? 0U : 1U));
            if (!warnings.lines.empty()) CHECK(warnings.lines.front().find("above 1") != std::string::npos);
            const std::vector<float> image = renderImage(scene, 1, 256);
            CHECK(brightness(image) == Approx(1).margin(type == "coated" ? 0.05 : 0.01));
        }
}

TEST_CASE("Cases albedo-over-1: a texel above 1 reflects all, and is counted", "[opacity][cases]") {
    for (const char *name : {"albedo-over-1/a.toml", "albedo-over-1/x.toml"}) {
        const auto path = caseFile(name);
        if (!path) return;
        Warnings warnings;
        const Scene scene = loadScene(*path, {"render.width=32", "render.height=32"}, warnings);
        INFO(name);
        REQUIRE(warnings.lines.size() == 1);
        CHECK(warnings.lines.front().find("above 1") != std::string::npos);
        const std::vector<float> image = renderImage(scene, 1, 16);
        CHECK(*std::min_element(image.begin(), image.end()) > 0.9F);
        CHECK(*std::max_element(image.begin(), image.end()) < 1.001F);
    }
}
