/// Hits shaded at once and hits shaded one by one are the same picture, to the bit.

#include "catch.h"
#include "lanes_fixtures.h"

#include <tbb/global_control.h>

#include <algorithm>

using namespace taut;
using namespace taut::test;

TEST_CASE("Shading at once gives the picture of shading one by one", "[render][lanes]") {
    struct Case {
        const char *name;
        Material material;
    };
    Material separable = plain(BsdfType::Conductor, 0.2F, 0.4F, 0.3F);
    separable.masking = Masking::Separable;
    Material glass = plain(BsdfType::Dielectric, 0.01F, 0.01F, 0);
    glass.masking = Masking::Separable;
    const Case cases[] = {{"diffuse", plain(BsdfType::Diffuse, 1, 1, 0)},
                          {"Schlick, brushed and turned", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F)},
                          {"metal, isotropic", plain(BsdfType::Metal, 0.2F, 0.2F, 0)},
                          {"so rough and sheared that the cone is sampled", plain(BsdfType::Metal, 1, 0.3F, 0.2F)},
                          {"nearly a mirror", plain(BsdfType::Conductor, 1e-4F, 1e-4F, 0)},
                          {"separable", separable},
                          {"rough glass, sheared", plain(BsdfType::Dielectric, 0.1F, 0.4F, 0.3F)},
                          {"clear glass, separable", glass}};
    for (const Case &c : cases)
        for (const bool animated : {false, true}) {
            INFO(c.name << (animated ? ", animated" : ""));
            const Scene s = laneScene(c.material);
            const Film atOnce = filmOf(s, false, animated, 16);
            CHECK(atOnce.resolve() == imageOf(s, true, animated, 16));
            CHECK(brightest(atOnce) > 0.5F);
        }
}

TEST_CASE("Textures, compensation and glTF's material at once give the picture of one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    const auto add = [&](const std::string &name, Material material, const auto &change) {
        Scene s = textured(material);
        change(s, s.materials[0]);
        cases.push_back({name, std::move(s)});
    };
    const auto asItIs = [](Scene &, Material &) {};
    const auto texturedColor = [](Scene &, Material &m) { m.color = {Vec3(1, 0.9F, 0.8F), 0}; };
    const auto everyTexture = [](Scene &, Material &m) {
        m.color.texture = m.metallic.texture = m.alphaX.texture = m.alphaY.texture = 0;
        m.metallic = {1, 0, 2};
        m.rotation = {1, 1, 0};
    };
    Material paint = plain(BsdfType::MetallicRoughness, 0.5F, 0.5F, 0);
    paint.multiscatter = Multiscatter::Auto;
    paint.alphaIsRoughness = true;
    add("diffuse, textured", plain(BsdfType::Diffuse, 1, 1, 0), texturedColor);
    add("Schlick, textured throughout", plain(BsdfType::Conductor, 0.9F, 0.7F, 0), everyTexture);
    add("rough glass, textured", plain(BsdfType::Dielectric, 0.4F, 0.4F, 0), everyTexture);
    add("coated", plain(BsdfType::Coated, 0.1F, 0.3F, 0.2F), asItIs);
    add("coated, textured", plain(BsdfType::Coated, 0.8F, 0.8F, 0), everyTexture);
    add("paint", paint, asItIs);
    add("paint, textured", paint, texturedColor);
    add("white paint, nearly smooth", paint, [](Scene &, Material &m) {
        m.color.value = Vec3(1);
        m.alphaX.value = m.alphaY.value = 0.15F;
    });
    add("white paint, very rough and sheared", paint, [](Scene &, Material &m) {
        m.color.value = Vec3(1);
        m.alphaX.value = 1;
        m.alphaY.value = 0.4F;
    });
    add("black paint", paint, [](Scene &, Material &m) { m.color.value = Vec3(0); });
    add("no reflection", paint, [](Scene &, Material &m) { m.specular.value = 0; });
    add("an index of 0", paint, [](Scene &, Material &m) { m.ior = 0; });
    add("paint of specular colour", paint, [](Scene &, Material &m) {
        m.specular.value = 0.7F;
        m.specularColor.value = Vec3(1, 0.2F, 0.1F);
        m.ior = 2;
    });
    add("metal of glTF, compensated", paint, [](Scene &, Material &m) { m.metallic.value = m.alphaX.value = m.alphaY.value = 1; });
    add("half a metal, compensated", paint, [](Scene &, Material &m) {
        m.metallic.value = 0.5F;
        m.multiscatter = Multiscatter::Compensation;
    });
    add("metal here, paint there", paint, everyTexture);
    add("metal of glTF, brushed", paint, [](Scene &, Material &m) {
        m.metallic.value = 1;
        m.anisotropyStrength = 0.8F;
        m.anisotropyTexture = 0;
    });
    add("Schlick, compensated", plain(BsdfType::Conductor, 0.8F, 0.6F, 0.3F),
        [](Scene &, Material &m) { m.multiscatter = Multiscatter::Auto; });
    add("metal, compensated where it is rough", plain(BsdfType::Metal, 1.5F, 1.5F, 0), [](Scene &, Material &m) {
        m.multiscatter = Multiscatter::Auto;
        m.alphaX.texture = m.alphaY.texture = 0;
    });
    add("Poisson's ratio", plain(BsdfType::Conductor, 0.2F, 0.4F, 0.3F), [](Scene &, Material &m) { m.poisson = 0.4F; });
    add("colours of the mesh", paint, [](Scene &s, Material &m) {
        m.vertexColors = true;
        Mesh mesh = *s.objects[0].mesh;
        mesh.cornerColors = mesh.cornerPositions;
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) mesh.colors.emplace_back(0.1F * static_cast<float>(i % 10), 0.8F, 0.3F, 1);
        s.objects[0].mesh = std::make_shared<const Mesh>(std::move(mesh));
    });
    add("separable paint", paint, [](Scene &, Material &m) { m.masking = Masking::Separable; });
    checkPictures(cases);
}

