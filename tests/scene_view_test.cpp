#include "scene_fixtures.h"

using namespace taut;
using namespace taut::test;

TEST_CASE("placements", "[scene]") {
    Placement p;
    p.translation = Keyed<DVec3>(DVec3(1, 2, 3));
    p.rotation = Keyed<DVec3>(DVec3(radians(90), radians(90), 0)); // x first
    p.scale.keys = {{1, DVec3(2, 3, 4)}, {3, DVec3(4, 3, 4)}};
    // (0, 1, 0) -> scaled (0, 3, 0) -> about x (0, 0, 3) -> about y (3, 0, 0)
    CHECK(close(transformed(placementAt(p, 1), DVec3(0, 1, 0)), DVec3(4, 2, 3)));
    CHECK(close(transformed(placementAt(p, 2), DVec3(1, 0, 0)), DVec3(1, 2, 0)));
    CHECK(close(placementRest(p) * DVec3(1, 0, 0), DVec3(0, 0, -2)));
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, "[[mesh]]\nfile = \"panel.obj\"\nup = \"y\"\nscale = [[1, 1], [2, [1, 2, 1]]]\n");
    const Placement &up = scene.objects.at(0).placement;
    CHECK(close(transformed(placementAt(up, 1), DVec3(1, 2, 3)), DVec3(1, -3, 2)));
    CHECK(close(transformed(placementAt(up, 2), DVec3(1, 2, 3)), DVec3(1, -6, 2)));
}

TEST_CASE("the camera's frame", "[scene]") {
    Camera camera;
    camera.position = Keyed<DVec3>(DVec3(0, -3, 0));
    CameraState state = cameraAtFrame(camera, 1, 24);
    CHECK(close(DVec3(state.worldFromCamera[0]), DVec3(1, 0, 0)));
    CHECK(close(DVec3(state.worldFromCamera[1]), DVec3(0, 0, 1)));
    CHECK(close(-DVec3(state.worldFromCamera[2]), DVec3(0, 1, 0)));
    CHECK(state.focusDistance == Approx(3));
    for (const DVec3 &position : {DVec3(0, 0, 5), DVec3(0, 0, -5), DVec3(0), DVec3(1, 2, 3)}) { // also along up, and nowhere
        camera.position = Keyed<DVec3>(position);
        const DMat3 axes(cameraAtFrame(camera, 1, 24).worldFromCamera);
        CHECK(glm::determinant(axes) == Approx(1));
        const DMat3 identity = glm::transpose(axes) * axes;
        for (int i = 0; i < 3; ++i) CHECK(close(identity[i], DMat3(1)[i], 1e-9));
    }
}

TEST_CASE("a framed camera sees everything", "[scene]") {
    const std::string folder = sceneFolder("scene");
    for (const char *size : {"width = 300\nheight = 100", "width = 100\nheight = 300"}) {
        const Scene scene = loadText(
            folder, std::string("[render]\n") + size +
                        "\n[[mesh]]\nfile = \"panel.obj\"\ntranslate = [100, 0, 7]\n[[mesh]]\nfile = \"panel.obj\"\nscale = [1, 30, 1]\n");
        const double fill = fillOfView(scene);
        CHECK(fill < 1);
        CHECK(fill > 0.3);
        const CameraState camera = cameraAtFrame(scene.camera, 1, 24);
        CHECK(camera.worldFromCamera[2].y < 0); // from the front
        CHECK(camera.worldFromCamera[2].z > 0); // from above
    }
    const Scene narrow = loadText(folder, "[camera]\nfov_deg = 10\n[[mesh]]\nfile = \"panel.obj\"\n");
    CHECK(narrow.camera.fovY.first() == Approx(radians(10)));
    CHECK(fillOfView(narrow) < 1);
    CHECK(fillOfView(narrow) > 0.3);
}

TEST_CASE("a numbered sequence", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, "[[mesh]]\nfile = \"cloth.####.obj\"\n");
    const Object &object = scene.objects.at(0);
    REQUIRE(object.points);
    CHECK(object.name == "cloth");
    CHECK(object.mesh->positions.at(0).z == 1);
    // Frames 1, 2 and 5 are there: z is the number of the frame.
    for (const double frame : {-3.0, 1.0, 2.0, 3.5, 5.0, 9.0})
        CHECK(worldPositions(scene, object, frame).at(0).z == Approx(glm::clamp(frame, 1.0, 5.0)));
    if (const auto real = asset("seq/kick_obj/kick.0000.obj")) {
        const std::string pattern = real->substr(0, real->size() - 8) + "####.obj";
        const Scene kick = loadText(folder, "[[mesh]]\nfile = \"" + pattern + "\"\n");
        CHECK(kick.objects.at(0).points);
        CHECK(kick.objects[0].name == "kick");
    }
}

TEST_CASE("a bare mesh is a scene", "[scene]") {
    const std::string folder = sceneFolder("scene");
    Warnings warnings;
    const Scene scene = loadScene(
        folder + "/panel.obj", {"render.width=64", "mesh.0.subdivision=1", "material.red.color=[1,0,0]", "mesh.0.material=red"}, warnings);
    CHECK(scene.render.width == 64);
    CHECK(scene.objects.at(0).subdivision.level == 1);
    CHECK(scene.materials.at(scene.objects[0].materials.at(0)).color.value == Vec3(1, 0, 0));
    CHECK(scene.environment);
    CHECK(fillOfView(scene) < 1);
    CHECK(warnings.lines.empty());
    CHECK(loadScene(folder + "/panel.obj", {}, warnings).materials.at(0).type == BsdfType::Metal);
}
