/// Plans: what they choose, and that the image is as close to the full model as they say.

#include "catch.h"
#include "command.h"
#include "render_fixtures.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/plan_scenes.h"

#include "taut/plan/bvh_question.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>

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

TEST_CASE("Every value of a plan has a name of its own", "[plan]") {
    std::vector<std::string> names;
    const auto add = [&](const Question &question) {
        for (const Choice &c : question.choices) names.push_back(std::string(nameOf(question)) + ": " + nameOf(c));
    };
    const auto choicesOf = [](auto... values) {
        Question question;
        (question.choices.push_back({values, 0, 0, 0, {}}), ...);
        return question;
    };
    add(choicesOf(StretchModel::Constant, StretchModel::Uniform, StretchModel::PerVertex, StretchModel::Leaning));
    add(choicesOf(SubdivisionLevel{1}, SubdivisionLevel{2}));
    add(choicesOf(GradientInterpolation::Face, GradientInterpolation::Stretch));
    add(choicesOf(GradientEstimator::Limit, GradientEstimator::Analytic));
    add(choicesOf(Multiscatter::Off, Multiscatter::Auto, Multiscatter::Walk));
    add(choicesOf(BvhKind::Refit, BvhKind::Rebuild));
    CHECK(names == std::vector<std::string>{"stretch: constant", "stretch: uniform", "stretch: per vertex, 3 numbers",
                                            "stretch: leaning, 5 numbers", "subdivision: level 1", "subdivision: level 2",
                                            "interpolation: face", "interpolation: stretch", "gradient: limit", "gradient: analytic",
                                            "multiscatter: off", "multiscatter: compensation where M asks for it", "multiscatter: walk",
                                            "bvh: refit", "bvh: rebuild"});
    CHECK(nameOf(StretchModel::PerVertex) == "per vertex");
    CHECK(nameOf(Multiscatter::Auto) == "by each hit's M");
    CHECK(unitOf(choicesOf(BvhKind::Refit)) == "ms a frame, slower rays included");
}

TEST_CASE("taut info prints the questions of a plan with what they lose and cost", "[plan][cli]") {
    const std::string folder = freshFolder("plan_info");
    writeBytes(folder + "/plate.toml", "[render]\nwidth = 24\nheight = 16\nspp = 4\nframes = \"1-3\"\n[environment]\nradiance = 0.5\n"
                                       "[material.brushed]\ntype = \"conductor\"\nmetal = \"Al\"\nalpha = [0.1, 0.4]\n"
                                       "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR "/meshes/plate.obj\"\nmaterial = \"brushed\"\n"
                                       "[[mesh.deform]]\ntype = \"shear\"\nplane = \"xy\"\namount = [[1, 0.0], [3, 1.2]]\n");
    const CommandResult result = runTaut({"info", "plate.toml"}, folder);
    REQUIRE(result.exitCode == 0);
    CHECK(result.out ==
          "plate.toml: 24 x 16, 4 spp, 3 frames (1 to 3)\n"
          "1 materials, 0 textures, 0 lights, an environment\n"
          "  brushed: multiscatter walk\n"
          "    multiscatter: walk (predicted error 0, 1.17e+03 ns a hit at equal noise); next cheaper: compensation where M asks for it "
          "(predicted error 0.11, 240 ns a hit at equal noise)\n"
          "  plate: 2048 triangles, 1089 render vertices\n"
          "    1 components, 1 boundary loops, 0 edges of more than two faces\n"
          "    stretch 0.5662 to 1.766, shear up to 1.2, at most 0 collapsed vertices and 0 folded triangles\n"
          "    alpha 0.05662 to 0.7065\n"
          "    plan: M uniform, gradient analytic, interpolation stretch\n"
          "    stretch: uniform (predicted error 0, 9 ns a hit); next cheaper: constant (predicted error 1.1, 0 ns a hit)\n"
          "    gradient: analytic (predicted error 0, 128 ns a vertex)\n"
          "    bvh: refit, 1 of 2 frames rebuilt (predicted error 0, 0.187 ms a frame, slower rays included)\n"
          "plan: tolerance 0.01, predicted error 0, BVH refit, rebuilt where its rays would pay for it\n"
          "  of               question       taken               error      time     saves  next step\n"
          "  plate            stretch        uniform                 0 4.15e-05 s 3.23e-05 s  -\n"
          "  plate            bvh            refit                   0 0.000561 s -3.92e-05 s  -\n"
          "  brushed          multiscatter   walk                    0 0.00538 s         -  -\n");
}

TEST_CASE("The renderer takes over the surfaces that a plan has built, with the same bits", "[plan]") {
    Scene scene = smallScene(shearedTorus(24, 12), ggxMaterial(0.2F, 0.4F));
    scene.render.frames = {1, 2, 3};
    for (const int level : {1, 2}) { // one chosen by a plan, which looks at level 2 first; one given
        Object subdivided = shearedTorus(12, 6);
        subdivided.planLevel = level == 1;
        subdivided.subdivision.level = level;
        subdivided.placement.translation = DVec3(0, 0, level);
        scene.objects.push_back(std::move(subdivided));
    }
    scene.objects.push_back(makeObject(makeSphere(12, 6, 0.3F))); // rigid: no question needs its surface
    for (const bool report : {false, true}) {
        PlanOptions options;
        options.tolerance = 0.1F;
        options.report = report;
        PlannedScene planned = planScene(scene, options);
        CHECK(planned.fields.size() == (report ? 4 : 0));
        CHECK((planned.surfaces.back().object != nullptr) == report);
        const ScenePlan plan = planned.plan;
        std::vector<const Index3 *> built;
        for (const ObjectSurface &surface : planned.surfaces) built.push_back(surface.surface.triangles.data());
        RenderScene ready(scene, std::move(planned.plan), true, std::move(planned.surfaces));
        for (std::size_t i = 0; i < built.size(); ++i)
            if (built[i] != nullptr) CHECK(ready.objects()[i].surface.triangles.data() == built[i]);
        RenderScene own(scene, plan, true);
        FrameOptions frame;
        frame.spp = 4;
        StageTimes times;
        for (const int number : scene.render.frames) {
            ready.setFrame(number, times);
            own.setFrame(number, times);
            CHECK(renderFrame(ready, frame).film.resolve() == renderFrame(own, frame).film.resolve());
        }
    }
}

