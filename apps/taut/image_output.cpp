#include "image_output.h"

#include "denoised_image.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"
#include "taut/render/image_file.h"
#include "taut/render/light_groups.h"

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

Metadata frameMetadata(const Scene &scene, double frame, const FilmLayers &layers) {
    Metadata metadata{
        {"taut:version", TAUT_VERSION}, {"taut:seed", std::to_string(scene.render.seed)}, {"taut:frame", formatNumber(frame)}};
    const Metadata mattes = matteMetadata(scene, layers);
    metadata.insert(metadata.end(), mattes.begin(), mattes.end());
    return metadata;
}

Metadata sampleMetadata(const Film &film) {
    return {{"taut:spp", std::to_string(film.samples())},
            {"taut:meanSpp", fmt::format("{:.3f}", film.meanSamples())},
            {"taut:sampleRange", fmt::format("0-{}", film.samples() - 1)}};
}

void writeImages(const SavedHead &head, const Film &film, const std::vector<std::string> &paths, FrameDenoiser *denoiser) {
    Image image{film.window(), head.width, head.height, film.channelNames(), film.resolve()};
    if (denoiser != nullptr) addDenoised(film, *denoiser, image);
    Metadata metadata = head.metadata;
    const Metadata ofSamples = sampleMetadata(film);
    metadata.insert(metadata.end(), ofSamples.begin(), ofSamples.end());
    for (const std::string &path : paths) writeImage(path, image, metadata, head.image);
}

} // namespace taut::app
