#pragma once
/// Image files through OpenImageIO, which is behind this interface in a module of its own: the library with all that it leans on takes
/// longer to load than most commands take to run, so that it is loaded when an image is first read or written.

#include "taut/images/colour_config.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace taut {

/// One part of an image file, as its header has it. Rows go from the top.
struct ImagePart {
    std::string name;
    std::vector<std::string> channels;
    int x = 0, y = 0, width = 0, height = 0;                 ///< the data window
    int fullX = 0, fullY = 0, fullWidth = 0, fullHeight = 0; ///< the display window
    bool isFlat = true;                                      ///< neither deep nor a volume
    bool isEightBits = false;
    bool isLinear = false;                                       ///< the file says so
    float gamma = 0;                                             ///< 0: the file does not say
    std::vector<std::pair<std::string, std::string>> attributes; ///< text alone

    [[nodiscard]] int channelCount() const { return static_cast<int>(channels.size()); }
};

/// A file that is open.
class ImageDecoder {
  public:
    ImageDecoder() = default;
    ImageDecoder(const ImageDecoder &) = delete;
    ImageDecoder &operator=(const ImageDecoder &) = delete;
    virtual ~ImageDecoder() = default;

    /// The first part alone, or all of them in the file's order.
    [[nodiscard]] virtual std::vector<ImagePart> parts(bool all) = 0;
    /// The data window of channels [first, end) of a part: 0 to 1 for integers. Throws std::runtime_error with OpenImageIO's reason.
    virtual void read(int part, int first, int end, float *values) = 0;
};

enum class SampleType { UInt8, UInt16, Half, Float };

/// What is encoded: `part` gives its windows, channels and attributes; samples are floats, or integers where `bytes` or `words` are given.
struct ImageToEncode {
    const ImagePart &part;
    SampleType type;
    const float *values = nullptr;
    const unsigned char *bytes = nullptr;
    const std::uint16_t *words = nullptr;
    std::vector<SampleType> channelTypes{}; ///< [channels] where they differ; may be empty
};

class ImageCodec {
  public:
    ImageCodec() = default;
    ImageCodec(const ImageCodec &) = delete;
    ImageCodec &operator=(const ImageCodec &) = delete;
    virtual ~ImageCodec() = default;

    /// `format` is OpenImageIO's name of it; `bytes` stay where they are while the file is open. Colours are as stored, not multiplied by
    /// alpha. Throws std::runtime_error with OpenImageIO's reason.
    [[nodiscard]] virtual std::unique_ptr<ImageDecoder> open(const std::string &format, std::string_view bytes,
                                                             const std::string &name) const = 0;
    /// The file as bytes: what a full disk says of it is said by who writes them. Throws std::runtime_error likewise.
    [[nodiscard]] virtual std::vector<unsigned char> encode(const std::string &format, const ImageToEncode &image) const = 0;

    // OpenColorIO. All throw std::runtime_error with its reason.
    /// A file's configuration, or a built-in one: ocio://default.
    [[nodiscard]] virtual std::unique_ptr<const ColourConfig> openColours(const std::string &path) const = 0;
    /// From linear Rec. 709 through the ACES output transform for SDR video, by built-in transforms alone.
    [[nodiscard]] virtual std::unique_ptr<const ColourTransform> acesView(const std::string &display) const = 0;
    [[nodiscard]] virtual std::vector<std::string> acesDisplays() const = 0; ///< sRGB first
    [[nodiscard]] virtual std::string colourVersion() const = 0;             ///< "OpenColorIO 2.1.2"
};

/// Loads the module at the first call; from any thread. Throws RunError where it is not found, with the places where it was looked for:
/// beside what this function is part of (a program or a shared library), in the folder taut/ beside that and in the library folders that
/// go with it, and along the run path.
const ImageCodec &imageCodec();

/// Begins to load the module in a thread of its own, so that it is there when the first image is written. Errors wait for imageCodec().
void preloadImageCodec();
/// Waits for what that began; for the end of a program. The libraries behind the module leave handlers for the exit, which must not run
/// while others of them are being loaded.
void awaitImageCodec();

} // namespace taut
