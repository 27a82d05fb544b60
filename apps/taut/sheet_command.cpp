/// taut sheet: pictures -> one picture that shows them side by side, with their names.

#include "commands.h"
#include "contact_sheet.h"
#include "dot_letters.h"
#include "image_arguments.h"

#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace taut::app {

namespace {

struct SheetArguments {
    std::vector<std::string> images;
    std::string frames;
    std::string output;
    SheetLayout layout;
    std::vector<std::string> labels;
    bool noLabels = false;
    ImageArguments image;
};

/// More pixels than anyone looks at, in one picture.
constexpr double kMostPixels = 4e8;

/// The files, in their order: patterns stand for the frames that are asked for.
std::vector<std::string> pathsOf(const SheetArguments &arguments) {
    if (arguments.frames.empty()) return arguments.images;
    std::vector<std::string> paths;
    const std::vector<int> frames = parseFrameSet(arguments.frames, {"--frames"});
    for (const std::string &image : arguments.images) {
        if (!hasFramePattern(image)) failInput({"--frames"}, quoted(image) + " without a frame number", "names such as out/####.png");
        for (const int frame : frames) paths.push_back(pathOfFrame(image, frame));
    }
    return paths;
}

/// File names without what they all end in; with their folder where two are alike.
std::vector<std::string> namesOf(const std::vector<std::string> &paths) {
    std::vector<std::string> names;
    for (const std::string &path : paths) names.push_back(std::filesystem::path(path).stem().string());
    if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const std::string folder = std::filesystem::path(paths[i]).parent_path().filename().string();
        if (!folder.empty()) names[i] = folder + "/" + names[i];
    }
    return names;
}

int sheet(const SheetArguments &arguments) {
    if (lowerExtension(arguments.output) != "png") failInput({"-o"}, quoted(arguments.output), "a file name that ends in .png");
    const std::vector<std::string> paths = pathsOf(arguments);
    if (!arguments.labels.empty() && arguments.labels.size() != paths.size())
        failInput({"--label"}, std::to_string(arguments.labels.size()) + " labels",
                  "one for each of " + std::to_string(paths.size()) + " pictures");
    static const ImageSettings kDefault;
    const ImageSettings settings = imageSettingsOf(arguments.image, kDefault, {arguments.output});
    const ViewTransform view(settings.view);
    const std::vector<std::string> names = arguments.labels.empty() ? namesOf(paths) : arguments.labels;
    std::vector<SheetPicture> pictures;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        SheetPicture picture = readSheetPicture(paths[i], view);
        const double scale = static_cast<double>(arguments.layout.cellWidth) / picture.width;
        if (scale < 1) // what a cell shows of it is kept, not all of it
            picture = reduced(picture, arguments.layout.cellWidth, std::max(1, static_cast<int>(std::lround(scale * picture.height))));
        if (!arguments.noLabels) picture.label = drawable(names[i]);
        pictures.push_back(std::move(picture));
    }
    const SheetGrid grid = gridOf(pictures, arguments.layout);
    if (static_cast<double>(grid.width()) * grid.height() > kMostPixels)
        failInput({arguments.output}, "a sheet of " + std::to_string(grid.width()) + " x " + std::to_string(grid.height()) + " pixels",
                  "a smaller --cell");
    ImageSettings stored = kDefault; // the view is in its pictures already
    stored.pngBits = settings.pngBits;
    writeImage(arguments.output, contactSheet(pictures, grid), view.applied(), stored);
    return 0;
}

} // namespace

void addSheet(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<SheetArguments>();
    CLI::App *command = parent.add_subcommand("sheet", "A contact sheet: pictures side by side, with their names");
    command->add_option("images", arguments->images, "PNG or EXR, in the order of the sheet; out/####.png with --frames")->required();
    command->add_option("-o,--output", arguments->output, "The sheet: out/sheet.png")->required();
    command->add_option("--frames", arguments->frames, "Frames of the names with ####: 1-48x6");
    command->add_option("--columns", arguments->layout.columns, "Pictures in a row (default: a sheet of about 16:9)")
        ->check(CLI::Range(1, 1000));
    command->add_option("--cell", arguments->layout.cellWidth, "Width of a picture, pixels; wider ones are reduced to it (default: 480)")
        ->check(CLI::Range(16, 32768));
    command->add_option("--label", arguments->labels, "Text below a picture, once for each (default: the names of the files)")
        ->allow_extra_args(false);
    command->add_flag("--no-labels", arguments->noLabels, "No text");
    addViewArguments(*command, arguments->image);
    command->add_option("--bits", arguments->image.bits, "8 or 16 (default: 8)")->allow_extra_args(false);
    command->callback([&run, arguments] { run = [arguments] { return sheet(*arguments); }; });
}

} // namespace taut::app
