/// taut chart render: the whole renderer, time against noise and bias, by samples, models and samplers; and Cycles beside it.

#include "study/charts.h"
#include "study/measures/cycles_peer.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include <tbb/info.h>

#include <cmath>

namespace taut::chart {

namespace {

constexpr int kSize = 64;
const std::vector<int> kSampleCounts{1, 4, 16, RenderSettings{}.spp};

struct StudyScene {
    std::string name, title;
    Scene scene;
};

/// A torus that is sheared, over a metal ground if there is one.
Scene shearedTorus(const Material &material, double shear, bool ground, int maxEvents) {
    std::vector<Material> materials{material};
    if (ground) materials.push_back(brushedMetal(0.2F, 0.2F));
    Scene scene = torusScene(makeTorus(96, 48, 1, 0.4F), -0.4, std::move(materials), kSize, maxEvents);
    scene.objects[0].deformers = {deformer(DeformerType::Shear, shear, 0, 2)};
    return scene;
}

std::vector<StudyScene> studyScenes() {
    Scene furnace = shearedTorus(brushedMetal(0.08F, 0.4F), 0.8, false, 8);
    furnace.environment = constantEnvironment(Vec3(1));
    Scene lamp = shearedTorus(brushedMetal(0.04F, 0.12F), 0.8, true, 6);
    lamp.lights = {lampAbove()};
    Scene rough = shearedTorus(brushedMetal(0.5F, 0.5F), 1.5, true, 6);
    rough.environment = constantEnvironment(Vec3(0.3F));
    rough.lights = {lampAbove()};
    return {{"furnace", "Brushed torus in a white furnace", std::move(furnace)},
            {"lamp", "Brushed torus under an area light", std::move(lamp)},
            {"rough", "Rough torus, strongly sheared, under a lamp and a sky", std::move(rough)}};
}

/// A way to render a scene, with a plan for each of kSampleCounts.
struct Way {
    std::string name;
    Scene scene;
    std::vector<ScenePlan> plans;
    bool isDefault = false;
};

/// What the renderer plans for a scene at each number of samples.
std::vector<ScenePlan> plansOf(Scene scene) {
    std::vector<ScenePlan> plans;
    for (const int samples : kSampleCounts) {
        scene.render.spp = samples;
        plans.push_back(makePlan(scene));
    }
    return plans;
}

std::vector<Way> modelsOf(const Scene &scene) {
    const auto with = [&](Multiscatter model) {
        Scene changed = scene;
        for (Material &material : changed.materials) material.multiscatter = model;
        return changed;
    };
    const Scene single = with(Multiscatter::Off);
    const Scene compensated = with(Multiscatter::Compensation);
    Scene fixed = scene;
    for (Object &object : fixed.objects) object.follow = false;
    return {{"plan", scene, plansOf(scene), true},
            {"full model", scene, std::vector<ScenePlan>(kSampleCounts.size(), fullPlan(scene))},
            {"compensation", compensated, plansOf(compensated)},
            {"no multiple scattering", single, plansOf(single)},
            {"gloss held fixed", fixed, plansOf(fixed)}};
}

/// Samplers of reflections. The walk has its own, so they are compared without it; and with what Cycles 3.4 has: separable masking.
Scene withoutWalk(Scene scene) {
    for (Material &material : scene.materials) {
        material.masking = Masking::Separable;
        material.multiscatter = Multiscatter::Off;
    }
    return scene;
}
std::vector<Way> samplersOf(const Scene &scene) {
    const auto planned = [&](float waste) {
        std::vector<ScenePlan> plans = plansOf(scene);
        for (ScenePlan &plan : plans) plan.bearableWaste = waste;
        return plans;
    };
    return {{"caps, or the cone", scene, planned(kBearableWaste), true}, {"bounded caps", scene, planned(1)}, {"cone", scene, planned(0)}};
}

/// One choice: a way with a number of samples.
struct Measurement {
    std::vector<double> seconds, errors;
    void add(double time, const std::vector<float> &image, const std::vector<float> &reference) {
        seconds.push_back(time);
        errors.push_back(relativeMse(image, reference));
    }
};

Panel emptyPanel(const std::string &name, const std::string &title, const std::string &conditions) {
    Panel panel{name, title, conditions, {"time of a frame, everything included", "s"}, {"relMSE", ""}, {}};
    panel.joined = true;
    panel.labelled = false;
    return panel;
}

void addPoints(Panel &panel, const std::string &series, const std::vector<Measurement> &bySamples, bool isDefault) {
    for (std::size_t k = 0; k < kSampleCounts.size(); ++k)
        panel.points.push_back({series, std::to_string(kSampleCounts[k]) + " spp", medianOf(bySamples[k].seconds),
                                medianOf(bySamples[k].errors), isDefault && kSampleCounts[k] == RenderSettings{}.spp});
}

std::string conditionsOf(const Scene &scene, int reference) {
    return std::to_string(kSize) + " x " + std::to_string(kSize) + " pixels, " + std::to_string(scene.render.maxEvents) +
           " events; points: " + std::to_string(kSampleCounts.front()) + ", 4, 16, " + std::to_string(kSampleCounts.back()) +
           " samples a pixel; reference: the full model at " + std::to_string(reference) + " samples, another seed; all threads";
}

/// A plan with what the materials themselves say in it.
ScenePlan resolved(const Scene &scene, ScenePlan plan) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        plan.materials[i].model = multiscatterOf(scene.materials[i], plan.materials[i].model);
    return plan;
}

/// Frames of so many samples in a round: short ones are more at the mercy of what else the machine does.
int framesOf(int samples) {
    return samples >= 64 ? 1 : samples >= 16 ? 2 : samples >= 4 ? 4 : 8;
}

/// Every way at every number of samples; the truth is the full model of the scene.
struct Study {
    std::vector<float> truth;
    std::vector<std::vector<Measurement>> ways; ///< [ways][kSampleCounts]
};
Study measureWays(const Scene &scene, const std::vector<Way> &ways, int reference, int rounds) {
    Study study{renderImage(scene, fullPlan(scene), 1, reference, 1000).values, {}};
    study.ways.assign(ways.size(), std::vector<Measurement>(kSampleCounts.size()));
    // A way that does what an earlier one does takes its numbers: noise would order them.
    const auto same = [&](const Way &a, const Way &b, std::size_t k) {
        return a.scene.objects[0].follow == b.scene.objects[0].follow &&
               sameModels(resolved(a.scene, a.plans[k]), resolved(b.scene, b.plans[k]));
    };
    const auto sourceOf = [&](std::size_t i, std::size_t k) {
        std::size_t source = 0;
        while (source < i && !same(ways[source], ways[i], k)) ++source;
        return source;
    };
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < kSampleCounts.size(); ++k)
            for (std::size_t i = 0; i < ways.size(); ++i) {
                if (sourceOf(i, k) < i) continue;
                for (int n = 0, frames = framesOf(kSampleCounts[k]); n < frames; ++n) {
                    const auto seed = static_cast<std::uint32_t>(round * frames + n + 1);
                    const RenderedImage image = renderImage(ways[i].scene, ways[i].plans[k], 1, kSampleCounts[k], seed);
                    study.ways[i][k].add(image.seconds, image.values, study.truth);
                }
            }
    for (std::size_t k = 0; k < kSampleCounts.size(); ++k)
        for (std::size_t i = 0; i < ways.size(); ++i) study.ways[i][k] = study.ways[sourceOf(i, k)][k];
    return study;
}

