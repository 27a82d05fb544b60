#pragma once
/// How pictures are seen and stored, as plain data: what the [image] table of a scene and the options of the command say.

#include "taut/base/error.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace taut {

/// From scene-linear radiance to what a display shows. Texts that are empty are the defaults.
struct ViewSettings {
    double exposure = 0; ///< stops: radiance times 2^exposure, before the view
    std::string view;    ///< standard, filmic, aces (view_transform.h), or a view of the configuration
    std::string display; ///< that the view is for
    std::string look;    ///< of the configuration, in the place of the view's own
    std::string config;  ///< path of an OpenColorIO configuration; empty: that of the environment variable OCIO, if any
    std::string space;   ///< the configuration's name of linear Rec. 709; empty: found
    bool operator==(const ViewSettings &) const = default;
};

struct ImageSettings {
    ViewSettings view;                  ///< of files for displays; an EXR stays scene linear
    bool exrHalf = false;               ///< colours of an EXR as half floats; data beside them stay float (isColourChannel)
    std::string exrCompression = "zip"; ///< a name of exrCompressions(), dwaa and dwab with a level: dwaa:45
    int pngBits = 8;                    ///< 8 or 16
    bool operator==(const ImageSettings &) const = default;
};

/// "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab".
const std::vector<std::string_view> &exrCompressions();
/// Throws InputError at `where` for another name, or a level that is none.
void checkCompression(const std::string &compression, const Location &where);
/// Throws InputError where channels would not survive a compression that changes values: those of Cryptomatte, which are numbers of
/// objects, and variances.
void checkCompressionOf(const std::string &compression, const std::vector<std::string> &channels);

/// Sets what one of "8" and "16" (PNG), "half" and "float" (EXR) is about. Throws InputError at `where` where it is none of them.
void setBits(const std::string &bits, const Location &where, ImageSettings &settings);

/// Whether a channel holds a colour or its coverage, which half floats are enough for: R, G, B, A, alone or at the end of a layer's name;
/// not those of Cryptomatte, whose colours are numbers of objects, nor variances, whose small values halves lose.
bool isColourChannel(std::string_view name);

} // namespace taut
