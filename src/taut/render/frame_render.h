#pragma once
/// One frame, rendered in steps: it advances by a budget, can be stopped from another thread within a tile, be read while it goes on,
/// and be saved, restored and gone on with in another process. The command, a viewer, a checkpoint all use this one.
///
/// Film sums are exact (film.h) and a sample's random numbers follow from its number alone, so the picture is the same bits whatever the
/// budgets, the stops, the threads, the order of passes, and the split of samples (FrameOptions::firstSample) or pixels (window) over
/// films that are merged. The exceptions are a limit in seconds, which decides how many samples there are, and pixels that share their
/// samples, whose films are not merged.

#include "taut/render/adaptive_passes.h"
#include "taut/render/film.h"
#include "taut/render/image_file.h"
#include "taut/render/integrator.h"

#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>

namespace taut {

/// Samples a pass where time may run out between passes.
inline constexpr int kTimedPass = 4;

struct FrameOptions {
    int spp = 64;                         ///< samples a pixel; the upper bound where `seconds`, `noise` or `picture` are given
    int firstSample = 0;                  ///< number of the first of them: films of samples [0, n) and [n, m) merge into one of [0, m)
    std::optional<double> seconds{};      ///< of renderFrame: stop after the pass in which this much time is over
    std::optional<double> noise{};        ///< adaptive sampling to this relative noise (adaptive.h); firstSample is 0 then
    std::optional<PictureGoal> picture{}; ///< or to this noise of the picture
    bool shares = false;                  ///< pixels share their samples (pixel_filter.h), where mayShare() says so; firstSample is 0 then
    Window window{};                      ///< pixels to render; empty: the whole frame
    std::vector<Aov> aovs{};
    FilmLayers layers{};                 ///< their light groups are those of the scene, whatever is given
    int denoiseBlock = 0;                ///< of the film (film.h): what denoise() needs is kept as well; 0: it is not
    const FrameBefore *before = nullptr; ///< with that: whose motion is kept too
    std::uint32_t seed = 0;              ///< of this frame, already decorrelated (frameSeed)
    RayRecord *record = nullptr;
    bool independent = false; ///< as in TraceSettings
    bool oneByOne = false;    ///< as in TraceSettings
    /// Told the share done in [0, 1] from time to time, by one thread at a time, while the others go on; false stops.
    std::function<bool(double)> progress{};
};

/// How far advance() goes. Nothing given: to the end.
struct FrameBudget {
    int samples = 0;    ///< more samples for every pixel (adaptive: the next pass); 0: all that are left
    double seconds = 0; ///< return when so much time is over, at the next batch of samples; 0: no limit
    bool evenly = true; ///< with that limit: by passes over all pixels, for who looks at the film; else tile by tile, a little faster
};

enum class FrameState {
    Going,   ///< the budget is used up
    Stopped, ///< by stop() or the progress function
    Done
};

class FrameRender {
  public:
    /// Keeps a reference to `scene`, whose frame must not be changed while this lives. Throws InputError where options contradict each
    /// other.
    FrameRender(const RenderScene &scene, const FrameOptions &options);
    ~FrameRender();
    FrameRender(const FrameRender &) = delete;
    FrameRender &operator=(const FrameRender &) = delete;

    /// Renders on. By one thread at a time; uses all of TBB's. Every call that is not stopped gets further, however small its budget.
    FrameState advance(const FrameBudget &budget = {});

    /// Ends the advance() that goes on, else the next one, as soon as its threads look up: within a tile, in some milliseconds. What was
    /// under way is dropped, what the film has is whole. From any thread, or a signal handler.
    void stop() noexcept;

    [[nodiscard]] bool done() const;
    /// Share of the samples that are done, [0, 1].
    [[nodiscard]] double share() const;

    /// The film as it stands; from any thread, while advance() goes on too. Tiles may differ in their number of samples.
    [[nodiscard]] Film film() const;
    /// The film itself; only while nothing advances.
    [[nodiscard]] const Film &filmAtRest() const;
    /// The film to keep, when there is nothing more to do with this.
    [[nodiscard]] Film takeFilm() &&;

    /// Writes all that restore() needs to go on. Waits for an advance() to return.
    void save(std::ostream &out) const;
    /// Goes on where another process saved. The options must be those of then, but for spp where the frame is not adaptive. Throws
    /// InputError, which says what differs or is damaged, and leaves things as they were.
    void restore(std::istream &in);

    /// The film of what save() wrote, whatever frame that is of. Throws InputError where it is damaged.
    static Film savedFilm(std::istream &in);

    /// What adaptive sampling to the noise of the picture knows about it; none of other frames.
    [[nodiscard]] std::optional<PictureNoiseReached> reached() const;
    /// Of all advance() calls together.
    [[nodiscard]] StageTimes times() const;
    [[nodiscard]] RayCounts counts() const;
    [[nodiscard]] double seconds() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

struct FrameResult {
    Film film;
    StageTimes times; ///< rendering stages only
    RayCounts counts;
    std::optional<PictureNoiseReached> reached; ///< as in FrameRender
    double seconds = 0;                         ///< wall clock
    bool complete = true;                       ///< false: the progress function stopped it
};

/// Whether pixels may share their samples: R, G, B and A alone, filtered by Blackman-Harris.
bool mayShare(const FrameOptions &options, const RenderSettings &render);

/// Seed of a frame: decorrelated from its neighbours unless `fixed`.
std::uint32_t frameSeed(std::uint32_t seed, int frame, bool fixed);

/// A frame from its first sample to its last.
FrameResult renderFrame(const RenderScene &scene, const FrameOptions &options);

/// The means of a film as an image in the scene's frame.
Image imageOf(const Film &film, const RenderSettings &render);

} // namespace taut
