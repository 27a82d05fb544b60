/// Pilots: what they measure against what is known, and that the plan made by them is sharp, and the same wherever it is made.

#include "catch.h"
#include "render_fixtures.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/plan_scenes.h"
#include "study/scenes/scenes.h"

#include "taut/pilot/foreseen_time.h"
#include "taut/pilot/pilot_picture.h"
#include "taut/pilot/plan_by_pilots.h"

#include <tbb/global_control.h>

#include <set>

using namespace taut;
using namespace taut::chart;
using namespace taut::test;

namespace {

/// A cage whose level is the plan's, twisted.
Scene cage(float alpha, double distance, int size) {
    Object torus = chart::objectOf(makeTorus(16, 8, 0.7F, 0.3F));
    torus.planLevel = true;
    torus.subdivision.level = 3;
    torus.deformers = {chart::deformer(DeformerType::Twist, chart::ramp(0.6, 3), 2, 0)};
    Scene scene = chart::studyScene(std::move(torus), chart::brushedMetal(alpha, 1.5F * alpha), size);
    scene.camera.position = DVec3(0, -distance, 0.4 * distance);
    scene.render.frames = {1, 2, 3};
    return scene;
}

PlanOptions withTolerance(float tolerance) {
    PlanOptions options;
    options.tolerance = tolerance;
    return options;
}

const PilotFinding *findingOf(const ScenePlan &plan, const ChoiceValue &value) {
    const auto found = std::find_if(plan.pilots.begin(), plan.pilots.end(), [&](const PilotFinding &f) { return f.value == value; });
    return found == plan.pilots.end() ? nullptr : &*found;
}

/// A wall that fills the picture, under even light: its radiance is its albedo.
Scene wall(float albedo, int size) {
    Material material;
    material.color.value = Vec3(albedo);
    Scene scene = smallScene(makeObject(makeGrid(4, 4, 8)), material, size);
    scene.camera.position = DVec3(0, 0, 2);
    scene.camera.lookAt = DVec3(0);
    scene.camera.up = DVec3(0, 1, 0);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    return scene;
}

} // namespace

TEST_CASE("pilots: windows lie in the frame, apart, at most one in each part of it", "[pilot]") {
    for (const auto &[width, height] : {std::pair(640, 360), std::pair(97, 61), std::pair(8, 8), std::pair(5, 3)}) {
        const std::vector<Window> windows = pilotWindows(width, height, 49, 7);
        INFO(width << " x " << height << ": " << windows.size());
        std::set<std::pair<int, int>> places;
        for (const Window &w : windows) {
            CHECK(w.x0 % kPilotWindow == 0);
            CHECK(w.y0 % kPilotWindow == 0);
            CHECK(Window{0, 0, width, height}.contains(w));
            CHECK(!w.empty());
            places.insert({w.x0, w.y0});
        }
        CHECK(places.size() == windows.size());
        CHECK(windows == pilotWindows(width, height, 49, 7));
    }
    CHECK(pilotWindows(640, 360, 49, 7).size() > 30);
    CHECK(pilotWindows(640, 360, 49, 7).size() < 70);
    CHECK(pilotWindows(5, 3, 49, 7).size() == 1);
}

TEST_CASE("pilots: the difference of two walls is that of their albedos, and noise is not taken for it", "[pilot]") {
    const std::vector<Window> windows = pilotWindows(96, 96, 25, 1);
    const auto pilot = [&](float albedo) {
        RenderScene ready(wall(albedo, 96), false);
        ready.setFrame(1);
        return renderPilot(ready, windows, {4, 1, 3});
    };
    const PilotPicture half = pilot(0.5F);
    const Estimate square = squaredDifference(pilot(0.6F), half);
    CHECK(std::sqrt(square.value) == Approx(0.2).epsilon(1e-3));
    CHECK(square.spread < 1e-3);
    CHECK(squaredDifference(half, half).value == 0);
    CHECK(squaredNoise(half).value < 1e-6); // the sampler of a wall under even light has none
}

TEST_CASE("pilots: the noise is that of whole pictures", "[pilot]") {
    Scene scene = chart::studyScene(makeObject(makeTorus(48, 24, 0.7F, 0.3F)), chart::brushedMetal(0.1F, 0.3F), 128);
    RenderScene ready(scene, false);
    ready.setFrame(1);
    const Estimate noise = squaredNoise(renderPilot(ready, pilotWindows(128, 128, 100, 1), {4, scene.render.maxEvents, 3}));
    const std::vector<std::vector<float>> images{renderReady(ready, 4, 1).values, renderReady(ready, 4, 2).values,
                                                 renderReady(ready, 4, 3).values};
    const double whole = relativeVariance(images);
    INFO(noise.value << " +- " << noise.spread << ", whole " << whole);
    CHECK(std::fabs(noise.value - whole) < 4 * noise.spread);
    CHECK(noise.spread < 0.5 * noise.value);
}

