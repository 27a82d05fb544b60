#pragma once
/// Colours for a display: exposure, then a view.
///
/// Scene linear here is linear Rec. 709 (sRGB's primaries and white, D65). Three views need no configuration:
///   standard  as it is; what is above 1 is cut off
///   filmic    x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), a channel at a time: K. Narkowicz, "ACES Filmic Tone Mapping Curve",
///             2016, his fit of the reference transform of ACES 1.0; taut view shows it too
///   aces      the output transform ACES 1.0 SDR video of the Academy, from OpenColorIO's built-in transforms
/// The others are those of an OpenColorIO configuration: the one that is named, or that of the environment variable OCIO. A view of the
/// configuration wins over one of the three that has its name.
///
/// Every value gives one in [0, 1]: NaN counts as 0, what is beyond the largest half float, and infinity, as that.

#include "taut/images/image_settings.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace taut {

class ColourTransform;

/// The curve of the view "filmic", in [0, 1] and linear still; 0 below 0, 1 from 7.2417 on.
float filmicCurve(float x);

class ViewTransform {
  public:
    /// Throws InputError where there is no such view, display, look, space or configuration, with the nearest name.
    explicit ViewTransform(const ViewSettings &settings);
    ~ViewTransform();
    ViewTransform(ViewTransform &&) noexcept;
    ViewTransform(const ViewTransform &) = delete;
    ViewTransform &operator=(const ViewTransform &) = delete;

    /// [3 x pixels] interleaved, scene linear: to what the display is sent, in [0, 1].
    void apply(float *rgb, std::size_t pixels) const;

    /// Whether what the display is sent is encoded as sRGB.
    [[nodiscard]] bool isSrgb() const;
    /// Its name, and whether it is one of "standard" and "filmic", whose formulas are above, and no configuration's.
    [[nodiscard]] const std::string &view() const { return view_; }
    [[nodiscard]] bool isOwnFormula() const { return kind_ != Kind::OpenColorIo; }
    /// What is applied, for the metadata of a picture; empty: nothing but the encoding of sRGB.
    [[nodiscard]] const std::vector<std::pair<std::string, std::string>> &applied() const { return applied_; }

  private:
    enum class Kind { Standard, Filmic, OpenColorIo };

    void open(const ViewSettings &settings);
    void openAces(const ViewSettings &settings);
    /// False where the configuration has no such view and one of the three is meant.
    bool openConfig(const ViewSettings &settings, const std::string &path);

    Kind kind_ = Kind::Standard;
    double exposure_ = 0;
    std::string view_ = "standard", display_ = "sRGB";
    std::unique_ptr<const ColourTransform> transform_;
    std::vector<std::pair<std::string, std::string>> applied_;
};

} // namespace taut
