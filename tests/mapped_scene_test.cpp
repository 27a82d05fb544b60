/// Keys of mesostructure and roughening in scene files, and what is said of wrong ones.

#include "scene_fixtures.h"

#include "taut/scene/slope_texture.h"

using namespace taut;
using namespace taut::test;

TEST_CASE("Maps of normals and heights, roughening and presets arrive in a material", "[mapped_scene]") {
    const std::string folder = sceneFolder("mapped_scene");
    const Scene scene = loadText(folder, R"(
[material.a]
type = "conductor"
normal = { file = "brushed.png", scale = 0.5, tile = [3, 2] }
roughening = 0.4
yield = 0.01
detail = "moments"
facets = "bend"
[material.b]
bump = { file = "brushed.png", channel = "g", scale = 0.1 }
[material.c]
type = "metallic_roughness"
height = { file = "brushed.png", scale = 0.002 }
clearcoat = 1
clearcoat_normal = { file = "brushed.png" }
[material.d]
preset = "annealed aluminium"
alpha = 0.3
[material.e]
preset = "rubber"
[[mesh]]
file = "panel.obj"
material = "b"
[[mesh]]
file = "panel.obj"
material = "d"
)");
    const auto named = [&](const std::string &name) {
        return *std::find_if(scene.materials.begin(), scene.materials.end(), [&](const Material &m) { return m.name == name; });
    };
    const Material a = named("a");
    CHECK(a.slopes.kind == SlopeMap::Kind::Normal);
    CHECK(a.slopes.scale == 0.5F);
    CHECK(scene.textures[a.slopes.texture].sampler.moved);
    CHECK(a.roughening == 0.4F);
    CHECK(a.yield == 0.01F);
    CHECK(a.detail == TextureDetail::Moments);
    CHECK(a.facets == FacetModel::Bends);
    CHECK(named("b").slopes.kind == SlopeMap::Kind::Bump);
    CHECK(named("b").type == BsdfType::Diffuse);
    CHECK(named("c").slopes.kind == SlopeMap::Kind::Height);
    CHECK(named("c").coatSlopes.isGiven());
    CHECK(named("d").type == BsdfType::Metal);
    CHECK(named("d").alphaX.value == 0.3F);
    CHECK(named("d").roughening > 0);
    CHECK(named("e").poisson == 0.5F);
    CHECK(named("e").roughening == 0);
    CHECK(scene.objects.at(0).mapTangents);
    CHECK(!scene.objects.at(1).mapTangents);
}

TEST_CASE("Wrong keys of mesostructure are said where they stand", "[mapped_scene]") {
    const std::string folder = sceneFolder("mapped_scene_errors");
    const auto error = [&](const std::string &line) { return errorOfText(folder, "[material.a]\ntype = \"conductor\"\n" + line + "\n"); };
    CHECK(says(error("normal = 0.5"), "scene.toml:3:", {"{ file = "}));
    CHECK(says(error("normal = { file = \"gone.png\" }"), "scene.toml:3:", {"gone.png"}));
    CHECK(says(error("normal = { file = \"brushed.png\", channel = \"g\" }"), "scene.toml:3:", {"channel"}));
    CHECK(says(error("normal = { file = \"brushed.png\", tile = 0 }"), "scene.toml:3:", {"above 0"}));
    CHECK(says(error("normal = { file = \"brushed.png\", scale = [1, 2, 3] }"), "scene.toml:3:", {"one number"}));
    CHECK(says(error("normal = { file = \"brushed.png\" }\nbump = { file = \"brushed.png\" }"), "scene.toml:", {"normal", "bump"}));
    CHECK(says(error("preset = \"ruber\""), "scene.toml:3:", {"rubber"}));
    CHECK(says(error("facets = \"leans\""), "scene.toml:3:", {"lean"}));
    CHECK(says(error("detail = \"far\""), "scene.toml:3:", {"moments"}));
    CHECK(says(error("roughening = -1"), "scene.toml:3:", {"at least 0"}));
    CHECK(says(errorOfText(folder, "[material.a]\nroughening = 1\n"), "scene.toml:2:", {"roughening"}));
}

TEST_CASE("Heights become slopes by their differences, across edges that repeat or stop", "[mapped_scene]") {
    Texture ramp;
    ramp.width = 4;
    ramp.height = 2;
    ramp.channels = 1;
    ramp.texels = {0, 1, 2, 3, 0, 1, 2, 3}; // h = 4 u - 1/2: slope -4 per width
    ramp.sampler.wrapU = ramp.sampler.wrapV = TextureWrap::Clamp;
    const Texture bump = slopesFromHeights(ramp, 0, SlopeMap::Kind::Bump);
    CHECK(bump.channels == 3);
    CHECK(bump.texels[3] == -4);
    CHECK(bump.texels[4] == 0);
    CHECK(bump.texels[0] == -2); // half of the difference is beyond the edge, where nothing rises
    ramp.sampler.wrapU = TextureWrap::Repeat;
    CHECK(slopesFromHeights(ramp, 0, SlopeMap::Kind::Bump).texels[0] == 4); // from 3 over 0 to 1
    // Rows stand from the top: rising upwards by 1 from row to row.
    Texture column;
    column.width = 1;
    column.height = 4;
    column.channels = 1;
    column.texels = {3, 2, 1, 0};
    column.sampler.wrapU = column.sampler.wrapV = TextureWrap::Clamp;
    CHECK(slopesFromHeights(column, 0, SlopeMap::Kind::Height).texels[4] == -4);
    CHECK(slopesFromHeights(column, 0, SlopeMap::Kind::Bump).texels[4] == -1);
    Texture normals;
    normals.width = 2;
    normals.texels = {0.5F, 0.5F, 1, 1, 0.5F, 0.5F};
    CHECK(countTooSteep(normals) == 1);
}
