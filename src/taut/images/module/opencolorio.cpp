#include "opencolorio.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace taut {

namespace {

namespace ocio = OCIO_NAMESPACE;

/// The built-in transforms of the displays that SDR video is mastered for.
constexpr std::array<std::pair<const char *, const char *>, 2> kAcesDisplays{
    {{"sRGB", "DISPLAY - CIE-XYZ-D65_to_sRGB"}, {"Rec.1886 Rec.709", "DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709"}}};

constexpr const char *kAcesRole = "aces_interchange";

class Transform final : public ColourTransform {
  public:
    explicit Transform(const ocio::ConstProcessorRcPtr &processor)
        : processor_(processor->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS)) {}

    void apply(float *rgb, std::size_t pixels) const override {
        ocio::PackedImageDesc image(rgb, static_cast<long>(pixels), 1, 3);
        processor_->apply(image);
    }

  private:
    ocio::ConstCPUProcessorRcPtr processor_;
};

/// Its exceptions are of the module; who called knows std::runtime_error.
template <class Do> auto translated(const Do &what) {
    try {
        ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE); // what is wrong is thrown
        return what();
    } catch (const ocio::Exception &error) {
        throw std::runtime_error(error.what());
    }
}

ocio::BuiltinTransformRcPtr builtIn(const char *style, ocio::TransformDirection direction = ocio::TRANSFORM_DIR_FORWARD) {
    const ocio::BuiltinTransformRcPtr transform = ocio::BuiltinTransform::Create();
    transform->setStyle(style);
    transform->setDirection(direction);
    return transform;
}

/// Appends: from linear Rec. 709 to ACES 2065-1.
void appendAcesFromRec709(const ocio::GroupTransformRcPtr &group) {
    group->appendTransform(builtIn("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", ocio::TRANSFORM_DIR_INVERSE));
    group->appendTransform(builtIn("ACEScg_to_ACES2065-1"));
}

/// A list with the default in front.
std::vector<std::string> withFirst(std::vector<std::string> names, const char *first) {
    const auto found = first != nullptr ? std::find(names.begin(), names.end(), first) : names.end();
    if (found != names.end()) std::rotate(names.begin(), found, found + 1);
    return names;
}

class Config final : public ColourConfig {
  public:
    explicit Config(ocio::ConstConfigRcPtr config) : config_(std::move(config)) {}

    std::vector<std::string> displays() const override {
        std::vector<std::string> names;
        for (int i = 0; i < config_->getNumDisplays(); ++i) names.emplace_back(config_->getDisplay(i));
        return withFirst(std::move(names), config_->getDefaultDisplay());
    }
    std::vector<std::string> views(const std::string &display) const override {
        std::vector<std::string> names;
        for (int i = 0; i < config_->getNumViews(display.c_str()); ++i) names.emplace_back(config_->getView(display.c_str(), i));
        return withFirst(std::move(names), config_->getDefaultView(display.c_str()));
    }
    std::vector<std::string> looks() const override {
        std::vector<std::string> names;
        for (int i = 0; i < config_->getNumLooks(); ++i) names.emplace_back(config_->getLookNameByIndex(i));
        return names;
    }
    std::vector<std::string> spaces() const override {
        std::vector<std::string> names;
        for (int i = 0; i < config_->getNumColorSpaces(); ++i) names.emplace_back(config_->getColorSpaceNameByIndex(i));
        return names;
    }
    bool hasSpace(const std::string &name) const override { return config_->getColorSpace(name.c_str()) != nullptr; }
    bool knowsAces() const override { return config_->hasRole(kAcesRole); }

    std::unique_ptr<const ColourTransform> view(const std::string &space, const std::string &display, const std::string &view,
                                                const std::string &look) const override {
        return translated([&] {
            const ocio::GroupTransformRcPtr group = ocio::GroupTransform::Create();
            if (space.empty()) appendAcesFromRec709(group);
            const std::string from = space.empty() ? kAcesRole : space;
            if (!look.empty()) {
                const ocio::LookTransformRcPtr looks = ocio::LookTransform::Create();
                looks->setSrc(from.c_str());
                looks->setDst(from.c_str());
                looks->setLooks(look.c_str());
                group->appendTransform(looks);
            }
            const ocio::DisplayViewTransformRcPtr shown = ocio::DisplayViewTransform::Create();
            shown->setSrc(from.c_str());
            shown->setDisplay(display.c_str());
            shown->setView(view.c_str());
            shown->setLooksBypass(!look.empty());
            group->appendTransform(shown);
            return std::make_unique<const Transform>(config_->getProcessor(group));
        });
    }

  private:
    ocio::ConstConfigRcPtr config_;
};

} // namespace

std::unique_ptr<const ColourConfig> openColourConfig(const std::string &path) {
    return translated([&] {
        ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(path.c_str());
        config->validate();
        return std::make_unique<const Config>(std::move(config));
    });
}

std::unique_ptr<const ColourTransform> makeAcesView(const std::string &display) {
    return translated([&] {
        const auto found =
            std::find_if(kAcesDisplays.begin(), kAcesDisplays.end(), [&](const auto &known) { return display == known.first; });
        if (found == kAcesDisplays.end()) throw std::runtime_error("no display " + display);
        const ocio::GroupTransformRcPtr group = ocio::GroupTransform::Create();
        appendAcesFromRec709(group);
        group->appendTransform(builtIn("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0"));
        group->appendTransform(builtIn(found->second));
        return std::make_unique<const Transform>(ocio::Config::CreateRaw()->getProcessor(group));
    });
}

std::vector<std::string> namesOfAcesDisplays() {
    std::vector<std::string> names;
    for (const auto &[name, style] : kAcesDisplays) names.emplace_back(name);
    return names;
}

std::string versionOfOpenColorIo() {
    return std::string("OpenColorIO ") + ocio::GetVersion();
}

} // namespace taut