Panel panelOf(const std::string &name, const std::string &title, const std::string &conditions, const std::vector<Way> &ways,
              const Study &study) {
    Panel panel = emptyPanel(name, title, conditions);
    for (std::size_t i = 0; i < ways.size(); ++i) addPoints(panel, ways[i].name, study.ways[i], ways[i].isDefault);
    return panel;
}

/// How much longer one series takes to reach the last error of another.
double timeRatio(const Panel &panel, const std::string &slower, const std::string &ours) {
    std::vector<ErrorPoint> curve; // over time
    Point target;
    for (const Point &p : panel.points) {
        if (p.series == slower) curve.push_back({p.x.value, p.y.value});
        if (p.series == ours) target = p;
    }
    return samplesToReach(curve, target.y.value) / target.x.value;
}

/// Cycles holds the gloss fixed as the mesh is deformed, and so do we here; both take turns. Scene and BVH stay in memory in both.
Panel besideCycles(const StudyScene &study, const std::string &conditions, int reference, int rounds) {
    Scene scene = withoutWalk(study.scene);
    for (Object &object : scene.objects) object.follow = false;
    for (Material &material : scene.materials) material.name = &material == &scene.materials[0] ? "metal" : "ground";
    Panel panel = emptyPanel("cycles-" + study.name, study.title + ": Cycles",
                             conditions + ", gloss held fixed; scene and BVH in memory; in Cycles nothing that trades truth for speed");
    panel.x.name = "time of a render";
    panel.hasFront = false;
    RenderScene ready(scene, makePlan(scene), true);
    CyclesPeer cycles(ready, tbb::info::default_concurrency());
    const std::vector<float> truth = renderReady(ready, reference, 1000).values;
    std::vector<Measurement> ours(kSampleCounts.size());
    std::vector<Measurement> theirs(kSampleCounts.size());
    cycles.render({0, 1, 0, kSize, kSize}); // its BVH
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < kSampleCounts.size(); ++k)
            for (int n = 0, frames = framesOf(kSampleCounts[k]); n < frames; ++n) {
                const int seed = round * frames + n + 1;
                const RenderedImage image = renderReady(ready, kSampleCounts[k], static_cast<std::uint32_t>(seed));
                ours[k].add(image.seconds, image.values, truth);
                const CyclesRender render = cycles.render({0, kSampleCounts[k], seed, kSize, kSize, true});
                theirs[k].add(render.seconds, render.image, truth);
            }
    addPoints(panel, "Taut", ours, true);
    addPoints(panel, "Cycles", theirs, false);
    return panel;
}

} // namespace