TEST_CASE("A stored M at once gives the picture of one by one", "[render][lanes][stored]") {
    const auto stored = [](const Material &material) {
        Scene s = textured(material);
        storeGloss(s);
        return s;
    };
    Material walked = plain(BsdfType::Conductor, 0.5F, 0.5F, 0);
    walked.multiscatter = Multiscatter::Walk;
    Material coated = plain(BsdfType::MetallicRoughness, 0.5F, 0.5F, 0);
    coated.clearcoat.value = 0.7F;
    coated.multiscatter = Multiscatter::Auto;
    coated.color.texture = coated.metallic.texture = 0;
    Scene leaning = stored(plain(BsdfType::Conductor, 0.3F, 0.5F, 0));
    for (Object &object : leaning.objects) object.lean = true;
    const std::vector<LaneCase> cases{{"diffuse", stored(plain(BsdfType::Diffuse, 1, 1, 0))},
                                      {"Schlick", stored(plain(BsdfType::Conductor, 0.2F, 0.6F, 0.4F))},
                                      {"glass", stored(plain(BsdfType::Dielectric, 0.3F, 0.3F, 0))},
                                      {"walked", stored(walked)},
                                      {"coated, textured", stored(coated)},
                                      {"beside one that leans", leaning}};
    checkPictures(cases);
    // And it is what is seen.
    Scene without = cases[1].scene;
    Mesh mesh = *without.objects[0].mesh;
    mesh.storedM.clear();
    without.objects[0].mesh = std::make_shared<const Mesh>(std::move(mesh));
    CHECK(imageOf(without, false, true, 8) != imageOf(cases[1].scene, false, true, 8));
}

TEST_CASE("Singular values out of range are clamped at once as one by one", "[render][lanes]") {
    // Squeezed to a thousandth of a millionth: the distribution along y is wider than any range.
    Scene s = laneScene(plain(BsdfType::Conductor, 0.3F, 0.5F, 0.7F));
    DeformerKeys squeeze;
    squeeze.type = DeformerType::Stretch;
    squeeze.factor = Keyed<DVec3>(DVec3(1, 1e-9, 1));
    s.objects[0].deformers = {squeeze};
    CHECK(imageOf(s, false, true, 8) == imageOf(s, true, true, 8));
}

