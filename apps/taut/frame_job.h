#pragma once
/// One frame of `taut render`, from wherever it was left to its end, with checkpoints on the way.

#include "interruption.h"
#include "progress.h"
#include "tev_display.h"

#include "taut/render/saved_frame.h"

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace taut::app {

using Clock = std::chrono::steady_clock; // a clock that is set back changes nothing

struct CheckpointOptions {
    std::optional<double> interval{};            ///< seconds between checkpoints; none: only when it is stopped
    bool resume = false;                         ///< go on from a checkpoint where there is one
    std::optional<Clock::time_point> deadline{}; ///< when to stop as if a signal came
};

struct FrameJob {
    FrameOptions options;
    std::string checkpoint;          ///< its path
    std::function<SavedHead()> head; ///< whose frame this is; called when something is read or saved, for it may read all files
    TevDisplay *display = nullptr;   ///< shows it while it goes on; null: nobody does
};

/// A frame on its way. Seconds, times and counts are those of all processes that worked on it.
class RunningFrame {
  public:
    /// Goes on from the checkpoint where that is asked for. Throws InputError where it is another frame's.
    RunningFrame(const RenderScene &scene, const FrameJob &job, const CheckpointOptions &options, Progress &progress);

    /// To the end, to a stop or to the deadline, with checkpoints; true at the end. Where the deadline is over already the frame gets
    /// further all the same, by a sample for every pixel, within a second.
    bool advance(const StopRequest &request);
    void stop() noexcept { frame_.stop(); }
    /// All that there is, to go on with or to merge. Throws RunError.
    void save(const std::string &path);

    [[nodiscard]] const Film &film() const { return frame_.filmAtRest(); }
    /// From any thread, while it goes on too.
    [[nodiscard]] Film filmSoFar() const { return frame_.film(); }
    [[nodiscard]] double share() const { return frame_.share(); }
    [[nodiscard]] double seconds() const;
    /// What adaptive sampling to the noise of the picture knows about it.
    [[nodiscard]] std::optional<PictureNoiseReached> reached() const { return frame_.reached(); }
    [[nodiscard]] StageTimes times() const;
    [[nodiscard]] RayCounts counts() const;

  private:
    const SavedHead &head();
    [[nodiscard]] FrameBudget budget() const;
    [[nodiscard]] FrameBudget budgetWhenLate() const;
    void tryCheckpoint();

    const FrameJob &job_;
    const CheckpointOptions &options_;
    Progress &progress_;
    FrameRender frame_;
    std::optional<SavedHead> head_;   ///< as of a frame that is not begun
    std::optional<SavedHead> before_; ///< of the checkpoint
    Clock::time_point written_;       ///< when the last checkpoint was, or the begin
};

struct FrameEnd {
    bool done = false;
    const char *cause = nullptr; ///< of stopping here: the name of a signal, or the limit of time; null: go on
    double secondsLate = 0;      ///< by which the limit of time was over before the first sample
};

/// Renders the frame. Where it is stopped it leaves a checkpoint, and tells so. `finish` writes what it ends in, before a signal can end
/// the process; then the checkpoint is removed. Throws RunError where a checkpoint can't be written when it is stopped.
FrameEnd runFrame(const RenderScene &scene, const FrameJob &job, const CheckpointOptions &options, Progress &progress,
                  const std::function<void(RunningFrame &)> &finish);

} // namespace taut::app
