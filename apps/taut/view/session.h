#pragma once
/// What `taut view` shows: a scene with its changes, and a thread that renders what was asked for last. A change first has a coarse
/// picture, then one sample a pixel, then more until the scene's samples are there; then the bits are those of `taut render`.

#include "http_server.h"
#include "picture.h"
#include "scene_changes.h"

#include "taut/images/image_settings.h"
#include "taut/render/frame_render.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace taut::app {

/// Content-Type of a picture.
inline constexpr const char *kPictureType = "application/octet-stream";

class ViewSession {
  public:
    /// Reads the scene and begins to render it. Throws InputError.
    ViewSession(const SceneArguments &scene, const ModelArguments &model, Warnings &warnings);
    ~ViewSession();
    ViewSession(const ViewSession &) = delete;
    ViewSession &operator=(const ViewSession &) = delete;

    // All but the tasks' answers: on the server's thread.

    /// What there is to know for a page: docs/view.md lists it.
    nlohmann::json state();
    /// {"changes": [...], "frame": N, "wipe": bool, "channel": "stretch", "denoise": bool}, each where it changes; state(), with "undo".
    /// Throws InputError.
    nlohmann::json change(const nlohmann::json &request);
    /// The scene's view transform (viewTable).
    [[nodiscard]] std::string viewOfScene() const { return viewTable(changes_.scene().image.view); }
    /// Replies with the newest picture as soon as its number is beyond `after`; 204 where that takes long.
    void picture(bool follows, std::uint32_t after, HttpReply reply);
    /// Runs between two samples of the picture, on the thread that renders.
    void inspect(double x, double y, HttpReply reply);
    /// Writes scene or picture, by the name's ending, into the scene's folder; {"path", "command"}. A file that is not the session's own is
    /// not replaced. Throws InputError.
    void save(const std::string &name, HttpReply reply);

  private:
    using Clock = std::chrono::steady_clock;

    /// A scene that is shown, and the frame of it under way.
    struct Stage {
        LiveScene live;
        std::unique_ptr<FrameRender> frame{};
        bool follows = true;
        int number = 0;                  ///< of the frame under way
        std::string channel{};           ///< of it
        bool denoise = false;            ///< whether it keeps what that takes
        std::optional<Image> denoised{}; ///< once it is whole
        int shown = 0;                   ///< samples of the last picture
        bool done = false;               ///< the last picture is whole and planned for
    };
    struct Wanted {
        std::uint32_t version = 0;
        int frame = 1;
        bool wipe = false;
        bool denoise = false;
        std::string channel;
        std::optional<Scene> scene[2]; ///< following, held fixed: those that changed
        Touched touched[2];
        Clock::time_point since{};
    };
    struct Waiter {
        bool follows;
        std::uint32_t after;
        HttpReply reply;
        Clock::time_point until;
    };
    struct Task {
        std::function<nlohmann::json()> run;
        HttpReply reply;
    };

    void run();
    bool takeWanted();
    void beginVersion();
    void beginFrame(Stage &stage);
    void coarse(Stage &stage);
    void refine();
    void advance(Stage &stage, int samples);
    bool settle();
    void runTasks();
    void show(Stage &stage, const Film &film, bool whole);
    void wait();
    [[nodiscard]] bool isOutdated();
    void interrupt();
    void post(std::function<nlohmann::json()> task, HttpReply reply);
    const nlohmann::json &imageJson();
    nlohmann::json saveFile(const std::string &name, const ImageSettings &settings);
    [[nodiscard]] Image imageOfStage(Stage &stage, const Film &film, bool whole) const;
    [[nodiscard]] FrameOptions optionsOf(const RenderSettings &render) const;

    // The server's thread.
    SceneChanges changes_;
    int frame_ = 1;
    bool wipe_ = false;
    bool denoise_ = false;
    std::string channel_;
    Touched fixedTouched_; ///< since the scene held fixed was last read
    std::string id_ = randomToken();
    std::optional<std::pair<ViewSettings, nlohmann::json>> image_; ///< what was last said of it

    // Between both.
    std::mutex mutex_;
    std::condition_variable news_;
    Wanted wanted_;
    bool isNew_ = false;
    bool quit_ = false;
    FrameRender *running_ = nullptr;
    std::deque<Task> tasks_;
    std::vector<Waiter> waiters_;
    Picture pictures_[2];
    std::uint32_t number_ = 0;
    nlohmann::json status_;

    // The thread that renders.
    Wanted now_;
    Stage stages_[2];
    int coarseness_ = 4;
    std::vector<std::string> written_;
    std::thread thread_;
};

} // namespace taut::app
