#include "session.h"

#include "../denoised_image.h"
#include "../image_output.h"
#include "inspect.h"
#include "panel.h"

#include "taut/base/file_bytes.h"
#include "taut/images/image_codec.h"
#include "taut/images/view_transform.h"
#include "taut/render/light_groups.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>

namespace taut::app {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// How long a request for a picture waits for a new one.
constexpr auto kPatience = std::chrono::seconds(20);
constexpr std::size_t kMostWaiters = 32;

} // namespace

ViewSession::ViewSession(const SceneArguments &scene, const ModelArguments &model, Warnings &warnings)
    : changes_(scene, warnings), frame_(changes_.scene().render.frames.front()), stages_{{LiveScene(model)}, {LiveScene(model)}} {
    preloadImageCodec();
    stages_[1].follows = false;
    fixedTouched_.everything = true;
    change({{"frame", frame_}});
    thread_ = std::thread([this] { run(); });
}

ViewSession::~ViewSession() {
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
        interrupt();
        waiters_.clear();
        tasks_.clear();
    }
    news_.notify_all();
    thread_.join();
}

Json ViewSession::change(const Json &request) {
    if (!request.is_object()) failInput({"change"}, request.type_name(), "an object");
    const RenderSettings &render = changes_.scene().render;
    int frame = frame_;
    if (request.contains("frame")) {
        if (!request["frame"].is_number_integer()) failInput({"frame"}, request["frame"].type_name(), "a whole number");
        const auto &frames = render.frames;
        const std::int64_t asked = request["frame"].get<std::int64_t>();
        if (std::find(frames.begin(), frames.end(), asked) == frames.end())
            failInput({"frame"}, std::to_string(asked), fmt::format("one of the scene's, {} to {}", frames.front(), frames.back()));
        frame = static_cast<int>(asked);
    }
    std::string channel = channel_;
    if (request.contains("channel")) {
        channel = request["channel"].is_string() ? request["channel"].get<std::string>() : "";
        if (!channel.empty()) filmContentsNamed({&channel, 1}, "channel");
    }
    for (const char *name : {"wipe", "denoise"})
        if (request.contains(name) && !request[name].is_boolean()) failInput({name}, request[name].type_name(), "true or false");
    Json undo = Json::array();
    if (request.contains("changes")) undo = changes_.apply(request["changes"], frame);
    if (const auto &frames = changes_.scene().render.frames; std::find(frames.begin(), frames.end(), frame) == frames.end())
        frame = frames.front(); // they have changed
    frame_ = frame;
    channel_ = channel;
    wipe_ = request.value("wipe", wipe_);
    denoise_ = request.value("denoise", denoise_);
    const Touched touched = changes_.takeTouched();
    fixedTouched_ += touched;
    // What nobody has taken yet is replaced, and must bring all that it would have brought: the first scene its environment.
    std::array<Touched, 2> brought{touched, fixedTouched_};
    {
        const std::lock_guard lock(mutex_);
        for (int i = 0; i < 2; ++i) brought[i] += wanted_.touched[i];
    }
    std::optional<Scene> scene;
    std::optional<Scene> fixed;
    if (touched.any()) scene = changes_.load(brought[0], true);
    if (wipe_ && fixedTouched_.any()) fixed = changes_.load(brought[1], false);
    {
        const std::lock_guard lock(mutex_);
        wanted_.version += 1;
        wanted_.frame = frame_;
        wanted_.wipe = wipe_;
        wanted_.denoise = denoise_;
        wanted_.channel = channel_;
        if (!isNew_) wanted_.since = Clock::now();
        if (scene) wanted_.scene[0] = std::move(scene);
        wanted_.touched[0] += touched;
        if (fixed) {
            wanted_.scene[1] = std::move(fixed);
            wanted_.touched[1] += std::exchange(fixedTouched_, {});
        }
        isNew_ = true;
        interrupt();
    }
    news_.notify_all();
    Json out = state();
    out["undo"] = undo;
    return out;
}

/// The scene's exposure and view, and whether the page has that by itself: which may take reading a configuration.
const Json &ViewSession::imageJson() {
    const ViewSettings &view = changes_.scene().image.view;
    if (!image_ || !(image_->first == view)) {
        const ViewTransform transform(view);
        image_ = {view, {{"exposure", view.exposure}, {"view", transform.view()}, {"own", transform.isOwnFormula()}}};
    }
    return image_->second;
}

