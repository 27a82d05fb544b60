#include "study/charts.h"

namespace taut::chart {

std::span<const ChartEntry> allCharts() {
    static constexpr ChartEntry kCharts[] = {
        {"precision", "digits that float leaves to formulations of the microsurface", measurePrecision},
        {"sampling", "what samplers of reflections cost, reject and vary", measureSampling},
        {"gradient", "estimators of the surface gradient", measureGradient},
        {"interpolation", "schemes that interpolate it within a triangle", measureInterpolation},
        {"subdivision", "levels of subdivision", measureSubdivision},
        {"multiscatter", "light that meets more than one facet: energy, directions, cost", measureMultiscatter},
        {"walk", "how noisy the walk from facet to facet is, and what it costs", measureWalk},
        {"bvh", "refitting and rebuilding the BVH of a deforming mesh", measureBvh},
        {"plan", "what an error that is asked for costs, and whether it is kept", measurePlan},
        {"render", "the whole renderer by samples, models and samplers; Cycles where Blender is", measureRender},
        {"microgeometry", "a deformed heightfield of real facets beside M", measureMicrogeometry},
        {"mesostructure", "normal maps that lean, bend, and are seen from afar, beside a million real facets", measureMesostructure},
        {"talk", "the figures of the talk that the project began with", measureTalk},
        {"microsurface", "one hit and loops over many, beside a plain GGX", measureMicrosurface},
        {"lights", "one to 100,000 emitters: time and noise", measureLights},
        {"export", "the writers of taut export beside plain writing", measureExport},
        {"denoise", "pictures before and after the denoiser: error, highlights, flicker, cost", measureDenoise},
    };
    return kCharts;
}

} // namespace taut::chart