TEST_CASE("pilots: predicted errors of levels are what whole pictures show", "[pilot]") {
    constexpr int kSize = 160;
    const Scene scene = cage(0.3F, 4, kSize);
    const PlannedScene planned = planByPilots(scene, withTolerance(0.03F));
    REQUIRE(planned.plan.pilots.size() > 2);
    const auto pictures = [&](int level) {
        ScenePlan plan = fullPlan(scene);
        plan.meshes[0].subdivisionLevel = level;
        return std::array{renderImage(scene, plan, 3, 64, 1).values, renderImage(scene, plan, 3, 64, 2).values};
    };
    const auto full = pictures(fullPlan(scene).meshes[0].subdivisionLevel);
    const ScenePlan analysed = makePlan(scene, 0.03F);
    const auto predicted = [](const ScenePlan &plan, int level) {
        for (const Choice &choice : plan.meshes[0].questions.front().choices)
            if (choice.value == ChoiceValue(SubdivisionLevel{level})) return static_cast<double>(choice.error);
        return -1.0;
    };
    for (const int level : {1, 2}) {
        const auto coarse = pictures(level); // without the noise of either
        const double error = expectedDifference(coarse[0], coarse[1], full[0], full[1]);
        const PilotFinding *found = findingOf(planned.plan, SubdivisionLevel{level});
        REQUIRE(found != nullptr);
        const double square = sqr(static_cast<double>(found->error));
        const double spread = sqr(static_cast<double>(found->error + found->spread)) - square; // standard error of the square
        INFO("level " << level << ": true " << error << ", by pilots " << found->error << " +" << found->spread << ", predicted "
                      << predicted(planned.plan, level) << ", by analysis " << predicted(analysed, level));
        CHECK(std::fabs(square - sqr(error)) < 3 * spread);
        CHECK(spread < 30 * sqr(error)); // that tells something
        CHECK(predicted(planned.plan, level) > 0.5 * error);
        CHECK(predicted(planned.plan, level) < 0.2 * predicted(analysed, level));
    }
    // Sharper than bounds: it takes fewer faces, and the error stays below the tolerance.
    CHECK(planned.plan.meshes[0].subdivisionLevel < analysed.meshes[0].subdivisionLevel);
    CHECK(relativeRms(pictures(planned.plan.meshes[0].subdivisionLevel)[0], full[0]) < 0.03);
}

TEST_CASE("pilots: the plan is the same for any number of threads, and none are made where there is no time", "[pilot]") {
    const Scene scene = cage(0.2F, 4, 128);
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return planByPilots(scene, withTolerance(0.02F)).plan;
    };
    const ScenePlan one = onThreads(1);
    const ScenePlan two = onThreads(2);
    REQUIRE(one.pilots.size() == two.pilots.size());
    REQUIRE(!one.pilots.empty());
    for (std::size_t i = 0; i < one.pilots.size(); ++i) {
        CHECK(one.pilots[i].error == two.pilots[i].error);
        CHECK(one.pilots[i].noise == two.pilots[i].noise);
        CHECK(one.pilots[i].rays == two.pilots[i].rays);
    }
    CHECK(sameModels(one, two));
    Scene small = cage(0.2F, 4, 16);
    small.objects[0].planLevel = false; // else the levels that pilots save are worth their time
    CHECK(planByPilots(small, withTolerance(0.02F)).plan.pilots.empty());
}

TEST_CASE("pilots: what needs everything gets everything, and the plan says why", "[pilot]") {
    // A sheared cage, smooth, close up.
    Scene scene = cage(0.01F, 1.9, 160);
    scene.objects[0].deformers = {chart::deformer(DeformerType::Shear, chart::ramp(0.8, 3), 0, 2)};
    const ScenePlan plan = planByPilots(scene, withTolerance(1e-3F)).plan;
    const ScenePlan full = fullPlan(scene);
    CHECK(plan.meshes[0].subdivisionLevel == full.meshes[0].subdivisionLevel);
    CHECK(plan.meshes[0].stretch == StretchModel::PerVertex);
    REQUIRE(findingOf(plan, SubdivisionLevel{2}) != nullptr);
    CHECK(findingOf(plan, SubdivisionLevel{2})->error > 0.01F);
    const Question &level = plan.meshes[0].questions.front();
    CHECK(level.taken > 0);
    CHECK(level.choices[level.taken - 1].error > 1e-3F); // of the next cheaper one
}

