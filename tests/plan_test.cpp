/// Plans: what they choose, and that the image is as close to the full model as they say.

#include "render_fixtures.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/plan_scenes.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdio>

using namespace taut;
using namespace taut::chart;
using namespace taut::test;

namespace {

MeshPlan planned(const std::vector<PlanScene> &scenes, const std::string &name, float tolerance) {
    const auto found = std::find_if(scenes.begin(), scenes.end(), [&](const PlanScene &s) { return s.name == name; });
    REQUIRE(found != scenes.end());
    return makePlan(found->scene, tolerance).meshes.front();
}

} // namespace

TEST_CASE("Plans take what a field allows and no less", "[plan]") {
    const std::vector<PlanScene> scenes = planScenes(16);
    CHECK(planned(scenes, "rigid torus", 0.01F).stretch == StretchModel::Constant);
    CHECK(planned(scenes, "diffuse twisted torus", 0.01F).stretch == StretchModel::Constant);
    CHECK(planned(scenes, "uniform stretch of a plate", 0.01F).stretch == StretchModel::Uniform);
    CHECK(planned(scenes, "scaled sphere", 0.01F).stretch == StretchModel::Uniform);
    CHECK(planned(scenes, "barely stretched torus", 0.01F).stretch == StretchModel::Constant);
    CHECK(planned(scenes, "barely stretched torus", 0.0001F).stretch == StretchModel::PerVertex);
    CHECK(planned(scenes, "sheared torus", 0.01F).stretch == StretchModel::PerVertex);
    CHECK(planned(scenes, "sheared torus", 0.01F).estimator == GradientEstimator::Analytic);
    CHECK(planned(scenes, "smooth twisted torus", 0.01F).estimator == GradientEstimator::Analytic);
    CHECK(planned(scenes, "leaning block face", 0.01F).stretch == StretchModel::Leaning);
    CHECK(planned(scenes, "subdivided sheared torus", 0.01F).estimator == GradientEstimator::Limit);
    for (const PlanScene &s : scenes)
        for (const MeshPlan &mesh : fullPlan(s.scene).meshes) CHECK(mesh.interpolation == GradientInterpolation::Stretch);
    // Rough enough to lose light: the full model walks; smooth: nothing is lost.
    const auto multiscatter = [&](const std::string &name, float tolerance) {
        const auto found = std::find_if(scenes.begin(), scenes.end(), [&](const PlanScene &s) { return s.name == name; });
        return makePlan(found->scene, tolerance).materials.front().model;
    };
    CHECK(multiscatter("very rough torus", 0.01F) == Multiscatter::Walk);
    CHECK(multiscatter("smooth twisted torus", 0.1F) == Multiscatter::Off);
}

TEST_CASE("Honest plans: the true error is below the tolerance in every scene", "[plan][honest]") {
    constexpr int kSpp = 256;
    double saved = 0;
    double total = 0;
    std::printf("%-28s %9s %9s %9s %8s\n", "scene", "tolerance", "predicted", "true", "time");
    for (const PlanScene &scene : planScenes(32)) {
        const auto render = [&](const ScenePlan &plan) { return chart::renderImage(scene.scene, plan, scene.frame, kSpp, 1); };
        const RenderedImage full = render(fullPlan(scene.scene));
        for (const float tolerance : {0.1F, 0.01F, 0.001F}) {
            const ScenePlan plan = makePlan(scene.scene, tolerance);
            const RenderedImage image = render(plan);
            const double error = relativeRms(image.values, full.values);
            const auto predicted = static_cast<double>(plan.predictedError);
            std::printf("%-28s %9.3g %9.2g %9.2g %7.0f%%\n", scene.name.c_str(), static_cast<double>(tolerance), predicted, error,
                        100 * image.seconds / full.seconds);
            INFO(scene.name << " at " << tolerance);
            CHECK(error <= static_cast<double>(tolerance));
            CHECK(predicted <= static_cast<double>(tolerance));
            saved += full.seconds - image.seconds;
            total += full.seconds;
        }
    }
    std::printf("time saved over the full model: %.0f %%\n", 100 * saved / total);
}