TEST_CASE("A factor of two in a cost takes other choices within the tolerance, and no other error", "[plan][costs]") {
    using Scaled = std::function<void(PlanCosts &, double)>;
    const auto weighed = [](float PlanCosts::*cost) -> Scaled {
        return [cost](PlanCosts &costs, double factor) { costs.*cost *= static_cast<float>(factor); };
    };
    const auto ofBvh = [](double BvhCosts::*cost) -> Scaled {
        return [cost](PlanCosts &costs, double factor) { costs.bvh.*cost *= factor; };
    };
    const auto printedOnly = [](PlanCosts &costs, double factor) {
        for (float PlanCosts::*cost : {&PlanCosts::uniform, &PlanCosts::face, &PlanCosts::vertex, &PlanCosts::lean, &PlanCosts::limit,
                                       &PlanCosts::analytic, &PlanCosts::refit})
            costs.*cost *= static_cast<float>(factor);
    };
    const std::pair<const char *, Scaled> kCosts[] = {{"printed ones", printedOnly},
                                                      {"compensation", weighed(&PlanCosts::compensation)},
                                                      {"walk", weighed(&PlanCosts::walk)},
                                                      {"walk by loss", weighed(&PlanCosts::walkLoss)},
                                                      {"walk's variance", weighed(&PlanCosts::walkVariance)},
                                                      {"BVH refit", ofBvh(&BvhCosts::refit)},
                                                      {"BVH build", ofBvh(&BvhCosts::build)},
                                                      {"BVH ray", ofBvh(&BvhCosts::ray)},
                                                      {"BVH slowdown", ofBvh(&BvhCosts::slowdown)},
                                                      {"BVH refittable", ofBvh(&BvhCosts::refittable)}};
    std::vector<PlanScene> scenes = planScenes(16); // refits and rebuilds come close at so few pixels
    const Scene torus = scenes[5].scene;
    for (const float alpha : {0.2F, 0.3F, 0.4F}) { // compensation and walk come close
        scenes.push_back({"torus of alpha 0." + std::to_string(std::lround(10 * alpha)), torus});
        scenes.back().scene.materials[0].alphaX.value = scenes.back().scene.materials[0].alphaY.value = alpha;
    }
    std::erase_if(scenes, [](const PlanScene &s) { return s.scene.objects[0].planLevel; }); // costs follow the level, which takes long
    struct Changes {
        int trees = 0;        // plans that take the other kind of BVH
        std::string pictures; // plans that treat light of several facets in another way
    };
    std::map<std::pair<std::string, double>, Changes> changes;
    for (const PlanScene &scene : scenes)
        for (const std::optional<float> tolerance : {std::optional<float>(0.1F), std::optional<float>()}) {
            PlanOptions options;
            options.tolerance = tolerance;
            const ScenePlan plan = planScene(scene.scene, options).plan;
            for (const auto &[name, scale] : kCosts)
                for (const double factor : {0.5, 2.0}) {
                    options.costs = {};
                    scale(options.costs, factor);
                    const ScenePlan other = planScene(scene.scene, options).plan;
                    INFO(scene.name << ", " << name << " x " << factor);
                    CHECK(other.predictedError <= tolerance.value_or(kDefaultTolerance));
                    CHECK(other.errorInNoise == plan.errorInNoise);
                    CHECK(other.meshes[0].stretch == plan.meshes[0].stretch); // the order of these choices is no matter of time
                    CHECK(other.meshes[0].interpolation == plan.meshes[0].interpolation);
                    Changes &c = changes[{name, factor}];
                    c.trees += plan.bvh != other.bvh ? 1 : 0;
                    const Multiscatter was = plan.materials[0].model;
                    const Multiscatter is = other.materials[0].model;
                    if (was != is) c.pictures += "; " + scene.name + ": " + nameOf(was) + " to " + nameOf(is);
                }
        }
    for (const auto &[cost, c] : changes)
        std::printf("%-16s x %3.1f: %2d of %zu plans with the other BVH%s\n", cost.first.c_str(), cost.second, c.trees, 2 * scenes.size(),
                    c.pictures.c_str());
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

TEST_CASE("Triangles are counted before they are built", "[plan][bvh]") {
    Mesh pentagon = makeGrid(1, 1, 1);
    pentagon.positions.emplace_back(0, 2, 0);
    pentagon.faceOffsets = {0, 5};
    pentagon.cornerPositions = {0, 1, 3, 4, 2};
    for (auto *corners : {&pentagon.cornerUvs, &pentagon.cornerNormals}) corners->clear();
    for (const Mesh &mesh : {makeTorus(8, 6, 0.8F, 0.3F), makeSphere(12, 6, 0.3F), pentagon})
        for (const int level : {0, 1, 3}) {
            Object object = makeObject(mesh);
            ObjectSurface surface;
            prepareObjectSurface(object, 24, GradientEstimator::Area, level, surface);
            CHECK(triangleCount(object, level) == surface.surface.triangles.size());
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
