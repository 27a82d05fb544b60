/// What charts measure by: errors on limit surfaces, differences of images, plans that do the same.

#include "catch.h"

#include "study/measures/gradient_error.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/plan_scenes.h"
#include "study/scenes/scenes.h"

using namespace taut;
using namespace taut::chart;

TEST_CASE("The truth on limit surfaces tells exact derivatives from fits, and fits from faces", "[chart][gradient]") {
    for (const GradientCase &c : gradientCases()) {
        if (c.shape != Shape::Torus) continue;
        INFO(c.name);
        const auto error = [&](GradientEstimator estimator, int level) { return estimatorError(c, estimator, 12, level).rms; };
        CHECK(error(GradientEstimator::Limit, 2) < 1e-6);
        CHECK(error(GradientEstimator::Area, 2) > 1e-5);
        CHECK(error(GradientEstimator::Face, 2) > 4 * error(GradientEstimator::Area, 2));
        CHECK(observedOrder(error(GradientEstimator::Area, 2), error(GradientEstimator::Area, 3)) > 1.7);
    }
}

TEST_CASE("Errors of images are those of the formulas", "[chart]") {
    // Two pixels: one dark in both, which relMSE leaves out.
    const std::vector<float> reference{1, 2, 3, 0, 0, 0};
    const std::vector<float> image{1.5F, 2, 3, 0, 0, 0};
    CHECK(relativeRms(image, reference) == Approx(std::sqrt(0.25 / 14)));
    CHECK(relativeRms(reference, reference) == 0);
    CHECK(relativeMse(image, reference) == Approx(0.25 / (1 + 0.01 * 4) / 3));
    // A pixel that only the image lights counts.
    const std::vector<float> stray{1, 2, 3, 1, 0, 0};
    CHECK(relativeMse(stray, reference) == Approx(1 / 0.01 / 6));
}

TEST_CASE("Plans are told apart by what they do", "[chart][plan]") {
    const std::vector<PlanScene> scenes = planScenes(16);
    const Scene &scene = scenes[5].scene; // a sheared torus
    const ScenePlan full = fullPlan(scene);
    CHECK(sameModels(full, full));
    ScenePlan refitting = full;
    refitting.bvh = BvhKind::Refit;
    CHECK(sameModels(full, refitting));
    ScenePlan other = full;
    other.meshes[0].interpolation = GradientInterpolation::Face;
    CHECK_FALSE(sameModels(full, other));
    other = full;
    other.materials[0].model = Multiscatter::Off;
    CHECK_FALSE(sameModels(full, other));
    other = full;
    other.bearableWaste = 0;
    CHECK_FALSE(sameModels(full, other));
}

TEST_CASE("Samplers of reflections render the same image", "[chart][render]") {
    Object plate = objectOf([] {
        Mesh mesh;
        mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        mesh.cornerPositions = {0, 1, 2, 3};
        mesh.faceOffsets = {0, 4};
        return mesh;
    }());
    Scene scene = studyScene(std::move(plate), brushedMetal(0.6F, 0.2F), 24);
    scene.materials[0].multiscatter = Multiscatter::Off;
    const auto render = [&](float waste) {
        ScenePlan plan = defaultPlan(scene);
        plan.bearableWaste = waste;
        return renderImage(scene, plan, 1, 1024, 1).values;
    };
    const std::vector<float> caps = render(1);
    const std::vector<float> cone = render(0);
    CHECK(caps != cone);
    CHECK(relativeRms(caps, cone) < 0.02);
    CHECK(meanOf(caps) == Approx(meanOf(cone)).epsilon(2e-3));
}
