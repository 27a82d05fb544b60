#include "study/measures/render_image.h"

#include "study/measures/image_error.h"
#include "study/measures/timing.h"

#include "taut/base/stopwatch.h"

namespace taut::chart {

RenderedImage renderReady(const RenderScene &ready, int spp, std::uint32_t seed) {
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    Stopwatch watch;
    const FrameResult result = renderFrame(ready, options);
    RenderedImage image;
    image.seconds = image.render = watch.lap();
    const std::vector<float> values = result.film.resolve(); // R G B A
    for (std::size_t i = 0; i < values.size(); i += 4)
        image.values.insert(image.values.end(), values.begin() + static_cast<std::ptrdiff_t>(i),
                            values.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    return image;
}

RenderedImage renderImage(const Scene &scene, ScenePlan plan, double frame, int spp, std::uint32_t seed) {
    Stopwatch watch;
    RenderScene ready(scene, std::move(plan), true);
    StageTimes times;
    ready.setFrame(frame, times);
    const double before = watch.lap();
    RenderedImage image = renderReady(ready, spp, seed);
    image.seconds += before;
    return image;
}

bool sameModels(const ScenePlan &a, const ScenePlan &b) {
    if (a.bearableWaste != b.bearableWaste || a.motionSteps != b.motionSteps) return false;
    for (std::size_t i = 0; i < a.meshes.size(); ++i) {
        const MeshPlan &x = a.meshes[i];
        const MeshPlan &y = b.meshes[i];
        if (x.stretch != y.stretch || x.estimator != y.estimator || x.interpolation != y.interpolation ||
            x.subdivisionLevel != y.subdivisionLevel)
            return false;
    }
    for (std::size_t i = 0; i < a.materials.size(); ++i) {
        const MultiscatterPlan &x = a.materials[i];
        const MultiscatterPlan &y = b.materials[i];
        if (x.model != y.model || (x.model == Multiscatter::Auto && x.negligibleLoss != y.negligibleLoss)) return false;
    }
    return true;
}

std::vector<Measured> imageErrors(const std::vector<ImageOf> &ways, const ImageOf &reference, int seeds) {
    std::vector<std::vector<double>> errors(ways.size());
    for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(seeds); ++seed) {
        const std::vector<float> truth = reference(seed);
        for (std::size_t i = 0; i < ways.size(); ++i) errors[i].push_back(relativeRms(ways[i](seed), truth));
    }
    std::vector<Measured> medians;
    for (const auto &each : errors) medians.push_back(medianOf(each));
    return medians;
}

} // namespace taut::chart
