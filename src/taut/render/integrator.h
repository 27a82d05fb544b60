#pragma once
/// Unidirectional path tracing of batches: all paths of a tile advance one event at a time, so that camera rays, scattered rays
/// and shadow rays each go to Embree together. Next-event estimation and scattered rays are combined by multiple importance
/// sampling with the power heuristic (Veach 1997, section 9.2); Russian roulette ends dim paths.

#include "taut/render/film.h"
#include "taut/render/shading.h"
#include "taut/render/trace_settings.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <span>

namespace taut {

struct RayCounts {
    std::uint64_t paths = 0, camera = 0, scattered = 0, shadow = 0;
    std::uint64_t notFinite = 0; ///< samples dropped because they were not finite; 0 unless something is wrong
    RayCounts &operator+=(const RayCounts &other);
    [[nodiscard]] std::uint64_t rays() const { return camera + scattered + shadow; }
};

/// A film that others may read meanwhile, and a flag that others may set to stop.
struct FilmAccess {
    Film &film;
    std::mutex &lock; ///< of the tile's pixels
    const std::atomic<bool> &stop;
};

/// Working memory of one thread; reused from tile to tile.
class PathTracer {
  public:
    PathTracer(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const TraceSettings &settings);
    ~PathTracer();

    /// Samples a pixel of `tile` that are traced together.
    static int samplesABatch(const Window &tile);
    /// Traces samples [firstSample, lastSample) of the pixels of `tile` and adds them to the film, batch by batch. False where it was
    /// stopped: the batch under way is dropped, those before are in the film.
    bool traceTile(const Window &tile, int firstSample, int lastSample, const FilmAccess &access, StageTimes &times, RayCounts &counts);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace taut
