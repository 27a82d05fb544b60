#pragma once
/// A film as the page takes it: linear half floats behind a header of 32-bit words.

#include "taut/images/image_settings.h"
#include "taut/render/image_file.h"

#include <cstdint>
#include <memory>
#include <string>

namespace taut::app {

/// What a picture is of.
struct PictureLabel {
    std::uint32_t number = 0;  ///< of all pictures of a session, increasing
    std::uint32_t version = 0; ///< of the changes that it shows
    std::int32_t frame = 0;
    bool follows = true; ///< false: roughness held fixed
    int width = 0;       ///< of the whole frame; the picture may have fewer pixels
    int height = 0;
    int samples = 0;        ///< a pixel
    int wanted = 0;         ///< when it is done
    bool done = false;      ///< it is what `taut render` makes
    float milliseconds = 0; ///< from the change that it is the first picture of; 0: it is not
};

/// "TAUT", number, version, frame, follows, columns, rows, width, height, samples, wanted, done, channels, milliseconds (a float), two
/// words of zero: 16 words, little-endian. Then the halves, rows from the top, channels interleaved: R G B A, then the image's others.
/// Those of Cryptomatte, which halves can't hold, are three colours instead: of each id one, by its share.
std::string pictureBytes(const Image &image, const PictureLabel &label);

/// A view transform without its exposure for the page: halves R G B A, at kViewSteps values of each of R, G and B, R fastest. Step i stands
/// for the linear value 2^(19 i / (kViewSteps - 1) - 10) - 2^-10.
inline constexpr int kViewSteps = 65;
std::string viewTable(const ViewSettings &settings);

struct Picture {
    PictureLabel label;
    std::string bytes;
};

} // namespace taut::app
