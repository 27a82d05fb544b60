/// Facets of maps as the renderer has them at a hit: the worked values in the channels beside the picture, and a coat's own map.

#include "catch.h"
#include "render_fixtures.h"

#include "study/scenes/relief.h"

using namespace taut;
using namespace taut::test;
using namespace taut::chart;

namespace {

/// A map of one texel: this slope everywhere.
Texture constantNormals(const Vec2 &slope) {
    const Vec3 n = 0.5F * glm::normalize(Vec3(slope, 1)) + Vec3(0.5F);
    Texture texture;
    texture.name = "constant";
    texture.texels = {n.x, n.y, n.z};
    return texture;
}

/// A plate under deformers that carry the space above it along.
Scene plate(const std::vector<DeformerKeys> &deformers, const Vec2 &slope) {
    Scene scene = reliefScene(makeGrid(4, 4, 2), deformers, 0.1F, 8);
    scene.textures = {constantNormals(slope)};
    return scene;
}

} // namespace

TEST_CASE("Channels beside the picture tell the normal, the lean and the alphas that were worked out for facets", "[mapped_facet]") {
    struct Row {
        std::vector<DeformerKeys> deformers;
        Vec2 slope, alpha, carried;
        double lean, greatest, least;
    };
    const std::vector<Row> rows{
        {{stretchDeformer(DVec3(2, 1, 1))}, {.5F, 0}, {.1F, .1F}, {.25F, 0}, .6, .1084652, .0588235},
        {{stretchDeformer(DVec3(2, 1, .5))}, {.5F, 0}, {.1F, .1F}, {.125F, 0}, 1.5, .0554700, .0307692},
        {{shearDeformer(1)}, {.3F, -.4F}, {.1F, .3F}, {.3F, -.7F}, std::hypot(.3493205, .2471421), .2707013, .0779849},
        {{shearDeformer(1), shearDeformer(.2, 0, 2)},
         {.3F, -.4F},
         {.1F, .3F},
         {.3191489F, -.7446809F},
         std::hypot(.1560674, .2675568),
         .2823243,
         .0838696},
    };
    for (const Row &row : rows) {
        Scene scene = plate(row.deformers, row.slope);
        scene.materials[0].alphaX.value = row.alpha.x;
        scene.materials[0].alphaY.value = row.alpha.y;
        scene.materials[0].slopes = {SlopeMap::Kind::Normal, 0, 1};
        const std::vector<float> image = renderImage(scene, 1, 4, {"facet_normal", "lean", "alpha"});
        const float *middle = &image[(4 * 8 + 4) * 12];
        INFO("carried to " << row.carried.x << " " << row.carried.y);
        CHECK(glm::length(Vec2(middle[4], middle[5]) / middle[6] - row.carried) < 1e-5F);
        CHECK(std::hypot(middle[7], middle[8]) == Approx(row.lean).margin(1e-5));
        CHECK(middle[9] == Approx(row.greatest).margin(1e-5));
        CHECK(middle[10] == Approx(row.least).margin(1e-5));
    }
}

TEST_CASE("A clear coat follows its own map under a deformation, and no other", "[mapped_facet]") {
    // The sun where a facet of that slope mirrors it into the camera, straight above.
    const auto brightness = [](const Vec2 &sunSlope, bool coatMapped, bool baseMapped) {
        Scene scene = plate({stretchDeformer(DVec3(2, 1, 1))}, {0.3F, 0.1F});
        Material &material = scene.materials[0];
        material.type = BsdfType::MetallicRoughness;
        material.color.value = Vec3(0);
        material.specular.value = 0;
        material.clearcoat.value = 1;
        material.clearcoatRoughness.value = 0.3F;
        if (coatMapped) material.coatSlopes = {SlopeMap::Kind::Normal, 0, 1};
        if (baseMapped) material.slopes = {SlopeMap::Kind::Normal, 0, 1};
        const DVec3 n = glm::normalize(DVec3(DVec2(sunSlope), 1));
        scene.environment = constantEnvironment(Vec3(0));
        scene.lights = {{Vec3(1), DirectionalLight{DVec3(0, 0, 1) - 2 * n.z * n}}};
        return renderImage(scene, 1, 4)[(4 * 8 + 4) * 4];
    };
    const float lit = brightness({0.15F, 0.1F}, true, false); // s' = A^-T s
    CHECK(lit > 0.1F);
    CHECK(brightness({0.3F, 0.1F}, true, false) < 0.1F * lit); // where the map has it at rest
    CHECK(brightness({0.15F, 0.1F}, false, false) < 0.2F * lit);
    CHECK(brightness({0.15F, 0.1F}, false, true) == Approx(brightness({0.15F, 0.1F}, false, false)).epsilon(1e-3));
}