TEST_CASE("pilots: a straight way needs two times within the shutter, a turn as many as it shows", "[pilot][motion]") {
    constexpr float kError = 0.01F;
    Scene scene = cage(0.3F, 5, 160);
    scene.objects[0].planLevel = false;
    scene.objects[0].subdivision.level = 0;
    scene.render.frames = {3};
    scene.render.shutter = 1;
    scene.render.motionSteps = 9;
    const auto errorOf = [&](int steps) { // of whole pictures, without their noise
        const auto pictures = [&](int times) {
            ScenePlan plan = fullPlan(scene);
            plan.motionSteps = times;
            return std::array{renderImage(scene, plan, 3, 64, 1).values, renderImage(scene, plan, 3, 64, 2).values};
        };
        const auto full = pictures(0);
        const auto few = pictures(steps);
        return expectedDifference(few[0], few[1], full[0], full[1]);
    };
    const auto planOf = [&](float error) {
        PlanOptions options;
        options.error = error;
        return planByPilots(scene, options).plan;
    };
    SECTION("straight") {
        scene.render.width = scene.render.height = 240; // or there is no time for pilots
        scene.objects[0].deformers = {chart::deformer(DeformerType::Shear, chart::ramp(1.6, 6), 0, 2)};
        const ScenePlan plan = planOf(0.02F);
        REQUIRE(plan.motion);
        CHECK(plan.motionSteps == 2);
        CHECK(errorOf(2) < 2e-3);
    }
    SECTION("a turn") {
        scene.objects[0].deformers = {chart::deformer(DeformerType::Twist, chart::ramp(12, 6), 2, 0)};
        const ScenePlan plan = planOf(kError);
        REQUIRE(plan.motion);
        const PilotFinding *found = findingOf(plan, MotionSteps{2});
        REQUIRE(found != nullptr);
        const double error = errorOf(2);
        INFO("true " << error << ", by pilots " << found->error << " +" << found->spread << ", taken " << plan.motionSteps);
        CHECK(error > 0.02); // it is much
        CHECK(static_cast<double>(found->error) > 0.5 * error);
        CHECK(static_cast<double>(found->error) < 2 * error);
        CHECK(plan.motionSteps != 2);
        if (plan.motionSteps != 0) CHECK(errorOf(plan.motionSteps) < static_cast<double>(kError));
    }
}

TEST_CASE("pilots: an error is split into bias and noise", "[pilot]") {
    const Scene scene = cage(0.3F, 6, 160);
    for (const float error : {0.1F, 0.02F}) {
        PlanOptions options;
        options.error = error;
        const ScenePlan plan = planByPilots(scene, options).plan;
        REQUIRE(plan.budget);
        INFO(error << ": bias " << plan.budget->bias << ", noise " << plan.budget->noise);
        CHECK(plan.budget->error == error);
        CHECK(std::hypot(plan.budget->bias, plan.budget->noise) <= error);
        CHECK(plan.budget->noise > 0.2F * error);
        CHECK(plan.budget->bias >= 0);
    }
}

TEST_CASE("pilots: frames of one plan do not jump", "[pilot]") {
    constexpr float kError = 0.05F;
    Scene scene = cage(0.3F, 5, 96);
    scene.objects[0].deformers[0].amount = chart::ramp(0.6, 24);
    scene.render.frames.clear();
    for (int frame = 1; frame <= 24; ++frame) scene.render.frames.push_back(frame);
    PlanOptions options;
    options.error = kError;
    const ScenePlan plan = planByPilots(scene, options).plan;
    CHECK(!sameModels(plan, fullPlan(scene))); // it saves something
    std::vector<float> plannedBefore;
    std::vector<float> fullBefore;
    for (const int frame : {10, 11, 12, 13}) { // the random numbers are the same: noise cancels
        const std::vector<float> planned = renderImage(scene, plan, frame, 32, 1).values;
        const std::vector<float> full = renderImage(scene, fullPlan(scene), frame, 32, 1).values;
        if (!fullBefore.empty()) {
            double jump = 0;
            double square = 0;
            for (std::size_t i = 0; i < full.size(); ++i) {
                jump += sqr(static_cast<double>(planned[i] - plannedBefore[i]) - static_cast<double>(full[i] - fullBefore[i]));
                square += sqr(static_cast<double>(full[i]));
            }
            INFO("frame " << frame);
            CHECK(std::sqrt(jump / square) < static_cast<double>(kError));
        }
        plannedBefore = planned;
        fullBefore = full;
    }
}
