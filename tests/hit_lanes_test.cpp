/// Hits shaded at once and hits shaded one by one are the same picture, to the bit.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/hit_lanes.h"

#include <algorithm>

using namespace taut;
using namespace taut::test;

namespace {

std::vector<float> imageOf(const Scene &scene, bool oneByOne, bool animated, int spp) {
    RenderScene ready(scene, animated);
    StageTimes times;
    ready.setFrame(2, times);
    FrameOptions options;
    options.spp = spp;
    options.seed = 3;
    options.oneByOne = oneByOne;
    return renderFrame(ready, options).film.resolve();
}

/// A sheared torus over a plate that reflects it, under a quad and a sky.
Scene scene(const Material &material) {
    Scene scene = smallScene(shearedTorus(40, 20), material);
    scene.materials.push_back(ggxMaterial(0.1F, 0.3F));
    scene.objects.push_back(makeObject(makeGrid(3, 3, 4), 1));
    scene.objects[1].placement.translation = Keyed<DVec3>(DVec3(0, 0, -0.4));
    scene.render.maxEvents = 6;
    return scene;
}

Material plain(BsdfType type, float alphaX, float alphaY, float rotation) {
    Material m = ggxMaterial(alphaX, alphaY, rotation);
    m.type = type;
    m.color.value = Vec3(0.9F, 0.7F, 0.4F);
    m.conductorEta = Vec3(0.2F, 0.9F, 1.1F);
    m.conductorK = Vec3(3.9F, 2.5F, 2.2F);
    m.multiscatter = Multiscatter::Off;
    return m;
}

} // namespace

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
            const Scene s = scene(c.material);
            const std::vector<float> atOnce = imageOf(s, false, animated, 16);
            CHECK(atOnce == imageOf(s, true, animated, 16));
            CHECK(*std::max_element(atOnce.begin(), atOnce.end()) > 0.5F);
        }
}

TEST_CASE("Singular values out of range are clamped at once as one by one", "[render][lanes]") {
    // Squeezed to a thousandth of a millionth: the distribution along y is wider than any range.
    Scene s = scene(plain(BsdfType::Conductor, 0.3F, 0.5F, 0.7F));
    DeformerKeys squeeze;
    squeeze.type = DeformerType::Stretch;
    squeeze.factor = Keyed<DVec3>(DVec3(1, 1e-9, 1));
    s.objects[0].deformers = {squeeze};
    CHECK(imageOf(s, false, true, 8) == imageOf(s, true, true, 8));
}

TEST_CASE("Every set of instructions gives the same lanes", "[render][lanes][batch]") {
    const auto type = GENERATE(BsdfType::Metal, BsdfType::Dielectric);
    const Scene s = scene(plain(type, 0.2F, 0.6F, 0.4F));
    const std::vector<PreparedMaterial> prepared = prepareMaterials(s, defaultPlan(s));
    const PlainMaterial material = plainMaterial(prepared[0]);
    REQUIRE(material.isPlain);
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
        lanes::view(*lanes, material, {1, 2, 3, 4, 5}, set);
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
