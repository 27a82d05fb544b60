/// What textures, samplers, colours and emission of a glTF file make of a scene.

#include "render_fixtures.h"
#include "scene_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

std::vector<std::string> warningsOf(const std::string &path) {
    Warnings warnings;
    loadScene(path, {}, warnings);
    return warnings.lines;
}
bool anySays(const std::vector<std::string> &lines, const std::string &part) {
    return std::any_of(lines.begin(), lines.end(), [&](const std::string &line) { return line.find(part) != std::string::npos; });
}

/// A square from (0, 0) to (1, 1) in the glTF's xy plane whose UVs are its coordinates, v down; material 0.
GltfBuilder squareGltf() {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    const int normals = b.addFloats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    const int uvs = b.addFloats("VEC2", {0, 1, 1, 1, 1, 0, 0, 0});
    const int indices = b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
    b.json["meshes"] = {
        {{"primitives",
          {{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}}}, {"indices", indices}, {"material", 0}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    b.json["materials"] = {{{"name", "m"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
    return b;
}
nlohmann::json &attributesOf(GltfBuilder &b) {
    return b.json["meshes"][0]["primitives"][0]["attributes"];
}

/// Mean of a channel over the pixels that the model covers, seen from the front under a white sky.
Vec3 meanColour(Scene scene) {
    scene.render.width = scene.render.height = 24;
    scene.render.boxFilter = true;
    scene.environment = constantEnvironment(Vec3(1));
    scene.environment->cameraVisible = false;
    scene.lights.clear();
    const std::vector<float> image = renderImage(scene, 1, 64);
    DVec3 sum(0);
    double covered = 0;
    for (std::size_t p = 0; p < image.size(); p += 4) {
        sum += DVec3(image[p], image[p + 1], image[p + 2]);
        covered += static_cast<double>(image[p + 3]);
    }
    REQUIRE(covered > 20);
    return Vec3(sum / covered);
}

/// A 2 x 1 image, red and green, in `folder`.
std::string redGreen(const std::string &folder) {
    return writeImage(folder, "red_green.png", 2, 1, 3, {1, 0, 0, 0, 1, 0});
}

} // namespace

TEST_CASE("case transform-required: an offset of a texture is applied", "[gltf][cases]") {
    const auto path = caseFile("transform-required/a.gltf");
    if (!path) return;
    const Scene scene = loadFile(*path);
    const Texture &texture = scene.textures.at(scene.materials.at(scene.objects.at(0).materials.at(0)).color.texture);
    Texture still = texture;
    still.sampler = {};
    bool differs = false;
    for (const float u : {0.1F, 0.3F, 0.6F, 0.9F}) {
        CHECK(lookup(texture, Vec2(u, 0.5F)) == lookup(still, Vec2(u + 0.5F, 0.5F)));
        differs |= lookup(texture, Vec2(u, 0.5F)) != lookup(still, Vec2(u, 0.5F));
    }
    CHECK(differs);
}

TEST_CASE("textures of one image share it under other transforms, samplers and UV sets", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    redGreen(folder);
    GltfBuilder b = squareGltf();
    attributesOf(b)["TEXCOORD_1"] = b.addFloats("VEC2", {0.1F, 0, 0.1F, 0, 0.1F, 0, 0.1F, 0}); // all of it in the red half
    b.json["images"] = {{{"uri", "red_green.png"}}};
    b.json["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33648}, {"wrapT", 33071}}};
    b.json["textures"] = {{{"source", 0}}, {{"source", 0}, {"sampler", 0}}};
    nlohmann::json &pbr = b.json["materials"][0]["pbrMetallicRoughness"];
    pbr["baseColorTexture"] = {{"index", 1}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {0.25, 1}}}}}}};
    b.json["materials"][0]["emissiveTexture"] = {{"index", 0}};
    b.json["materials"][0]["emissiveFactor"] = {1, 1, 1};
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_texture_transform"};
    Scene scene = loadFile(writeTo(folder, "shared.gltf", b.gltf()));
    REQUIRE(scene.textures.size() == 2);
    CHECK(scene.textures[0].texels.begin() == scene.textures[1].texels.begin());
    const TextureSampler &sampler = scene.textures.at(scene.materials.at(0).color.texture).sampler;
    CHECK(sampler.nearest);
    CHECK(sampler.wrapU == TextureWrap::Mirror);
    CHECK(sampler.wrapV == TextureWrap::Clamp);
    scene.objects[0].emission = {Vec3(0), kNone};
    const Vec3 green = meanColour(scene); // u from 0.5 to 0.75: the green texel alone
    CHECK(green.y > 0.8F);
    CHECK(green.x < 0.1F);

    // The second set of UVs, by the transform's own member.
    pbr["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {{"texCoord", 1}};
    b.json["materials"][0].erase("emissiveTexture");
    b.json["materials"][0].erase("emissiveFactor");
    const Vec3 red = meanColour(loadFile(writeTo(folder, "second.gltf", b.gltf())));
    CHECK(red.x > 0.8F);
    CHECK(red.y < 0.1F);

    // A third is named, and nothing is shown in its place.
    pbr["baseColorTexture"] = {{"index", 0}, {"texCoord", 2}};
    attributesOf(b)["TEXCOORD_2"] = attributesOf(b)["TEXCOORD_1"];
    const std::string third = writeTo(folder, "third.gltf", b.gltf());
    CHECK(anySays(warningsOf(third), "TEXCOORD_2 (1)"));
    CHECK(anySays(warningsOf(third), "a texture wants TEXCOORD_2"));
    CHECK(loadFile(third).materials.at(0).color.texture == kNone);

    b.json["extensionsRequired"] = {"KHR_texture_basisu"};
    CHECK(says(errorOf([&] { loadFile(writeTo(folder, "basisu.gltf", b.gltf())); }), "extensionsRequired[0]: found 'KHR_texture_basisu'",
               {}));
}

TEST_CASE("case vertex-colour: COLOR_0 multiplies the base colour", "[gltf][cases]") {
    const auto path = caseFile("vertex-colour/a.glb");
    if (!path) return;
    const Vec3 colour = meanColour(loadFile(*path));
    CHECK(colour.x > 0.5F);
    CHECK(colour.y < 0.15F * colour.x); // the reflection of a dielectric
    CHECK(colour.y == Approx(colour.z).margin(1e-3));
}

TEST_CASE("vertex colours as bytes and shorts, over a texture, under subdivision and beside a primitive without", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    redGreen(folder);
    GltfBuilder b = squareGltf();
    attributesOf(b)["COLOR_0"] =
        b.add<std::uint8_t>("VEC4", 5121, {0, 255, 255, 51, 0, 255, 255, 51, 0, 255, 255, 51, 0, 255, 255, 51}, true);
    b.json["images"] = {{{"uri", "red_green.png"}}};
    b.json["textures"] = {{{"source", 0}}};
    b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    const std::string bytes = writeTo(folder, "bytes.gltf", b.gltf());
    for (const char *level : {"0", "2"}) {
        const Scene scene = loadFile(bytes, {std::string("mesh.0.subdivision=") + level});
        ObjectSurface surface;
        prepareObjectSurface(scene.objects.at(0), 24, surface);
        REQUIRE(surface.surface.colors.size() == surface.surface.vertexCount());
        for (const Vec4 &color : surface.surface.colors) CHECK(glm::length(color - Vec4(0, 1, 1, 0.2F)) < 1e-5F);
        CHECK(scene.materials.at(scene.objects[0].materials.at(0)).vertexColors);
        const Vec3 colour = meanColour(scene); // red goes, green stays
        CHECK(colour.x < 0.1F);
        CHECK(colour.y > 0.2F);
    }
    // Shorts, RGB; a second primitive has none and stays white.
    attributesOf(b)["COLOR_0"] = b.add<std::uint16_t>("VEC3", 5123, {0, 65535, 0, 0, 65535, 0, 0, 65535, 0, 0, 65535, 0, 0, 0, 0, 0}, true);
    b.json["accessors"].back()["count"] = 4;
    const int away = b.addFloats("VEC3", {2, 0, 0, 3, 0, 0, 3, 1, 0, 2, 1, 0});
    nlohmann::json plain = b.json["meshes"][0]["primitives"][0];
    plain["attributes"] = {{"POSITION", away}};
    b.json["meshes"][0]["primitives"].push_back(plain);
    const Scene scene = loadFile(writeTo(folder, "shorts.gltf", b.gltf()));
    ObjectSurface surface;
    prepareObjectSurface(scene.objects.at(0), 24, surface);
    std::size_t green = 0;
    std::size_t white = 0;
    for (const Vec4 &color : surface.surface.colors) {
        green += color == Vec4(0, 1, 0, 1) ? 1 : 0;
        white += color == Vec4(1) ? 1 : 0;
    }
    CHECK(green == 4);
    CHECK(white == surface.surface.colors.size() - green);
    CHECK(white > 0);
}

TEST_CASE("case emissive-left-out: a texture that can't be read leaves no emission behind", "[gltf][cases]") {
    const auto path = caseFile("emissive-left-out/emissive_webp.gltf");
    if (!path) return;
    const Scene scene = loadFile(*path);
    CHECK(!emits(scene.objects.at(0)));
    CHECK(scene.environment);
    CHECK(anySays(warningsOf(*path), "none.webp"));
}

TEST_CASE("a missing or broken texture is a warning and the factor, whatever it is for", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    GltfBuilder b = squareGltf();
    const std::string broken = std::string("\x89PNG\r\n\x1a\n", 8) + "nothing of the kind";
    b.json["images"] = {{{"uri", "gone%20away.png"}}, {{"bufferView", b.addView(broken)}, {"mimeType", "image/png"}}};
    b.json["textures"] = {{{"source", 0}}, {{"source", 1}}, nlohmann::json::object()};
    nlohmann::json &material = b.json["materials"][0];
    material["pbrMetallicRoughness"] = {{"baseColorFactor", {0.5, 0.25, 0.125, 1}},
                                        {"baseColorTexture", {{"index", 0}}},
                                        {"metallicFactor", 0.75},
                                        {"metallicRoughnessTexture", {{"index", 1}}}};
    material["emissiveFactor"] = {1, 0.5, 0};
    material["emissiveTexture"] = {{"index", 2}};
    const std::string path = writeTo(folder, "gone.gltf", b.gltf());
    const Scene scene = loadFile(path);
    CHECK(scene.materials.at(0).color.value == Vec3(0.5F, 0.25F, 0.125F));
    CHECK(scene.materials.at(0).color.texture == kNone);
    CHECK(scene.materials.at(0).metallic.value == 0.75F);
    CHECK(scene.materials.at(0).metallic.texture == kNone);
    CHECK(!emits(scene.objects.at(0)));
    CHECK(scene.environment);
    const std::vector<std::string> lines = warningsOf(path);
    CHECK(anySays(lines, "gone away.png"));
    CHECK(anySays(lines, "images[1]: found an image that can't be decoded"));
    CHECK(anySays(lines, "material 'm': a texture has no image that can be read"));
}

TEST_CASE("EXT_texture_webp is read where the image library reads it, else what it replaces", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    redGreen(folder);
    GltfBuilder b = squareGltf();
    b.json["images"] = {{{"uri", "gone.webp"}}, {{"uri", "red_green.png"}}};
    b.json["textures"] = {{{"source", 1}, {"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}}};
    b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    b.json["extensionsUsed"] = {"EXT_texture_webp"};
    const Scene fallback = loadFile(writeTo(folder, "webp.gltf", b.gltf()));
    CHECK(fallback.textures.at(fallback.materials.at(0).color.texture).width == 2);
}

TEST_CASE("alphaMode, cutoff and sides of a material", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    writeImage(folder, "half_alpha.png", 1, 1, 4, {1, 1, 1, 0.25F});
    GltfBuilder b = squareGltf();
    b.json["images"] = {{{"uri", "half_alpha.png"}}};
    b.json["textures"] = {{{"source", 0}}};
    nlohmann::json &material = b.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    material["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.5};
    const auto read = [&] { return loadFile(writeTo(folder, "alpha.gltf", b.gltf())).materials.at(0); };
    CHECK(read().alphaMode == AlphaMode::Opaque);
    CHECK(read().opacity.value == 1); // alpha of an opaque material is not read
    CHECK(!read().doubleSided);
    material["alphaMode"] = "MASK";
    material["alphaCutoff"] = 0.25;
    material["doubleSided"] = true;
    const Material masked = read();
    CHECK(masked.alphaMode == AlphaMode::Mask);
    CHECK(masked.alphaCutoff == 0.25F);
    CHECK(masked.opacity.value == 0.5F);
    CHECK(masked.opacity.texture == masked.color.texture);
    CHECK(masked.opacity.channel == 3);
    CHECK(masked.doubleSided);
    material["alphaMode"] = "BLEND";
    CHECK(read().alphaMode == AlphaMode::Blend);
    material["alphaMode"] = "BLENDED";
    CHECK(says(errorOf([&] { read(); }), "materials[0].alphaMode: found 'BLENDED'", {"did you mean 'BLEND'?"}));
}

TEST_CASE("the extensions of a material arrive in it", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    GltfBuilder b = squareGltf();
    writeImage(folder, "bumps.png", 2, 2, 3, {0.5F, 0.5F, 1, 0.7F, 0.5F, 0.9F, 0.5F, 0.7F, 0.9F, 0.5F, 0.5F, 1});
    b.json["images"] = {{{"uri", "bumps.png"}}};
    b.json["textures"] = {{{"source", 0}}};
    b.json["materials"][0]["extensions"] = {
        {"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
        {"KHR_materials_volume", {{"thicknessFactor", 2}, {"attenuationDistance", 0.5}, {"attenuationColor", {0.5, 0.25, 1}}}},
        {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {2, 1, 0.5}}}},
        {"KHR_materials_clearcoat",
         {{"clearcoatFactor", 1}, {"clearcoatRoughnessFactor", 0.25}, {"clearcoatNormalTexture", {{"index", 0}, {"scale", 0.5}}}}},
        {"KHR_materials_sheen", {{"sheenColorFactor", {1, 0.5, 0}}, {"sheenRoughnessFactor", 0.5}}},
        {"KHR_materials_iridescence", {{"iridescenceFactor", 1}, {"iridescenceIor", 1.5}, {"iridescenceThicknessMaximum", 800}}},
        {"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}},
        {"KHR_materials_unlit", nlohmann::json::object()}};
    b.json["materials"][0]["emissiveFactor"] = {0.5, 0, 0};
    b.json["materials"][0]["normalTexture"] = {{"index", 0}, {"scale", 0.25}};
    const std::string path = writeTo(folder, "extensions.gltf", b.gltf());
    const Scene scene = loadFile(path);
    const Material &m = scene.materials.at(0);
    CHECK(m.transmission.value == 0.75F);
    CHECK(!m.thinWalled);
    CHECK(m.doubleSided); // a volume has a wall on its far side
    CHECK(m.attenuationDistance == 0.5F);
    CHECK(m.attenuationColor == Vec3(0.5F, 0.25F, 1));
    CHECK(m.specular.value == 0.5F);
    CHECK(m.specularColor.value == Vec3(2, 1, 0.5F));
    CHECK(m.clearcoat.value == 1);
    CHECK(m.clearcoatRoughness.value == 0.25F);
    CHECK(m.sheenColor.value == Vec3(1, 0.5F, 0));
    CHECK(m.sheenRoughness.value == 0.5F);
    CHECK(m.iridescence.value == 1);
    CHECK(m.iridescenceIor == 1.5F);
    CHECK(m.iridescenceMax == 800);
    CHECK(m.unlit);
    CHECK(scene.objects.at(0).emission.value == Vec3(5, 0, 0));
    CHECK(m.coatSlopes.isGiven());
    CHECK(m.coatSlopes.scale == 0.5F);
    CHECK(m.slopes.isGiven());
    CHECK(m.slopes.kind == SlopeMap::Kind::Normal);
    CHECK(m.slopes.scale == 0.25F);
    CHECK(scene.objects.at(0).mapTangents);
}

TEST_CASE("emission that lights nothing keeps the studio, a lamp turns it off", "[gltf]") {
    const std::string folder = outputFolder("gltf_texture");
    GltfBuilder b = squareGltf();
    // The square glows, and a floor of four times its side lies below or behind it.
    const auto withFloor = [&](float z, float strength) {
        GltfBuilder room = b;
        const int floor = room.addFloats("VEC3", {-1, -1, z, 3, -1, z, 3, 3, z, -1, 3, z});
        nlohmann::json primitive = room.json["meshes"][0]["primitives"][0];
        primitive["attributes"] = {{"POSITION", floor}};
        primitive["material"] = 1;
        room.json["meshes"][0]["primitives"].push_back(primitive);
        room.json["materials"].push_back({{"name", "floor"}});
        room.json["materials"][0]["emissiveFactor"] = {1, 1, 1};
        room.json["materials"][0]["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}}};
        return loadFile(writeTo(folder, "lamp.gltf", room.gltf()));
    };
    CHECK(!withFloor(1, 5).environment);    // it faces the floor
    CHECK(withFloor(-1, 5).environment);    // it faces away
    CHECK(withFloor(1, 1e-4F).environment); // too weak to see anything by
    CHECK(withFloor(1000, 5).environment);  // too far
    const Scene lit = withFloor(1, 5);
    REQUIRE(lit.objects.size() == 1); // one mesh, of which one slot shines
    CHECK(emissionOf(lit.objects[0], 0).radiance.value == Vec3(5));
    CHECK(emissionOf(lit.objects[0], 1).radiance.value == Vec3(0));
}

TEST_CASE("a slot that shines lights as a mesh of its own does", "[gltf][mis]") {
    const std::string folder = outputFolder("gltf_texture");
    const auto scene = [&](bool together) {
        GltfBuilder b = squareGltf();
        const int floor = b.addFloats("VEC3", {-1, -1, -1, 3, -1, -1, 3, 3, -1, -1, 3, -1}); // behind the lamp
        nlohmann::json primitive = b.json["meshes"][0]["primitives"][0];
        primitive["attributes"] = {{"POSITION", floor}};
        primitive["material"] = 1;
        b.json["materials"].push_back({{"name", "floor"}, {"doubleSided", true}});
        b.json["materials"][0]["emissiveFactor"] = {1, 1, 1};
        b.json["materials"][0]["doubleSided"] = true;
        if (together) {
            b.json["meshes"][0]["primitives"].push_back(primitive);
        } else {
            b.json["meshes"].push_back({{"primitives", {primitive}}});
            b.json["nodes"].push_back({{"mesh", 1}});
        }
        Scene made = loadFile(writeTo(folder, "slots.gltf", b.gltf()),
                              {"camera.position=[0.5,-6,0.5]", "camera.look_at=[0.5,0,0.5]", "render.width=16", "render.height=16"});
        made.environment.reset();
        return made;
    };
    const auto mean = [](const std::vector<float> &image) {
        double sum = 0;
        for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]);
        return sum / static_cast<double>(image.size() / 4);
    };
    const double apart = mean(renderImage(scene(false), 1, 256));
    CHECK(apart > 0.01);
    CHECK(mean(renderImage(scene(true), 1, 256)) == Approx(apart).epsilon(0.03));
}

TEST_CASE("a map of normals in the second set of UVs is said to take the tangents of the first", "[gltf][texture]") {
    const std::string folder = outputFolder("gltf_texture");
    writeImage(folder, "normals.png", 1, 1, 3, {0.5F, 0.5F, 1});
    for (const int set : {0, 1}) {
        GltfBuilder b = triangleGltf();
        b.json["images"] = {{{"uri", "normals.png"}}};
        b.json["textures"] = {{{"source", 0}}};
        b.json["materials"] = {{{"name", "skin"}, {"normalTexture", {{"index", 0}, {"texCoord", set}}}}};
        b.json["meshes"][0]["primitives"][0]["material"] = 0;
        const std::vector<std::string> lines = warningsOf(writeTo(folder, "second_set.gltf", b.gltf()));
        const auto said = std::count_if(lines.begin(), lines.end(), [](const std::string &line) {
            return line.find("'skin': its map of normals reads TEXCOORD_1") != std::string::npos;
        });
        CHECK(said == set);
    }
}
