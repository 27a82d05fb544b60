#include "taut/render/render_windows.h"

#include "taut/base/parallel.h"

#include <tbb/enumerable_thread_specific.h>

namespace taut {

RenderedWindows renderWindows(const RenderScene &scene, std::span<const Window> windows, const WindowSettings &settings) {
    struct Worker {
        PathTracer tracer;
        RayCounts counts;
    };
    const RenderSettings &render = scene.scene().render;
    const std::vector<PreparedMaterial> materials = prepareMaterials(scene.scene(), scene.plan());
    TraceSettings trace{render.width, render.height, settings.maxEvents, render.boxFilter, settings.seed};
    tbb::enumerable_thread_specific<Worker> workers([&] { return Worker{PathTracer(scene, materials, trace), {}}; });
    RenderedWindows rendered;
    rendered.means.resize(windows.size());
    parallelFor(windows.size(), 1, [&](std::size_t i) {
        const Window &window = windows[i];
        Film film(window, {});
        std::mutex lock;
        const std::atomic<bool> goOn{false};
        StageTimes ignored;
        Worker &worker = workers.local();
        worker.tracer.traceTile(window, 0, settings.samples, {film, lock, goOn}, ignored, worker.counts);
        for (int y = window.y0; y < window.y1; ++y)
            for (int x = window.x0; x < window.x1; ++x)
                for (std::size_t channel = 0; channel < 3; ++channel)
                    rendered.means[i].push_back(film.sumAt(x, y, channel).value() / settings.samples);
    });
    for (const Worker &worker : workers) rendered.counts += worker.counts;
    return rendered;
}

} // namespace taut
