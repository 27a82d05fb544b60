#include "denoised_image.h"

#include <algorithm>

namespace taut::app {

namespace {

constexpr const char *kMark = "taut:denoised";
constexpr const char *kOverFrames = "over frames";

} // namespace

void addDenoised(const Film &film, FrameDenoiser &denoiser, Image &image) {
    const Denoised denoised = denoiser.next(film);
    const std::size_t before = image.channels.size();
    const std::size_t after = before + 4;
    std::vector<float> values;
    values.reserve(denoised.error.size() * after);
    for (std::size_t i = 0; i < denoised.error.size(); ++i) {
        const auto pixel = image.values.begin() + static_cast<std::ptrdiff_t>(i * before);
        values.insert(values.end(), denoised.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i),
                      denoised.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
        values.insert(values.end(), pixel + 3, pixel + static_cast<std::ptrdiff_t>(before));
        values.insert(values.end(), pixel, pixel + 3);
        values.push_back(denoised.error[i]);
    }
    image.values = std::move(values);
    for (const char *name : {"Noisy.R", "Noisy.G", "Noisy.B", "DenoiseError"}) image.channels.emplace_back(name);
}

void markDenoised(Metadata &metadata, bool overFrames) {
    metadata.emplace_back(kMark, overFrames ? kOverFrames : "by itself");
}

std::optional<FrameDenoiser> denoiserOf(const SavedHead &head) {
    const auto mark = std::find_if(head.metadata.begin(), head.metadata.end(), [](const auto &entry) { return entry.first == kMark; });
    if (mark == head.metadata.end()) return std::nullopt;
    return FrameDenoiser(mark->second == kOverFrames);
}

} // namespace taut::app
