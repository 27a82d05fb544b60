#include "taut/pilot/foreseen_time.h"

#include "taut/plan/costs.h"
#include "taut/scene/object_motion.h"

namespace taut {

namespace {

/// Seconds, both cores together.
constexpr double kTopology = 1.2e-6;   ///< a face, once
constexpr double kRefined = 4.2e-6;    ///< a refined one: its rows of weights are most of that
constexpr double kRaysASample = 4;     ///< camera, scattered and shadow rays of a path that meets something
constexpr double kShadingOverRays = 2; ///< all of a ray's time over its traversal

double facesOf(const Object &object, int level) {
    return static_cast<double>(object.mesh->faceCount()) * static_cast<double>(1ULL << (2 * level));
}

} // namespace

double ForeseenTime::build(const std::vector<int> &levels) const {
    const PlanCosts costs;
    double seconds = 0;
    for (std::size_t i = 0; i < levels.size(); ++i)
        seconds += facesOf(scene_.objects[i], levels[i]) *
                   ((levels[i] > 0 ? kRefined : kTopology) + 1e-9 * static_cast<double>(costs.limit) + costs.bvh.refit + costs.bvh.build);
    return seconds;
}

double ForeseenTime::update(const std::vector<int> &levels) const {
    const PlanCosts costs;
    double seconds = 0;
    for (std::size_t i = 0; i < levels.size(); ++i)
        if (moves(scene_.objects[i]))
            seconds +=
                facesOf(scene_.objects[i], levels[i]) * (1e-9 * static_cast<double>(costs.limit) + costs.bvh.refit + costs.bvh.build);
    return seconds;
}

double ForeseenTime::rays(double count) const {
    return count * kShadingOverRays * BvhCosts{}.ray;
}

double ForeseenTime::samples(double count) const {
    return rays(count * kRaysASample);
}

double ForeseenTime::whole(const std::vector<int> &levels, double samplesAPixel) const {
    const RenderSettings &render = scene_.render;
    const double frames = static_cast<double>(render.frames.size());
    return build(levels) + (frames - 1) * update(levels) +
           frames * samples(static_cast<double>(render.width) * render.height * samplesAPixel);
}

} // namespace taut
