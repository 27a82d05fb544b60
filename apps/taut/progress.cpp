#include "progress.h"

#include "json_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>

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
    if (style_ != ProgressStyle::Bar && style_ != ProgressStyle::Json) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - lastPrint_ < kInterval) return;
    lastPrint_ = now;
    const double share = (done_ + shareOfFrame) / frames_;
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

void Progress::finishFrame(int frame, const std::string &output, double seconds) {
    ++done_;
    switch (style_) {
    case ProgressStyle::None: break;
    case ProgressStyle::Json:
        std::cerr << jsonText({{"event", "frame"}, {"frame", frame}, {"output", output}, {"seconds", seconds}}, -1) << std::endl;
        break;
    case ProgressStyle::Bar: fmt::print(stderr, "\r{:78}\r", ""); [[fallthrough]];
    case ProgressStyle::Plain: fmt::print(stderr, "frame {} ({}/{}) {:.2f} s -> {}\n", frame, done_, frames_, seconds, output); break;
    }
}

} // namespace taut::app
