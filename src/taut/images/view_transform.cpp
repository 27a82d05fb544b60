#include "taut/images/view_transform.h"

#include "taut/base/content_hash.h"
#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"
#include "taut/images/image_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace taut {

namespace {

constexpr float kLargest = 65504; // the largest half float: what transforms of pictures are made for

constexpr std::array<std::string_view, 3> kOwnViews{"standard", "filmic", "aces"};
constexpr std::string_view kOwnDisplay = "sRGB";
/// What linear Rec. 709 is called: ACES 1.3's studio and CG configurations, earlier ACES configurations, Blender's, others.
constexpr std::array kRec709Names{
    "Linear Rec.709 (sRGB)",      "lin_rec709_srgb", "Linear Rec.709", "lin_rec709",  "Utility - Linear - sRGB",
    "Utility - Linear - Rec.709", "lin_srgb",        "Linear - sRGB",  "linear_srgb", "Linear"};

bool isOwn(const std::string &view) {
    return std::find(kOwnViews.begin(), kOwnViews.end(), view) != kOwnViews.end();
}

bool contains(const std::vector<std::string> &names, const std::string &name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Throws at `key` where `name` is none of these.
void expectOneOf(const char *key, const std::string &name, const std::vector<std::string> &names, const std::string &of) {
    if (contains(names, name)) return;
    if (names.empty()) failInput({key}, quoted(name), "no " + std::string(key) + ": " + of + " has none");
    failUnknownName({key}, name, std::vector<std::string_view>(names.begin(), names.end()));
}

/// Of OpenColorIO's own configurations, which are no files (2.2 and later).
bool isBuiltIn(const std::string &path) {
    return path.compare(0, 7, "ocio://") == 0;
}

/// The name that the metadata has: that of the file and its contents, wherever it lies.
std::string labelOf(const std::string &path) {
    if (isBuiltIn(path)) return path;
    return std::filesystem::path(path).filename().string() + " " + contentHash(readFileBytes(path));
}

std::unique_ptr<const ColourConfig> openFile(const std::string &path) {
    if (!isBuiltIn(path)) readFileBytes(path); // or says what is wrong with it
    try {
        return imageCodec().openColours(path);
    } catch (const RunError &) {
        throw;
    } catch (const std::exception &error) {
        failInput({path, 0, 0, -1}, "no configuration that OpenColorIO reads (" + std::string(error.what()) + ")", "a config.ocio");
    }
}

std::string spaceOf(const ColourConfig &config, const ViewSettings &settings, const std::string &path) {
    if (!settings.space.empty()) {
        if (!config.hasSpace(settings.space)) expectOneOf("space", settings.space, config.spaces(), path);
        return settings.space;
    }
    for (const char *name : kRec709Names)
        if (config.hasSpace(name)) return name;
    if (!config.knowsAces())
        failInput({path, 0, 0, -1}, "no colour space that is known to be linear Rec. 709",
                  "its name as --ocio-space, or as space in [image]");
    return "";
}

} // namespace

float filmicCurve(float x) {
    if (!(x > 0)) return 0;
    const float top = x * (2.51F * x + 0.03F);
    const float bottom = x * (2.43F * x + 0.59F) + 0.14F;
    return std::fmin(top / bottom, 1.0F);
}

ViewTransform::ViewTransform(const ViewSettings &settings) : exposure_(settings.exposure) {
    open(settings);
    if (exposure_ == 0 && applied_.empty() && view_ == "standard") return;
    applied_.insert(applied_.begin(), {{"taut:exposure", formatNumber(exposure_)}, {"taut:view", view_}, {"taut:display", display_}});
}

ViewTransform::~ViewTransform() = default;
ViewTransform::ViewTransform(ViewTransform &&) noexcept = default;

void ViewTransform::open(const ViewSettings &settings) {
    const char *environment = std::getenv("OCIO");
    const std::string path = !settings.config.empty() ? settings.config : environment != nullptr ? environment : "";
    const bool isAsked = !settings.view.empty() || !settings.display.empty() || !settings.look.empty() || !settings.config.empty();
    if (!isAsked) return; // a variable of the environment alone changes no picture
    if (!path.empty() && openConfig(settings, path)) return;
    view_ = settings.view.empty() ? "standard" : settings.view;
    if (!isOwn(view_)) failUnknownName({"view"}, view_, kOwnViews);
    if (!settings.look.empty())
        failInput({"look"}, quoted(settings.look) + " with the view " + view_,
                  "a view of an OpenColorIO configuration (--ocio FILE or $OCIO)");
    if (view_ == "aces") return openAces(settings);
    if (view_ == "filmic") kind_ = Kind::Filmic;
    if (!settings.display.empty()) expectOneOf("display", settings.display, {std::string(kOwnDisplay)}, view_);
}

void ViewTransform::openAces(const ViewSettings &settings) {
    const std::vector<std::string> displays = imageCodec().acesDisplays();
    if (!settings.display.empty()) {
        expectOneOf("display", settings.display, displays, view_);
        display_ = settings.display;
    }
    kind_ = Kind::OpenColorIo;
    transform_ = imageCodec().acesView(display_);
    applied_.emplace_back("taut:ocio", imageCodec().colourVersion() + ", built-in ACES 1.0 SDR video");
}

bool ViewTransform::openConfig(const ViewSettings &settings, const std::string &path) {
    const std::unique_ptr<const ColourConfig> config = openFile(path);
    try {
        const std::vector<std::string> displays = config->displays();
        if (displays.empty()) failInput({path, 0, 0, -1}, "a configuration without displays", "one with a view");
        const bool ownWins = isOwn(settings.view) && (settings.display.empty() || !contains(displays, settings.display));
        if (!settings.display.empty() && !ownWins) expectOneOf("display", settings.display, displays, path);
        const std::string display = settings.display.empty() || ownWins ? displays.front() : settings.display;
        const std::vector<std::string> views = config->views(display);
        if (settings.view.empty() && views.empty()) failInput({path, 0, 0, -1}, "a display without views", "one with a view");
        view_ = settings.view.empty() ? views.front() : settings.view;
        if (!contains(views, view_)) {
            if (isOwn(view_)) return false;
            std::vector<std::string_view> valid(views.begin(), views.end());
            valid.insert(valid.end(), kOwnViews.begin(), kOwnViews.end());
            failUnknownName({"view"}, view_, valid);
        }
        if (!settings.look.empty()) expectOneOf("look", settings.look, config->looks(), path);
        display_ = display;
        kind_ = Kind::OpenColorIo;
        transform_ = config->view(spaceOf(*config, settings, path), display_, view_, settings.look);
    } catch (const InputError &) {
        throw;
    } catch (const std::exception &error) {
        failInput({path, 0, 0, -1}, "a configuration whose view " + quoted(view_) + " can't be made (" + error.what() + ")",
                  "one that can");
    }
    applied_.emplace_back("taut:ocio", imageCodec().colourVersion() + ", " + labelOf(path));
    if (!settings.look.empty()) applied_.emplace_back("taut:look", settings.look);
    return true;
}

bool ViewTransform::isSrgb() const {
    return display_.find("sRGB") != std::string::npos;
}

void ViewTransform::apply(float *rgb, std::size_t pixels) const {
    const auto factor = static_cast<float>(std::exp2(exposure_));
    const std::size_t count = 3 * pixels;
    for (std::size_t i = 0; i < count; ++i) {
        const float value = rgb[i] * factor;
        rgb[i] = std::isnan(value) ? 0 : std::clamp(value, -kLargest, kLargest);
    }
    if (kind_ == Kind::OpenColorIo) {
        transform_->apply(rgb, pixels);
        for (std::size_t i = 0; i < count; ++i) rgb[i] = std::fmin(std::fmax(rgb[i], 0.0F), 1.0F); // NaN: 0
        return;
    }
    for (std::size_t i = 0; i < count; ++i) rgb[i] = srgbFromLinear(kind_ == Kind::Filmic ? filmicCurve(rgb[i]) : rgb[i]);
}

} // namespace taut
