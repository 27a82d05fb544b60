#pragma once
/// A small scene for tests of the command, and what is asked of a run and of the images that it leaves.

#include "command.h"

#include "taut/base/file_bytes.h"
#include "taut/images/image_codec.h"
#include "taut/render/image_file.h"

namespace taut::test {

inline constexpr double kShear = 1.2; ///< of the sheared plate at frame 3

/// A plate that is sheared from frame 1 to frame 3, seen from above.
inline std::string plateScene() {
    return "[render]\nwidth = 24\nheight = 16\nspp = 4\nmax_events = 3\nframes = \"1\"\n"
           "[camera]\nposition = [0.1, -1.6, 1.8]\nlook_at = [0, 0, 0]\nfov_deg = 45\n"
           "[environment]\nradiance = [0.5, 0.6, 0.7]\ncamera_visible = false\n"
           "[[light]]\ntype = \"quad\"\ncorner = [-0.5, 0.8, 1]\nu = [1, 0, 0]\nv = [0, 0, 1]\nradiance = [5, 5, 5]\ntwo_sided = true\n"
           "[material.brushed]\ntype = \"conductor\"\nmetal = \"Al\"\nalpha = [0.1, 0.4]\n"
           "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR "/meshes/plate.obj\"\nmaterial = \"brushed\"\n"
           "[[mesh.deform]]\ntype = \"shear\"\nplane = \"xy\"\namount = [[1, 0.0], [3, 1.2]]\n";
}

/// A folder with plate.toml in it.
struct Workplace {
    std::string folder;
    std::string scene;
    explicit Workplace(const std::string &name) : folder(freshFolder("cli_" + name)), scene(folder + "/plate.toml") {
        writeBytes(scene, plateScene());
    }
    [[nodiscard]] std::string path(const std::string &file) const { return folder + "/" + file; }
};

inline void requireSuccess(const CommandResult &result) {
    INFO(result.err);
    REQUIRE(result.exitCode == 0);
}

/// Exit 2, nothing on standard output, and one error line with `part` in it.
inline void checkUsageError(const CommandResult &result, const std::string &part) {
    INFO(result.out << result.err);
    CHECK(result.exitCode == 2);
    CHECK(result.out.empty());
    CHECK(errorLine(result).find("taut: error: ") == 0);
    CHECK(errorLine(result).find(part) != std::string::npos);
}

inline std::string metadata(const std::string &path, const std::string &key) {
    const std::string bytes = readBytes(path);
    const ImagePart part = imageCodec().open(lowerExtension(path) == "png" ? "png" : "openexr", bytes, path)->parts(false).at(0);
    for (const auto &[name, value] : part.attributes)
        if (name == key) return value;
    return "absent";
}

inline std::size_t channelOf(const Image &image, const std::string &name) {
    const auto found = std::find(image.channels.begin(), image.channels.end(), name);
    if (found == image.channels.end()) throw std::logic_error("no channel " + name);
    return static_cast<std::size_t>(found - image.channels.begin());
}

/// One channel of a pixel, counted from the window's corner.
inline double valueAt(const Image &image, int x, int y, const std::string &channel) {
    const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.window.width()) + static_cast<std::size_t>(x);
    return static_cast<double>(image.values[pixel * image.channels.size() + channelOf(image, channel)]);
}

inline double meanOf(const Image &image, const std::string &channel) {
    double sum = 0;
    for (int y = 0; y < image.window.height(); ++y)
        for (int x = 0; x < image.window.width(); ++x) sum += valueAt(image, x, y, channel);
    return sum / image.window.width() / image.window.height();
}

inline std::vector<float> renderedValues(const Workplace &place, const std::string &name, const Arguments &more) {
    Arguments arguments{"render", place.scene, "-o", place.path(name), "-q"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    requireSuccess(runTaut(arguments));
    return readImage(place.path(name)).values;
}

} // namespace taut::test