Chart measureRender(const ChartOptions &options) {
    const int reference = options.pick(512, 16384);
    const int rounds = options.pick(5, 15);
    const std::string last = std::to_string(RenderSettings{}.spp);
    Chart chart{
        "render", "The whole renderer",
        "Frames of three scenes at 1 to " + last +
            " samples a pixel. Models: the plan, every saving off, compensation for multiple scattering, none, and gloss held "
            "fixed as other renderers do. Samplers of reflections, without multiple scattering: bounded caps, the cone that loses "
            "nothing, and the cone where caps would lose more than " +
            digits(100 * static_cast<double>(kBearableWaste)) + " %. The truth is the full model with many more samples.",
        "relMSE is the mean over pixels of the squared difference over the squared reference plus a hundredth of its mean squared. Lines "
        "fall with the number of samples until what is left is bias. Time includes topology, deformation and BVH."};
    std::vector<Panel> models;
    std::vector<Panel> samplers;
    std::vector<Panel> beside;
    std::string times;
    const bool cycles = hasBlender();
    for (const StudyScene &s : studyScenes()) {
        const std::string conditions = conditionsOf(s.scene, reference);
        const std::vector<Way> ways = modelsOf(s.scene);
        models.push_back(panelOf(s.name, s.title, conditions, ways, measureWays(s.scene, ways, reference, rounds)));
        const Scene single = withoutWalk(s.scene);
        const std::vector<Way> others = samplersOf(single);
        const std::string same = conditions + "; one bounce on the microsurface, separable masking";
        samplers.push_back(
            panelOf("samplers-" + s.name, s.title + ": samplers", same, others, measureWays(single, others, reference, rounds)));
        if (!cycles) continue;
        beside.push_back(besideCycles(s, same, reference, rounds));
        times += (times.empty() ? "" : ", ") + digits(timeRatio(beside.back(), "Cycles", "Taut"), 2) + " (" + s.name + ")";
    }
    for (std::vector<Panel> *panels : {&models, &samplers, &beside})
        chart.panels.insert(chart.panels.end(), panels->begin(), panels->end());
    chart.choice = "Default: the plan, " + last +
                   " samples, the cone where bounded caps would lose more than a tenth. What single scattering loses and what a fixed "
                   "gloss gets wrong no number of samples mends. ";
    chart.choice += cycles ? "To come to Taut's error at " + last + " samples Cycles needs " + times + " times Taut's time."
                           : std::string("Cycles is left out: there is no blender on the PATH.");
    return chart;
}

} // namespace taut::chart
