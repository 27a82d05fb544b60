#pragma once
/// A film as the page takes it: linear half floats behind a header of 32-bit words.

#include "taut/render/film.h"

#include <cstdint>
#include <memory>
#include <string>

namespace taut::app {

/// What a picture is of.
struct PictureLabel {
    std::uint32_t number = 0;  ///< of all pictures of a session, increasing
    std::uint32_t version = 0; ///< of the changes that it shows
    std::int32_t frame = 0;
    bool follows = true;  ///< false: roughness held fixed
    int width = 0;        ///< of the whole frame; the picture may have fewer pixels
    int height = 0;
    int samples = 0;      ///< a pixel
    int wanted = 0;       ///< when it is done
    bool done = false;    ///< it is what `taut render` makes
    float milliseconds = 0; ///< from the change that it is the first picture of; 0: it is not
};

/// "TAUT", number, version, frame, follows, columns, rows, width, height, samples, wanted, done, channels, milliseconds (a float), two
/// words of zero: 16 words, little-endian. Then the halves, rows from the top, channels interleaved: R G B A, then those of the film's
/// first AOV.
std::string pictureBytes(const Film &film, const PictureLabel &label);

struct Picture {
    PictureLabel label;
    std::string bytes;
};

} // namespace taut::app
