/// The thread of a session that renders.

#include "session.h"

#include "../denoised_image.h"

#include <algorithm>
#include <iostream>

namespace taut::app {

namespace {

using Json = nlohmann::json;

/// Without a change for so long, the plan is made for what there is.
constexpr double kStillness = 0.25; // seconds
/// Of the coarse picture, in seconds: beyond it the next is coarser, well below it finer.
constexpr double kCoarseTime = 0.04;
constexpr int kCoarsest = 8;
/// Samples between two looks at what else there is to do.
constexpr int kMostSamples = 8;

HttpResponse jsonResponse(unsigned status, const Json &value) {
    return {status, "application/json", value.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

bool ViewSession::isOutdated() {
    const std::lock_guard lock(mutex_);
    return isNew_ || quit_;
}

bool ViewSession::takeWanted() {
    const std::lock_guard lock(mutex_);
    if (!isNew_) return false;
    now_.version = wanted_.version;
    now_.frame = wanted_.frame;
    now_.wipe = wanted_.wipe;
    now_.denoise = wanted_.denoise;
    now_.channel = wanted_.channel;
    now_.since = wanted_.since;
    for (int i = 0; i < 2; ++i) {
        now_.scene[i] = std::exchange(wanted_.scene[i], std::nullopt);
        now_.touched[i] = std::exchange(wanted_.touched[i], {});
    }
    isNew_ = false;
    return true;
}

void ViewSession::run() {
    while (true) {
        {
            const std::lock_guard lock(mutex_);
            if (quit_) return;
        }
        try {
            runTasks();
            if (takeWanted()) beginVersion();
            refine();
            if (!isOutdated()) wait();
        } catch (const std::exception &error) {
            std::cerr << "taut: error: " << error.what() << std::endl;
            const std::lock_guard lock(mutex_);
            status_ = {{"error", error.what()}, {"version", now_.version}};
            for (Stage &stage : stages_) stage.frame.reset();
        }
    }
}

void ViewSession::beginVersion() {
    for (int i = 0; i < 2; ++i) {
        Stage &stage = stages_[i];
        if (i > 0 && !now_.wipe) {
            stage.frame.reset();
            continue;
        }
        if (stage.frame && !now_.scene[i] && stage.number == now_.frame && stage.channel == now_.channel &&
            stage.denoise == now_.denoise) { // it goes on
            if (stage.done) show(stage, stage.frame->filmAtRest(), true);
            continue;
        }
        stage.frame.reset();
        if (now_.scene[i]) stage.live.take(std::move(*now_.scene[i]), now_.touched[i]);
        now_.scene[i].reset();
        stage.number = now_.frame;
        stage.channel = now_.channel;
        stage.denoise = now_.denoise;
        stage.shown = 0;
        stage.done = false;
        stage.live.ready().setFrame(now_.frame);
        coarse(stage);
    }
    for (int i = 0; i < (now_.wipe ? 2 : 1); ++i)
        if (!stages_[i].frame) beginFrame(stages_[i]);
}

/// As `taut render` does it.
FrameOptions ViewSession::optionsOf(const RenderSettings &render) const {
    FrameOptions options;
    options.spp = render.spp;
    options.seed = frameSeed(render.seed, now_.frame, render.fixedSeed);
    if (now_.channel.empty()) return options;
    FilmContents contents = filmContentsNamed({&now_.channel, 1}, "channel");
    options.aovs = std::move(contents.aovs);
    options.layers = std::move(contents.layers);
    return options;
}

void ViewSession::beginFrame(Stage &stage) {
    const RenderSettings &render = stage.live.ready().scene().render;
    FrameOptions options = optionsOf(render);
    if (stage.denoise) options.denoiseBlock = denoiseBlockOf(render.spp, true);
    stage.denoised.reset();
    stage.frame = std::make_unique<FrameRender>(stage.live.ready(), options);
}

/// One sample for each of fewer pixels. It is not interrupted: while changes come without a pause, it is what is seen of them.
void ViewSession::coarse(Stage &stage) {
    RenderScene &ready = stage.live.ready();
    const RenderSettings &render = ready.scene().render;
    const int width = render.width;
    const int height = render.height;
    const auto start = Clock::now();
    ready.setSize((width + coarseness_ - 1) / coarseness_, (height + coarseness_ - 1) / coarseness_);
    FrameOptions options = optionsOf(render);
    options.spp = 1;
    const FrameResult result = renderFrame(ready, options);
    ready.setSize(width, height);
    show(stage, result.film, false);
    const double seconds = secondsSince(start);
    if (seconds > kCoarseTime) coarseness_ = std::min(2 * coarseness_, kCoarsest);
    if (seconds < kCoarseTime / 6) coarseness_ = std::max(coarseness_ / 2, 1);
}

void ViewSession::refine() {
    while (!isOutdated()) {
        bool goesOn = false;
        for (Stage &stage : stages_) {
            if (!stage.frame || stage.done) continue;
            if (!stage.frame->done()) advance(stage, std::clamp(stage.shown, 1, kMostSamples));
            goesOn |= !stage.frame->done();
            runTasks();
            if (isOutdated()) return;
        }
        if (secondsSince(now_.since) > kStillness && settle()) continue;
        if (!goesOn) return;
    }
}

void ViewSession::advance(Stage &stage, int samples) {
    {
        const std::lock_guard lock(mutex_);
        if (isNew_ || quit_ || !tasks_.empty()) return;
        running_ = stage.frame.get();
    }
    const FrameState state = stage.frame->advance({.samples = samples});
    {
        const std::lock_guard lock(mutex_);
        running_ = nullptr;
    }
    if (state == FrameState::Stopped) return;
    const Film &film = stage.frame->filmAtRest();
    const bool whole = stage.frame->done() && stage.live.isSettled();
    // Twice the samples are worth a new picture; so is the end.
    if (film.samples() >= 2 * stage.shown || whole) show(stage, film, whole);
}

/// Plans for what is shown; true where something begins anew.
bool ViewSession::settle() {
    bool again = false;
    for (Stage &stage : stages_) {
        if (!stage.frame) continue;
        if (!stage.live.isSettled() && stage.live.settle()) {
            stage.frame.reset();
            stage.live.ready().setFrame(now_.frame);
            beginFrame(stage);
            again = true;
        } else if (stage.frame->done() && !stage.done) {
            show(stage, stage.frame->filmAtRest(), true);
        }
    }
    return again;
}

/// What is seen of a film. The whole picture is denoised, where that is asked for, once.
Image ViewSession::imageOfStage(Stage &stage, const Film &film, bool whole) const {
    Image image = imageOf(film, stage.live.ready().scene().render);
    if (!whole || !stage.denoise) return image;
    if (!stage.denoised) {
        FrameDenoiser denoiser(false);
        stage.denoised = image;
        addDenoised(film, denoiser, *stage.denoised);
    }
    const std::size_t stride = stage.denoised->channels.size();
    const std::size_t plain = image.channels.size();
    for (std::size_t i = 0; i * plain < image.values.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) image.values[i * plain + c] = stage.denoised->values[i * stride + c];
    return image;
}

void ViewSession::show(Stage &stage, const Film &film, bool whole) {
    const RenderSettings &render = stage.live.ready().scene().render;
    Picture picture;
    PictureLabel &label = picture.label;
    label.version = now_.version;
    label.frame = now_.frame;
    label.follows = stage.follows;
    label.width = render.width;
    label.height = render.height;
    label.samples = film.samples();
    label.wanted = render.spp;
    label.done = whole;
    const bool isFull = film.window().width() == render.width && film.window().height() == render.height;
    if (stage.shown == 0 && !stage.frame) label.milliseconds = static_cast<float>(1000 * secondsSince(now_.since));
    if (isFull) stage.shown = std::max(stage.shown, film.samples());
    stage.done = whole;
    {
        const std::lock_guard lock(mutex_);
        label.number = ++number_;
    }
    picture.bytes = pictureBytes(imageOfStage(stage, film, whole), label);
    bool allDone = whole;
    for (const Stage &other : stages_) allDone = allDone && (!other.frame || other.done);
    const std::lock_guard lock(mutex_);
    status_ = {{"version", label.version},
               {"samples", label.samples},
               {"done", allDone},
               {"built", stages_[0].live.built()},
               {"seconds", stage.frame ? stage.frame->seconds() : 0.0}};
    Picture &newest = pictures_[stage.follows ? 0 : 1];
    newest = std::move(picture);
    std::erase_if(waiters_, [&](Waiter &waiter) {
        if (waiter.follows != stage.follows || newest.label.number <= waiter.after) return false;
        waiter.reply({200, kPictureType, newest.bytes});
        return true;
    });
}

void ViewSession::runTasks() {
    while (true) {
        Task task;
        {
            const std::lock_guard lock(mutex_);
            if (tasks_.empty()) return;
            task = std::move(tasks_.front());
            tasks_.pop_front();
        }
        try {
            task.reply(jsonResponse(200, task.run()));
        } catch (const std::exception &error) {
            task.reply(jsonResponse(400, {{"error", error.what()}}));
        }
    }
}

void ViewSession::wait() {
    std::unique_lock lock(mutex_);
    bool allDone = true;
    for (const Stage &stage : stages_) allDone = allDone && (!stage.frame || stage.done);
    const auto pause = allDone ? std::chrono::milliseconds(1000) : std::chrono::milliseconds(50);
    news_.wait_for(lock, pause, [&] { return isNew_ || quit_ || !tasks_.empty(); });
    const auto now = Clock::now();
    std::erase_if(waiters_, [&](Waiter &waiter) {
        if (waiter.until > now) return false;
        waiter.reply({204, "text/plain", ""});
        return true;
    });
}

} // namespace taut::app
