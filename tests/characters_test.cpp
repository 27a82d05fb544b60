/// Real skinned and morphed characters over 24 frames: they move, they stay finite, and nothing untrue is said about them.

#include "assets.h"
#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/frame_render.h"
#include "taut/scene/load_scene.h"

using namespace taut;
using namespace taut::test;

TEST_CASE("glTF characters render over 24 frames", "[characters]") {
    for (const char *file : {"anim/khronos/Fox.glb", "anim/khronos/CesiumMan.glb", "anim/khronos/RiggedFigure.glb", "anim/khronos/AnimatedMorphSphere.glb",
                             "anim/khronos/AnimatedMorphCube.glb", "anim/kaykit/Knight.glb", "anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf"}) {
        const auto path = test::asset(file);
        if (!path) continue;
        INFO(file);
        Warnings warnings;
        const Scene scene = loadScene(*path, {"render.width=64", "render.height=48", "environment.preset=\"studio\"", "environment.camera_visible=false"}, warnings);
        for (const std::string &line : warnings.lines) std::cout << file << ": " << line << std::endl;
        RenderScene ready(scene, true);
        StageTimes times;
        std::vector<Vec3> first;
        bool moved = false;
        for (int frame = 1; frame <= 24; ++frame) {
            ready.setFrame(frame, times);
            FrameOptions options;
            options.spp = 4;
            options.seed = frameSeed(0, frame, false);
            const FrameResult result = renderFrame(ready, options);
            const std::vector<float> image = result.film.resolve();
            CHECK(result.counts.notFinite == 0);
            CHECK(std::all_of(image.begin(), image.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
            double covered = 0;
            for (std::size_t p = 3; p < image.size(); p += 4) covered += static_cast<double>(image[p]);
            CHECK(covered > 20);
            const std::vector<Vec3> &positions = ready.objects()[0].steps[0].positions;
            if (first.empty()) first = positions;
            moved = moved || !std::equal(positions.begin(), positions.end() - 1, first.begin());
            for (const RenderObject &object : ready.objects())
                for (const Vec3 &n : object.steps[0].normals) REQUIRE(glm::length(n) == Approx(1).epsilon(1e-4));
        }
        CHECK(moved);
    }
}

TEST_CASE("A character's constant armature scale changes no alpha", "[characters][rest]") {
    // Real rigs carry scales of 100 or 0.01 between bind pose and skeleton; taken for stretch, every alpha would change by that.
    for (const char *file : {"anim/khronos/Fox.glb", "anim/khronos/CesiumMan.glb", "anim/khronos/RiggedFigure.glb", "anim/khronos/RiggedSimple.glb", "anim/kaykit/Knight.glb",
                             "anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf"}) {
        const auto path = test::asset(file);
        if (!path) continue;
        INFO(file);
        Warnings warnings;
        const Scene scene = loadScene(*path, {}, warnings);
        // Over a whole character the typical stretch of a pose is near one.
        std::vector<float> stretches;
        for (const Object &object : scene.objects) {
            const DeformedVertices surface = surfaceOf(object, 1);
            for (std::size_t v = 0; v < surface.ds.size(); ++v)
                stretches.push_back(std::sqrt(glm::length(glm::cross(surface.ds[v], surface.dt[v]))));
        }
        std::nth_element(stretches.begin(), stretches.begin() + static_cast<std::ptrdiff_t>(stretches.size() / 2), stretches.end());
        CHECK(stretches[stretches.size() / 2] == Approx(1).epsilon(0.1));
        // And scaling everything by a constant changes no stretch at all.
        const Scene scaled = loadScene(*path, {"mesh.0.scale=100"}, warnings);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            const DeformedVertices a = surfaceOf(scene.objects[i], 1);
            const DeformedVertices b = surfaceOf(scaled.objects[i], 1);
            for (std::size_t v = 0; v < a.ds.size(); ++v) {
                const float size = std::fmax(glm::length(a.ds[v]), glm::length(a.dt[v]));
                REQUIRE(glm::length(b.ds[v]) == Approx(glm::length(a.ds[v])).margin(1e-3F * size));
                REQUIRE(glm::length(glm::cross(b.ds[v], b.dt[v])) == Approx(glm::length(glm::cross(a.ds[v], a.dt[v]))).margin(1e-3F * size * size));
            }
        }
    }
}
