#include "frame_job.h"

#include "taut/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace taut::app {

namespace {

double secondsUntil(Clock::time_point time) {
    return std::chrono::duration<double>(time - Clock::now()).count();
}

FrameOptions withProgress(const FrameJob &job, Progress &progress) {
    FrameOptions told = job.options;
    told.progress = [&progress](double share) {
        progress.update(share);
        return true;
    };
    return told;
}

} // namespace

RunningFrame::RunningFrame(const RenderScene &scene, const FrameJob &job, const CheckpointOptions &options, Progress &progress)
    : job_(job), options_(options), progress_(progress), frame_(scene, withProgress(job, progress)), written_(Clock::now()) {
    if (!options.resume || !std::filesystem::exists(job.checkpoint)) return;
    before_ = resumeSavedFrame(job.checkpoint, head(), frame_);
    progress.tell("resumed", share(), job.checkpoint);
}

bool RunningFrame::advance(const StopRequest &request) {
    const bool late = options_.deadline && secondsUntil(*options_.deadline) <= 0;
    for (FrameBudget next = late ? budgetWhenLate() : budget();; next = budget()) {
        const FrameState state = frame_.advance(next);
        if (state == FrameState::Done || (job_.options.seconds && seconds() >= *job_.options.seconds)) return true;
        if (request.signal() != nullptr || (options_.deadline && secondsUntil(*options_.deadline) <= 0)) return false;
        if (options_.interval && secondsUntil(written_) <= -*options_.interval) tryCheckpoint();
    }
}

void RunningFrame::save(const std::string &path) {
    SavedHead now = head();
    now.done = frame_.done();
    now.seconds = seconds();
    now.times = times();
    now.counts = counts();
    writeSavedFrame(path, now, frame_);
}

double RunningFrame::seconds() const {
    return frame_.seconds() + (before_ ? before_->seconds : 0);
}

StageTimes RunningFrame::times() const {
    StageTimes times = frame_.times();
    if (before_) times += before_->times;
    return times;
}

RayCounts RunningFrame::counts() const {
    RayCounts counts = frame_.counts();
    if (before_) counts += before_->counts;
    return counts;
}

const SavedHead &RunningFrame::head() {
    if (!head_) head_ = job_.head();
    return *head_;
}

/// Up to what comes first: the next checkpoint, the deadline, the next look at the time that the frame may take.
FrameBudget RunningFrame::budget() const {
    FrameBudget budget;
    budget.evenly = false;
    const auto shorten = [&](double left) {
        left = std::max(left, 1e-3);
        budget.seconds = budget.seconds > 0 ? std::min(budget.seconds, left) : left;
    };
    if (options_.interval) shorten(*options_.interval + secondsUntil(written_));
    if (options_.deadline) shorten(secondsUntil(*options_.deadline));
    if (job_.options.seconds) budget.samples = kTimedPass;
    return budget;
}

/// However often a limit that is shorter than what comes before the first sample stops the frame, it comes to its end.
FrameBudget RunningFrame::budgetWhenLate() const {
    FrameBudget budget;
    budget.evenly = false;
    budget.samples = 1;
    budget.seconds = 1;
    return budget;
}

/// Between two stretches of work: what goes wrong is told, and the work goes on.
void RunningFrame::tryCheckpoint() {
    try {
        save(job_.checkpoint);
        progress_.tell("checkpoint", share(), job_.checkpoint);
    } catch (const RunError &error) {
        std::cerr << "taut: warning: no checkpoint: " << error.what() << std::endl;
    }
    written_ = Clock::now();
}

FrameEnd runFrame(const RenderScene &scene, const FrameJob &job, const CheckpointOptions &options, Progress &progress,
                  const std::function<void(RunningFrame &)> &finish) {
    RunningFrame frame(scene, job, options, progress);
    const std::string shownAs = fmt::format("{} {}", std::filesystem::path(scene.scene().path).filename().string(), progress.frame());
    if (job.display != nullptr) {
        const RenderSettings &render = scene.scene().render;
        job.display->create(shownAs, render.width, render.height, frame.film().channelNames());
    }
    const DisplayFeed feed(job.display, shownAs, [&] { return frame.filmSoFar(); });
    const StopRequest request([&] { frame.stop(); });
    const double late = options.deadline ? std::max(0.0, -secondsUntil(*options.deadline)) : 0;
    if (!frame.advance(request)) {
        const char *cause = request.signal() != nullptr ? request.signal() : "--time-limit";
        frame.save(job.checkpoint);
        progress.stopped(cause, frame.share(), job.checkpoint);
        return {false, cause, late};
    }
    finish(frame);
    std::error_code ignored;
    if (options.resume || options.interval) std::filesystem::remove(job.checkpoint, ignored);
    return {true, request.signal(), late};
}

} // namespace taut::app
