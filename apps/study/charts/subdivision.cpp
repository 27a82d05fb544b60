/// taut chart subdivision: levels of subdivision, time and memory against the error of the image.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/memory.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include "taut/base/stopwatch.h"

#include <memory>

namespace taut::chart {

namespace {

constexpr int kAround = 12;
constexpr int kAcross = 6;
constexpr int kSpp = 64;

/// A torus twisted about x and waved: a cage that is subdivided `level` times at every frame, or a mesh that was subdivided once at rest
/// and is deformed as it is.
Scene sceneOf(bool limit, int level) {
    Mesh cage = makeTorus(kAround, kAcross, 0.7F, 0.3F);
    SubdivisionOptions subdivision;
    subdivision.level = level;
    Object torus = twistedTorus(limit || level == 0 ? std::move(cage) : subdivide(cage, subdivision).mesh, 1.1, 0.08);
    if (limit) torus.subdivision = subdivision;
    return studyScene(std::move(torus), brushedMetal(0.1F, 0.3F), 96);
}

/// The surface at a level, ready to be rendered.
struct Level {
    bool limit;
    int level;
    Scene scene;
    std::unique_ptr<RenderScene> ready;
    double megabytes; ///< what getting ready has allocated
    std::vector<double> errors, seconds;

    Level(bool isLimit, int levels) : limit(isLimit), level(levels), scene(sceneOf(isLimit, levels)) {
        const double before = allocatedMegabytes();
        ready = std::make_unique<RenderScene>(scene, fullPlan(scene), true);
        move();
        megabytes = allocatedMegabytes() - before;
    }
    void move() const {
        StageTimes ignored;
        ready->setFrame(1, ignored);
    }
    [[nodiscard]] std::vector<float> render(std::uint32_t seed) const { return renderReady(*ready, kSpp, seed).values; }
    [[nodiscard]] double triangles() const { return static_cast<double>(ready->objects()[0].surface.triangles.size()); }
};
using Levels = std::vector<std::unique_ptr<Level>>; // a RenderScene refers to its scene

/// The level that the plan takes for a cage whose level is left to it.
int plannedLevel() {
    Scene scene = sceneOf(true, 0);
    scene.objects[0].planLevel = true;
    return makePlan(scene).meshes[0].subdivisionLevel;
}

/// `marked`: the default levels are marked: of a mesh that says nothing, and of one that leaves it to the plan. Whole frames differ by what
/// the coarse shape lets rays meet, so that level 0 is not their cheapest.
Panel panelOf(const std::string &name, const std::string &title, const Axis &x, const Levels &all,
              const std::function<Measured(std::size_t)> &cost, bool marked = true) {
    const int planned = plannedLevel();
    const auto isDefault = [planned](int level) { return level == SubdivisionOptions{}.level || level == planned; };
    Panel panel{name, title, "", x, {"RMS error of the image, relative", ""}, {}};
    panel.conditions = "torus of " + std::to_string(kAround) + " x " + std::to_string(kAcross) +
                       " quads, twisted and waved; 96 x 96 pixels, 64 samples, three seeds or more; reference: level " +
                       std::to_string(kReferenceLevel) + " of the same kind, the same random numbers";
    panel.joined = true;
    for (std::size_t i = 0; i < all.size(); ++i)
        panel.points.push_back({all[i]->limit ? "limit surface" : "triangles", "level " + std::to_string(all[i]->level), cost(i),
                                medianOf(all[i]->errors), marked && all[i]->limit && isDefault(all[i]->level)});
    return panel;
}

} // namespace

Chart measureSubdivision(const ChartOptions &options) {
    Levels all;
    for (const bool limit : {true, false})
        for (int level = limit ? 0 : 1; level <= kMaxSubdivisionLevel; ++level) // the cage is the same mesh in both
            all.push_back(std::make_unique<Level>(limit, level));
    std::vector<std::function<void()>> rows;
    for (const auto &choice : all)
        rows.emplace_back([&choice] {
            for (int i = 0; i < 4; ++i) choice->move();
        });
    std::vector<Measured> surface = timeOnOneThread(rows, options.pick(15, 101));
    for (Measured &t : surface) t = t * (1e3 / 4);

    const Level finest[] = {Level(true, kReferenceLevel), Level(false, kReferenceLevel)};
    for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(options.pick(3, 9)); ++seed) {
        const std::vector<float> references[] = {finest[0].render(seed), finest[1].render(seed)};
        for (const auto &choice : all) {
            Stopwatch watch;
            choice->move();
            const std::vector<float> image = choice->render(seed);
            choice->seconds.push_back(watch.lap());
            choice->errors.push_back(relativeRms(image, references[choice->limit ? 0 : 1]));
        }
    }

    Chart chart{"subdivision", "Levels of subdivision",
                "A cage that is deformed and then put on its limit surface, refined to a level, with the limit's own derivatives; and "
                "triangles: the same surface refined at rest, its vertices deformed one by one. Each against itself at level " +
                    std::to_string(kReferenceLevel) + ", where the image has converged.",
                "Down is closer to the converged image, left is cheaper. Level 0 is the cage itself. The lines run from level to level."};
    chart.panels.push_back(panelOf("time", "A frame of the surface: deformation, gradient, BVH built anew",
                                   {"time a frame, one thread", "ms"}, all, [&](std::size_t i) { return surface[i]; }));
    chart.panels.push_back(panelOf(
        "whole", "A whole frame, rendering included", {"time a frame, all threads", "s"}, all,
        [&](std::size_t i) { return medianOf(all[i]->seconds); }, false));
    chart.panels.push_back(panelOf("memory", "Memory of the scene, BVH included", {"memory", "MB"}, all,
                                   [&](std::size_t i) { return Measured{all[i]->megabytes}; }));
    chart.panels.push_back(
        panelOf("triangles", "Triangles", {"triangles", ""}, all, [&](std::size_t i) { return Measured{all[i]->triangles()}; }));
    const std::size_t finestLimit = kMaxSubdivisionLevel;
    const std::size_t finestTriangles = all.size() - 1;
    const auto over = [&](double limit, double triangles) { return digits(limit / triangles, 2); };
    const int planned = plannedLevel();
    chart.choice = "Default: level " + std::to_string(SubdivisionOptions{}.level) +
                   ": a mesh is taken as its file has it, the cheapest choice; whether it is meant as a cage only its maker knows. Where "
                   "it is one, subdivision = \"auto\" lets the plan choose, here level " +
                   std::to_string(planned) + ", whose true error is " +
                   digits(medianOf(all[static_cast<std::size_t>(planned)]->errors).value, 2) + ", for a predicted one within " +
                   digits(static_cast<double>(kDefaultTolerance)) + ". At level " + std::to_string(kMaxSubdivisionLevel) +
                   " the limit surface has " +
                   over(medianOf(all[finestLimit]->errors).value, medianOf(all[finestTriangles]->errors).value) +
                   " of the error of as many triangles deformed one by one, takes " +
                   over(surface[finestLimit].value, surface[finestTriangles].value) + " of their time and " +
                   over(all[finestLimit]->megabytes, all[finestTriangles]->megabytes) +
                   " times their memory (its rows of weights). In a whole frame the first levels cost little beside the rays.";
    return chart;
}

} // namespace taut::chart
