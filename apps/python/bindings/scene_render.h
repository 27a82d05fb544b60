#pragma once
/// A scene that Python holds, and a frame of it that is being rendered.

#include "scene_tree.h"

#include "taut/plan/plan.h"
#include "taut/render/denoise_features.h"
#include "taut/render/denoise_frames.h"
#include "taut/render/frame_render.h"
#include "taut/render/render_scene.h"
#include "taut/scene/ground.h"

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

namespace taut::python {

/// Who works on a scene.
struct Busy {
    std::mutex mutex;
    std::atomic<std::thread::id> owner{};
};

/// A scene, made ready where first needed: by its plan, at the frames that it names; elsewhere, and with points of Python, of which nobody
/// knows what they will be, everything per vertex and per hit (defaultPlan). Work on it is done by one thread at a time, without the
/// interpreter's lock.
class PythonScene {
  public:
    PythonScene(Scene scene, Warnings warnings, PlanOptions plan, bool pointsOfPython);

    /// As it was read: without the ground that its pictures stand on.
    [[nodiscard]] const Scene &scene() const { return loaded_; }
    [[nodiscard]] std::vector<std::string> warnings() const;
    /// As `taut info --json`.
    std::string plan();
    /// As `taut export --json`, with what it warned of added to warnings().
    std::string exportFiles(const std::vector<std::string> &outputs, const std::string &frames, const std::vector<std::string> &objects,
                            const std::string &convention, const std::string &positions, const std::string &space, bool ascii);
    /// Arrays of one object at a frame, as `taut export` writes them to .npz.
    py::dict glossAt(double frame, const std::string &object);
    void setPoints(const std::string &object, std::shared_ptr<const PointSource> points);
    /// Ends the render that goes on.
    void stop();

  private:
    friend class Refinement;
    RenderScene &ready(bool planned);
    [[nodiscard]] bool isPlanned(double frame) const;
    [[nodiscard]] Index objectNamed(const std::string &name) const;

    Scene loaded_;
    void warn(const Warnings &more);
    mutable std::mutex warningsLock_; // a thread may read them while another works without Python's lock
    Warnings warnings_;
    bool isGrounded_ = false; // whether a ground was looked for
    std::optional<Ground> ground_;
    PlanOptions planOptions_;
    std::shared_ptr<RenderScene> ready_; // of a scene that is made ready anew refinements keep the old one
    bool planned_;
    std::uint64_t changes_ = 0; // frames that were set, points that were changed
    Busy busy_;
    std::mutex goingMutex_;
    FrameRender *going_ = nullptr; // what stop() ends
};

/// What takes the noise out of pictures of a scene; over frames it has the one before in mind.
struct PythonDenoiser {
    explicit PythonDenoiser(bool overFrames) : denoiser(overFrames) {}
    FrameDenoiser denoiser;
    std::optional<double> before{}; ///< that frame
};

struct RefinementOptions {
    double frame = 1;
    int spp = 0; ///< 0: the scene's
    int firstSample = 0;
    std::optional<double> noise;
    std::array<int, 4> crop{}; ///< empty: all
    std::vector<std::string> aovs;
    std::optional<std::uint32_t> seed;
    std::shared_ptr<PythonDenoiser> denoiser; ///< null: none
    bool isTimed = false;                     ///< how many samples there will be is not known
};

class Refinement {
  public:
    Refinement(std::shared_ptr<PythonScene> scene, const RefinementOptions &options);
    /// "going", "stopped" or "done". Signals are looked at, and `progress` (None, or a function of the share that may return False to stop)
    /// is called, by the calling thread. What either throws comes out once the render has stopped, which is within a tile.
    std::string advance(int samples, double seconds, const py::object &progress);
    void stop() { render_->stop(); }
    [[nodiscard]] bool done() const { return render_->done(); }
    [[nodiscard]] double share() const { return render_->share(); }
    /// Means [height, width, channels], the names of these, the samples of each pixel [height, width], and what a file says of the
    /// picture.
    [[nodiscard]] py::tuple film() const;
    /// Likewise, denoised: once, when the picture is there.
    [[nodiscard]] py::tuple denoised();
    void save(const std::string &path) const;
    void restore(const std::string &path);

  private:
    void checkCurrent() const;
    [[nodiscard]] Metadata metadataOf(const Film &film) const;

    std::shared_ptr<PythonScene> scene_;
    std::shared_ptr<const RenderScene> ready_;
    std::optional<FrameBefore> before_;
    std::unique_ptr<FrameRender> render_;
    std::shared_ptr<PythonDenoiser> denoiser_;
    double frame_ = 1;
    std::uint64_t change_ = 0;
};

} // namespace taut::python
