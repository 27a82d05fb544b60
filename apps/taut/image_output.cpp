#include "image_output.h"

#include "denoised_image.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace taut::app {

void checkOutputs(const std::vector<std::string> &outputs, std::size_t frames) {
    for (const std::string &output : outputs) {
        if (!isImagePath(output))
            failInput({"-o"}, quoted(output), "a file name that ends in .exr or .png (of taut render: or .mp4, .webm, .gif)");
        if (frames > 1 && !hasFramePattern(output))
            failInput({"-o"}, quoted(output), "a frame number such as #### in the name, for more than one frame");
    }
}

std::vector<std::string> pathsOf(const std::vector<std::string> &outputs, int frame) {
    std::vector<std::string> paths;
    for (const std::string &output : outputs) paths.push_back(pathOfFrame(output, frame));
    return paths;
}

bool areThere(const std::vector<std::string> &paths) {
    return std::all_of(paths.begin(), paths.end(), [](const std::string &path) {
        std::error_code error;
        return std::filesystem::is_regular_file(path, error);
    });
}

void checkWritable(const std::string &path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return; // a pipe is opened once
    makeFolderOf(path);
    const OutputFile trial(path);
}

void writeImages(const SavedHead &head, const Film &film, const std::vector<std::string> &paths, FrameDenoiser *denoiser) {
    Image image{film.window(), head.width, head.height, film.channelNames(), film.resolve()};
    if (denoiser != nullptr) addDenoised(film, *denoiser, image);
    Metadata metadata = head.metadata;
    metadata.emplace_back("taut:spp", std::to_string(film.samples()));
    metadata.emplace_back("taut:meanSpp", fmt::format("{:.3f}", film.meanSamples()));
    metadata.emplace_back("taut:sampleRange", fmt::format("0-{}", film.samples() - 1));
    for (const std::string &path : paths) writeImage(path, image, metadata, head.image);
}

} // namespace taut::app