TEST_CASE("Every set of instructions gives the same lanes", "[render][lanes][batch]") {
    const auto [type, multiscatter, mapped] =
        GENERATE(table<BsdfType, Multiscatter, bool>({{BsdfType::Metal, Multiscatter::Off, false},
                                                      {BsdfType::Dielectric, Multiscatter::Off, false},
                                                      {BsdfType::Conductor, Multiscatter::Compensation, false},
                                                      {BsdfType::Coated, Multiscatter::Off, false},
                                                      {BsdfType::Diffuse, Multiscatter::Off, false},
                                                      {BsdfType::MetallicRoughness, Multiscatter::Off, false},
                                                      {BsdfType::MetallicRoughness, Multiscatter::Compensation, false},
                                                      {BsdfType::Metal, Multiscatter::Off, true},
                                                      {BsdfType::Dielectric, Multiscatter::Off, true},
                                                      {BsdfType::Diffuse, Multiscatter::Off, true},
                                                      {BsdfType::MetallicRoughness, Multiscatter::Compensation, true}}));
    Material rough = plain(type, 0.2F, 0.6F, 0.4F);
    rough.multiscatter = multiscatter;
    rough.metallic.value = 0.3F;
    if (mapped) rough.slopes.texture = 0;
    if (mapped) rough.clearcoat.value = 0.5F;
    const Scene s = textured(rough);
    const std::vector<PreparedMaterial> prepared = prepareMaterials(s, defaultPlan(s));
    const LaneMaterial material = laneMaterial(prepared[0]);
    REQUIRE(material.inLanes);
    const auto filled = [&](Instructions set) {
        auto lanes = std::make_unique<HitLanes>();
        lanes->count = 45;
        for (std::size_t i = 0; i < static_cast<std::size_t>(lanes->padded()); ++i) {
            const auto x = static_cast<float>(i) / 48;
            const Vec3 n = glm::normalize(Vec3(x - 0.5F, 0.3F - x * x, 1));
            lanes->position.set(i, {x, 1 - x, -2});
            lanes->e1.set(i, {1, 0, 0.1F});
            lanes->e2.set(i, {0.2F, 1, i % 7 == 0 ? -3.0F : 0.1F});
            lanes->normal.set(i, n);
            lanes->tangent.set(i, {1, x, 0});
            lanes->tangentSense[i] = i % 2 == 0 ? 1.0F : -1.0F;
            lanes->corners[i] = 3;
            lanes->diagonal.set(i, {1 + x, 1.2F, 1});
            lanes->offDiagonal.set(i, {0.4F * x, 0.1F, -0.2F});
            lanes->deforms[i] = i % 5 == 0 ? 0 : 1;
            lanes->wo.set(i, glm::normalize(Vec3(x, 0.5F, 1)));
            lanes->throughput.set(i, {0.9F, 0.5F, x});
            lanes->etaScale[i] = 1;
            lanes->sample[i] = static_cast<std::uint32_t>(i);
            lanes->seed[i] = static_cast<std::uint32_t>(i * i + 1);
            lanes->path[i] = static_cast<Index>(i);
            lanes->lightDirection.set(i, glm::normalize(Vec3(-x, 0.2F, i % 4 == 0 ? -1.0F : 1.0F)));
            lanes->lightRadiance.set(i, {1, 2, 3});
            lanes->lightPdf[i] = 0.7F;
            lanes->lightWeighted[i] = i % 3 == 0 ? 0.0F : 1.0F;
        }
        lanes::setValues(*lanes, material);
        lanes->leans = mapped;
        if (material.layered) lanes->coat = std::make_unique<HitLanes>();
        for (std::size_t i = 0; mapped && i < static_cast<std::size_t>(lanes->padded()); ++i) {
            const auto x = static_cast<float>(i) / 48;
            lanes::setSlopes(*lanes, i, {Vec2(x - 0.4F, 0.3F), i % 3 == 0 ? Vec3(0.02F, 0.01F, 0.03F) : Vec3(0)});
            if (!material.layered) continue;
            lanes->specular[i] = x;
            lanes->specularColor.set(i, {1, x, 0.5F});
            lanes->clearcoat[i] = 0.5F;
            lanes::setValues(*lanes->coat, i, Vec3(0), 0, {0.1F, 0.1F, 0});
        }
        lanes::view(*lanes, material, {1, 2, 3}, set);
        lanes::connect(*lanes, material, set);
        lanes::scatter(*lanes, material, set);
        return lanes;
    };
    const auto expected = filled(Instructions::Sse2);
    for (const Instructions set : {Instructions::Avx2, Instructions::Avx512}) {
        if (!has(set)) continue;
        const auto got = filled(set);
        int connected = 0;
        for (std::size_t i = 0; i < 45; ++i) {
            INFO("lane " << i);
            CHECK(got->woLocal.at(i) == expected->woLocal.at(i));
            CHECK(got->pdfScale[i] == expected->pdfScale[i]);
            if (mapped) CHECK(got->tilted[i] == expected->tilted[i]);
            if (mapped) CHECK(got->n.at(i) == expected->n.at(i));
            CHECK((got->connects[i] > 0) == (expected->connects[i] > 0));
            CHECK((got->goesOn[i] > 0) == (expected->goesOn[i] > 0));
            if (expected->connects[i] > 0) CHECK(got->contribution.at(i) == expected->contribution.at(i));
            if (expected->goesOn[i] > 0) CHECK(got->nextDirection.at(i) == expected->nextDirection.at(i));
            if (expected->goesOn[i] > 0) CHECK(got->nextThroughput.at(i) == expected->nextThroughput.at(i));
            connected += expected->connects[i] > 0 ? 1 : 0;
        }
        CHECK(connected > (type == BsdfType::Dielectric ? 30 : 20)); // glass answers on both sides
    }
}
