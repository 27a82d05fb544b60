#include "study/scenes/error_scenes.h"

#include "study/scenes/bench_scenes.h"
#include "study/scenes/denoise_scenes.h"
#include "study/scenes/plan_scenes.h"
#include "study/scenes/scenes.h"

#include "taut/base/error.h"
#include "taut/scene/load_scene.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace taut::chart {

namespace {

namespace fs = std::filesystem;

Scene atFrame(Scene scene, double frame, int width) {
    scene.render.frames = {static_cast<int>(frame)};
    scene.render.boxFilter = false; // as a scene has it that says nothing
    return atWidth(std::move(scene), width);
}

/// Sixty-four small lamps over a brushed torus.
Scene manyLights() {
    Material grey;
    grey.color.value = Vec3(0.5F);
    Scene scene = torusScene(makeTorus(64, 32, 1, 0.4F), -0.4, {brushedMetal(0.1F, 0.3F), grey}, 96, 6);
    for (int i = 0; i < 64; ++i) {
        const double x = i % 8 - 3.5;
        const double y = i / 8 - 3.5;
        scene.lights.push_back({Vec3(4 + static_cast<float>(i % 5)), SphereLight{DVec3(x, y, 2 + 0.2 * (i % 3)), 0.1}});
    }
    return scene;
}

/// A thousand twisted bars, most of them smaller than a pixel.
Scene farCrowd() {
    Material grey;
    grey.color.value = Vec3(0.5F);
    Scene scene = torusScene(makeTorus(16, 8, 0.2F, 0.08F), -0.3, {brushedMetal(0.2F, 0.4F), grey}, 96, 4);
    const Object bar = scene.objects.front();
    scene.objects.erase(scene.objects.begin());
    for (int i = 0; i < 400; ++i) {
        Object copy = bar;
        copy.name += std::to_string(i);
        copy.placement.translation = DVec3(0.6 * (i % 20) - 6, 0.6 * (i / 20) - 2, 0.0);
        scene.objects.push_back(std::move(copy));
    }
    scene.lights = {lampAbove()};
    return scene;
}

/// A cage whose level is the plan's, twisted.
Scene planned(float alpha, double distance, int maxEvents) {
    Object torus = objectOf(makeTorus(16, 8, 0.7F, 0.3F));
    torus.planLevel = true;
    torus.subdivision.level = 3;
    torus.deformers = {deformer(DeformerType::Twist, ramp(0.6, 3), 2, 0)};
    Scene scene = studyScene(std::move(torus), brushedMetal(alpha, 1.5F * alpha), 96);
    scene.camera.position = DVec3(0, -distance, 0.4 * distance);
    scene.render.maxEvents = maxEvents;
    return scene;
}

Scene blurred(Scene scene, double shutter) {
    scene.render.shutter = shutter;
    return scene;
}

} // namespace

std::vector<ErrorScene> errorScenes(int width) {
    std::vector<ErrorScene> scenes;
    const auto add = [&](const std::string &name, double frame, const std::function<Scene()> &make) {
        scenes.push_back({name, frame, [=] { return atFrame(make(), frame, width); }});
    };
    for (const BenchScene &bench : benchScenes()) add(bench.name, bench.frames, bench.make);
    for (const PlanScene &plan : planScenes(width)) add(plan.name, plan.frame, [scene = plan.scene] { return scene; });
    for (const DenoiseScene &demo : denoiseScenes())
        if (demo.name == "panel" || demo.name == "body" || demo.name == "plates" || demo.name == "rubber")
            add(demo.name, demo.frame, demo.make);
    add("many lights", 1, manyLights);
    add("far crowd", 1, farCrowd);
    add("planned cage, near and smooth", 3, [] { return planned(0.02F, 1.9, 8); });
    add("planned cage, far and rough", 3, [] { return planned(0.4F, 9, 8); });
    for (const PlanScene &plan : planScenes(width))
        if (plan.name == "sheared torus" || plan.name == "twisted plate")
            add(plan.name + ", motion blur", plan.frame, [scene = plan.scene] { return blurred(scene, 0.5); });
    std::istringstream files(std::getenv("TAUT_CHARACTERS") != nullptr ? std::getenv("TAUT_CHARACTERS") : "");
    for (std::string file; std::getline(files, file, ':');)
        add(fs::path(file).stem().string(), 1, [path = fs::absolute(file).string()] {
            Warnings ignored;
            return loadScene(path, {}, ignored);
        });
    return scenes;
}

} // namespace taut::chart
