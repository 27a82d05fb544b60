#include "progress.h"

#include "json_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>
#include <string_view>

namespace taut::app {

namespace {

constexpr auto kInterval = std::chrono::milliseconds(200);

std::string duration(double seconds) {
    const auto whole = static_cast<long long>(seconds + 0.5);
    return whole >= 3600 ? fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
                         : fmt::format("{}:{:02}", whole / 60, whole % 60);
}

} // namespace

Progress::Progress(ProgressStyle style, int frames)
    : style_(style), frames_(frames), start_(std::chrono::steady_clock::now()), lastPrint_(start_) {}

void Progress::startFrame(int frame) {
    frame_ = frame;
}

void Progress::update(double shareOfFrame) {
    if (style_ == ProgressStyle::None || style_ == ProgressStyle::Plain) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - lastPrint_ < kInterval) return;
    lastPrint_ = now;
    const double share = (done_ + shareOfFrame) / frames_;
    if (style_ == ProgressStyle::OpenJobDescription) {
        std::cout << fmt::format("openjd_progress: {:.2f}", 100 * share) << std::endl;
        return;
    }
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double left = share > 0 ? elapsed * (1 - share) / share : 0;
    if (style_ == ProgressStyle::Json) {
        std::cerr << nlohmann::json{{"event", "progress"}, {"frame", frame_}, {"share", share}, {"eta_s", left}}.dump() << std::endl;
        return;
    }
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(share * kWidth);
    fmt::print(stderr, "\rframe {} [{:=<{}}{:{}}] {:3.0f}%  left {} ", frame_, "", filled, "", kWidth - filled, 100 * share,
               duration(left));
    std::fflush(stderr);
}

void Progress::finishFrame(int frame, const std::string &output, double seconds, const std::string &reached) {
    ++done_;
    switch (style_) {
    case ProgressStyle::None: break;
    case ProgressStyle::Json:
        std::cerr << jsonText({{"event", "frame"}, {"frame", frame}, {"output", output}, {"seconds", seconds}}, -1) << std::endl;
        break;
    case ProgressStyle::OpenJobDescription:
        std::cout << fmt::format("openjd_progress: {:.2f}\nopenjd_status: frame {} of {} in {}", 100.0 * done_ / frames_, done_, frames_,
                                 output)
                  << std::endl;
        break;
    case ProgressStyle::Bar: fmt::print(stderr, "\r{:78}\r", ""); [[fallthrough]];
    case ProgressStyle::Plain:
        fmt::print(stderr, "frame {} ({}/{}) {:.2f} s{}{} -> {}\n", frame, done_, frames_, seconds, reached.empty() ? "" : ", ", reached, output);
        break;
    }
}

void Progress::tell(const char *event, double shareOfFrame, const std::string &path) {
    if (std::string_view(event) == "skipped") ++done_;
    switch (style_) {
    case ProgressStyle::None: break;
    case ProgressStyle::Json:
        std::cerr << jsonText({{"event", event}, {"frame", frame_}, {"share", shareOfFrame}, {"file", path}}, -1) << std::endl;
        break;
    case ProgressStyle::OpenJobDescription: std::cout << fmt::format("openjd_status: frame {} {}", frame_, event) << std::endl; break;
    case ProgressStyle::Bar: fmt::print(stderr, "\r{:78}\r", ""); [[fallthrough]];
    case ProgressStyle::Plain:
        fmt::print(stderr, "frame {}: {} at {:.0f} %: {}\n", frame_, event, 100 * shareOfFrame, path); break;
    }
}

void Progress::stopped(const char *cause, double shareOfFrame, const std::string &checkpoint) {
    if (style_ == ProgressStyle::Json) {
        const nlohmann::json file = checkpoint.empty() ? nlohmann::json() : nlohmann::json(checkpoint);
        std::cerr << jsonText({{"event", "stopped"}, {"cause", cause}, {"frame", frame_}, {"share", shareOfFrame}, {"checkpoint", file}},
                              -1)
                  << std::endl;
        return;
    }
    if (style_ == ProgressStyle::Bar) fmt::print(stderr, "\r{:78}\r", "");
    const std::string where = checkpoint.empty() ? "" : fmt::format(" at {:.0f} %: {}", 100 * shareOfFrame, checkpoint);
    fmt::print(stderr, "taut: stopped by {}: frame {}{}; --resume --skip-existing goes on\n", cause, frame_, where);
}

} // namespace taut::app