TEST_CASE("A rigid mesh carries no tensors and is left alone where it stands", "[plan][rigid]") {
    Object torus = makeObject(makeTorus(24, 12, 0.8F, 0.3F));
    torus.placement.rotation.keys = {{1, DVec3(0)}, {3, DVec3(0, 0, 1)}};
    torus.placement.scale = Keyed<DVec3>(DVec3(1.5, 0.7, 1)); // constant: changes no gloss
    Scene scene = smallScene(torus, ggxMaterial(0.1F, 0.3F));
    RenderScene ready(scene, true);
    StageTimes times;
    ready.setFrame(1, times);
    const RenderObject &object = ready.objects()[0];
    CHECK(object.steps[0].stretch.empty());
    CHECK(object.gradient.f1.empty());
    REQUIRE(object.placements.size() == 1);
    const std::vector<Vec3> local = object.steps[0].positions;
    const Affine first = object.placements[0];
    ready.setFrame(1, times);
    CHECK(first == object.placements[0]);
    ready.setFrame(2, times);
    CHECK(first != object.placements[0]);
    CHECK(local == object.steps[0].positions);
    // These frames through the general path: a deformer that does next to nothing.
    scene.objects[0].deformers = {[] {
        DeformerKeys keys;
        keys.type = DeformerType::Stretch;
        keys.factor = Keyed<DVec3>(DVec3(1 + 1e-9));
        return keys;
    }()};
    RenderScene general(scene, true);
    general.setFrame(2, times);
    for (std::size_t v = 0; v < object.steps[0].normals.size(); ++v) {
        const Affine &m = object.placements[0];
        const SurfaceStep &own = object.steps[0];
        const SurfaceStep &there = general.objects()[0].steps[0];
        CHECK(glm::distance(transformPoint(m, own.positions[v]), there.positions[v]) < 2e-6F);
        CHECK(glm::distance(transformVector(m, own.normals[v]), there.normals[v]) < 1e-5F);
        CHECK(glm::distance(Vec4(transformVector(m, Vec3(own.tangents[v])), own.tangents[v].w), there.tangents[v]) < 1e-5F);
    }
}

TEST_CASE("BVHs that can be refitted are kept for few rays, and show the picture of fresh ones", "[plan][bvh]") {
    const DeformingMesh large[] = {{1200000, false}};
    const DeformingMesh blurred[] = {{1200000, true}};
    CHECK(refitsPay(large, 1e6));
    CHECK_FALSE(refitsPay(large, 1e9));
    CHECK_FALSE(refitsPay(blurred, 1e6)); // nothing to be won: these are built anew either way
    CHECK_FALSE(refitsPay({}, 1e6));

    Scene scene = smallScene(shearedTorus(300, 150), ggxMaterial(0.2F, 0.4F));
    const auto pictureAt3 = [&](int plannedSamples, bool refits) {
        scene.render.spp = plannedSamples;
        RenderScene ready(scene, true);
        CHECK(ready.refits() == refits);
        StageTimes times;
        for (const int frame : {1, 2, 3}) ready.setFrame(frame, times);
        FrameOptions options;
        options.spp = 16;
        return renderFrame(ready, options).film.resolve();
    };
    CHECK(greatestDifference(pictureAt3(1, true), pictureAt3(100000, false)) < 1e-5F);
}

TEST_CASE("The BVH policy refits a mild deformation and rebuilds a wild one, sooner for more rays", "[plan][bvh]") {
    Mesh mesh = makeTorus(200, 100, 0.8F, 0.3F);
    const Surface surface = buildSurface(mesh, {});
    std::vector<Vec3> positions;
    for (const Index s : surface.vertexSurface) positions.push_back(mesh.positions[surface.surfacePosition[s]]);
    positions.emplace_back(0);
    BvhPolicy policy;
    policy.built(surface.triangles, positions);
    CHECK(policy.growth(surface.triangles, positions) == Approx(1));
    const auto twisted = [&](float amount) {
        std::vector<Vec3> moved = positions;
        for (Vec3 &p : moved) {
            const float a = amount * p.z;
            p = {p.x * std::cos(a) - p.y * std::sin(a), p.x * std::sin(a) + p.y * std::cos(a), p.z};
        }
        return moved;
    };
    CHECK(policy.growth(surface.triangles, twisted(0.1F)) < 1.05);
    CHECK(policy.growth(surface.triangles, twisted(8)) > policy.growth(surface.triangles, twisted(2)));
    CHECK_FALSE(policy.shouldRebuild(surface.triangles, positions, 1e9));
    CHECK(policy.shouldRebuild(surface.triangles, twisted(8), 1e9));
    CHECK_FALSE(policy.shouldRebuild(surface.triangles, twisted(8), 10));
}