Json ViewSession::state() {
    const Scene &scene = changes_.scene();
    Json overrides = Json::array();
    for (const auto &[key, text] : changes_.changed()) overrides.push_back({{"key", key}, {"text", text}});
    Json out{{"scene", changes_.arguments().scene},
             {"id", id_},
             {"frame", frame_},
             {"frames", scene.render.frames},
             {"fps", scene.render.fps},
             {"width", scene.render.width},
             {"height", scene.render.height},
             {"spp", scene.render.spp},
             {"wipe", wipe_},
             {"channel", channel_},
             {"denoise", denoise_},
             {"lights", lightGroupNames(scene)},
             {"image", imageJson()},
             {"camera", cameraOf(scene, frame_)},
             {"panel", panelOf(changes_, frame_)},
             {"changes", overrides}};
    const std::lock_guard lock(mutex_);
    out["version"] = wanted_.version;
    out["status"] = status_;
    return out;
}

void ViewSession::picture(bool follows, std::uint32_t after, HttpReply reply) {
    const std::lock_guard lock(mutex_);
    const Picture &newest = pictures_[follows ? 0 : 1];
    if (!newest.bytes.empty() && newest.label.number > after) return reply({200, kPictureType, newest.bytes});
    if (waiters_.size() >= kMostWaiters) {
        waiters_.front().reply({204, "text/plain", ""});
        waiters_.erase(waiters_.begin());
    }
    waiters_.push_back({follows, after, std::move(reply), Clock::now() + kPatience});
}

void ViewSession::inspect(double x, double y, HttpReply reply) {
    post(
        [this, x, y]() -> Json {
            if (!stages_[0].live.isThere()) return nullptr;
            return inspectPixel(stages_[0].live.ready(), x, y);
        },
        std::move(reply));
}

void ViewSession::save(const std::string &name, HttpReply reply) {
    const bool scene = name.ends_with(".toml");
    if (name.empty() || name.size() > 100 || name.front() == '.' || name.find_first_of("/\\") != std::string::npos ||
        name.find('\0') != std::string::npos || !(scene || isImagePath(name)))
        failInput({"save"}, quoted(name), "a plain file name that ends in .toml, .png or .exr");
    if (!scene) return post([this, name, settings = changes_.scene().image] { return saveFile(name, settings); }, std::move(reply));
    const std::string text = changes_.sceneText();
    post(
        [this, name, text] {
            const std::string path = (fs::path(changes_.arguments().scene).parent_path() / name).string();
            if (fs::exists(path) && std::find(written_.begin(), written_.end(), path) == written_.end())
                failInput({"save"}, path + ", which is there already", "a new name");
            writeTextFile(path, text);
            written_.push_back(path);
            return Json{{"path", path}, {"command", "taut render " + path}};
        },
        std::move(reply));
}

Json ViewSession::saveFile(const std::string &name, const ImageSettings &settings) {
    const std::string path = (fs::path(changes_.arguments().scene).parent_path() / name).string();
    if (fs::exists(path) && std::find(written_.begin(), written_.end(), path) == written_.end())
        failInput({"save"}, path + ", which is there already", "a new name");
    Stage &stage = stages_[0];
    if (!stage.frame) failInput({"save"}, "no picture yet", "one");
    const Film &film = stage.frame->filmAtRest();
    Metadata metadata = frameMetadata(stage.live.ready().scene(), now_.frame, film.layers());
    const Metadata ofSamples = sampleMetadata(film);
    metadata.insert(metadata.end(), ofSamples.begin(), ofSamples.end());
    if (stage.denoised) markDenoised(metadata, false);
    writeImage(path, stage.denoised ? *stage.denoised : imageOf(film, stage.live.ready().scene().render), metadata, settings);
    written_.push_back(path);
    return {{"path", path}, {"samples", film.samples()}};
}

void ViewSession::post(std::function<Json()> task, HttpReply reply) {
    {
        const std::lock_guard lock(mutex_);
        tasks_.push_back({std::move(task), std::move(reply)});
        interrupt();
    }
    news_.notify_all();
}

/// With the lock held: what renders looks up.
void ViewSession::interrupt() {
    if (running_ != nullptr) running_->stop();
}

} // namespace taut::app
