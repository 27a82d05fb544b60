/// Renders a sheared sheet through the shared library; 0 where it is seen, and an error of the library is caught as what it is.

#include "taut/base/error.h"
#include "taut/mesh/shapes.h"
#include "taut/render/frame_render.h"

#include <algorithm>
#include <iostream>

int main() {
    taut::Scene scene;
    scene.render.width = scene.render.height = 16;
    scene.camera.position = taut::DVec3(0, -1, 2);
    scene.environment = taut::studioEnvironment();
    scene.materials.emplace_back();
    scene.materials[0].type = taut::BsdfType::Conductor;
    scene.objects.emplace_back();
    scene.objects[0].mesh = std::make_shared<const taut::Mesh>(taut::makeGrid(8, 8, 2));
    bool caught = false;
    try {
        taut::RenderScene broken(scene, false); // an object without a material
    } catch (const taut::InputError &) {
        caught = true;
    }
    scene.objects[0].materials = {0};
    taut::RenderScene ready(std::move(scene), false);
    ready.setFrame(1);
    const std::vector<float> values = taut::renderFrame(ready, {.spp = 4}).film.resolve();
    const bool seen = *std::max_element(values.begin(), values.end()) > 0;
    std::cout << (caught && seen ? "shared: all right" : "shared: WRONG") << std::endl;
    return caught && seen ? 0 : 1;
}
