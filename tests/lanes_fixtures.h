#pragma once
/// Scenes whose hits are shaded at once, and pictures of them shaded either way.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/aov.h"
#include "taut/render/hit_lanes.h"

#include <tbb/global_control.h>

#include <algorithm>

namespace taut::test {

/// Every AOV there is.
inline std::vector<Aov> allAovs() {
    const std::array<std::string_view, 1> all{"all"};
    return aovsNamed(all, "test");
}

/// R, G, B, A and all AOVs.
inline Film filmOf(const Scene &scene, bool oneByOne, bool animated, int spp) {
    RenderScene ready(scene, animated);
    StageTimes times;
    ready.setFrame(2, times);
    FrameOptions options;
    options.spp = spp;
    options.seed = 3;
    options.oneByOne = oneByOne;
    options.aovs = allAovs();
    return renderFrame(ready, options).film;
}
inline std::vector<float> imageOf(const Scene &scene, bool oneByOne, bool animated, int spp) {
    return filmOf(scene, oneByOne, animated, spp).resolve();
}
inline float brightest(const Film &film) {
    float most = 0;
    for (const auto &colour : film.colours()) most = std::max({most, colour[0], colour[1], colour[2]});
    return most;
}

/// A sheared torus over a plate that reflects it, under a quad and a sky.
inline Scene laneScene(const Material &material) {
    Scene scene = smallScene(shearedTorus(40, 20), material);
    scene.materials.push_back(ggxMaterial(0.1F, 0.3F));
    scene.objects.push_back(makeObject(makeGrid(3, 3, 4), 1));
    scene.objects[1].placement.translation = Keyed<DVec3>(DVec3(0, 0, -0.4));
    scene.render.maxEvents = 6;
    return scene;
}

/// Rows of coloured squares; what a scene's textures are in the tests below.
inline Texture chequered(float from, float to, int size = 8) {
    std::vector<float> texels;
    for (int i = 0; i < size * size; ++i) {
        const float t = static_cast<float>((i * 7 + i / size * 3) % 11) / 10;
        texels.insert(texels.end(), {glm::mix(from, to, t), glm::mix(from, to, 1 - t), glm::mix(from, to, t * t)});
    }
    Texture texture;
    texture.name = "chequered";
    texture.width = texture.height = size;
    texture.texels = std::move(texels);
    return texture;
}

/// The scene with textures: shares, turns.
inline Scene textured(const Material &material) {
    Scene s = laneScene(material);
    s.textures = {chequered(0.02F, 0.98F), chequered(-2, 2)};
    return s;
}

/// Gives the torus of a scene an M of its own, another at each vertex, and puts the torus as it was beside it: their hits share lanes.
inline void storeGloss(Scene &s) {
    Object without = s.objects[0];
    without.placement.translation = Keyed<DVec3>(DVec3(0.5, 0.3, 0.2));
    Mesh mesh = *s.objects[0].mesh;
    mesh.cornerTangents = mesh.cornerPositions;
    mesh.tangents.clear();
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3 &p = mesh.positions[i];
        mesh.tangents.emplace_back(glm::normalize(Vec3(-p.y, p.x, 0)), 1.0F);
        mesh.storedM.emplace_back(2 + static_cast<float>(i % 7), 0.5F * static_cast<float>(i % 3), 3 + static_cast<float>(i % 5));
    }
    s.objects[0].mesh = std::make_shared<const Mesh>(std::move(mesh));
    s.objects.push_back(std::move(without));
}

inline Material plain(BsdfType type, float alphaX, float alphaY, float rotation) {
    Material m = ggxMaterial(alphaX, alphaY, rotation);
    m.type = type;
    m.color.value = Vec3(0.9F, 0.7F, 0.4F);
    m.conductorEta = Vec3(0.2F, 0.9F, 1.1F);
    m.conductorK = Vec3(3.9F, 2.5F, 2.2F);
    m.multiscatter = Multiscatter::Off;
    return m;
}

/// A scene whose first material goes by lanes.
struct LaneCase {
    std::string name;
    Scene scene;
};

/// Hits at once give the bits of hits one by one, animated and still, on all threads and on one; and there is something to see.
inline void checkPictures(const std::vector<LaneCase> &cases) {
    for (const LaneCase &c : cases)
        for (const bool animated : {false, true}) {
            INFO(c.name << (animated ? ", animated" : ""));
            REQUIRE(laneMaterial(prepareMaterials(c.scene, defaultPlan(c.scene))[0]).inLanes);
            const Film film = filmOf(c.scene, false, animated, 8);
            const std::vector<float> atOnce = film.resolve();
            CHECK(atOnce == imageOf(c.scene, true, animated, 8));
            CHECK(brightest(film) > 0.2F);
            const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
            CHECK(atOnce == imageOf(c.scene, false, animated, 8));
        }
}

} // namespace taut::test
