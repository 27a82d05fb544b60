/// A program that uses GLM in its own way, before it includes us: its macros stay its own, and so do our types.

#define GLM_FORCE_DEFAULT_ALIGNED_GENTYPES
#define GLM_FORCE_DEPTH_ZERO_TO_ONE
#include "catch.h"

#include <glm/glm.hpp>

#include "taut/export/gloss_export.h"
#include "taut/render/image_file.h"
#include "taut/render/frame_render.h"
#include "taut/scene/load_scene.h"

#if defined(GLM_ENABLE_EXPERIMENTAL) || defined(GLM_FORCE_SILENT_WARNINGS)
#error "a macro of GLM that its user has not defined"
#endif

using namespace taut;

TEST_CASE("GLM's macros in a program change no type of ours, and ours change none there", "[consumer]") {
    STATIC_REQUIRE(sizeof(Vec3) == 12);
    STATIC_REQUIRE(std::is_same_v<Mat3, glm::mat<3, 3, float, glm::packed_highp>>);
    Bounds bounds;
    bounds.add(Vec3(1, 2, 3));
    CHECK(boundsOf({Vec3(1, 2, 3)}).lower == bounds.lower);
    const CameraState camera = cameraAtFrame(Camera{}, 1, 24);
    CHECK(camera.worldFromCamera[3] == DVec4(0, -3, 0, 1));
}
