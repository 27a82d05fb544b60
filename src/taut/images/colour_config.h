#pragma once
/// Colour configurations through OpenColorIO, which is behind the module of images (image_codec.h).

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace taut {

/// What a view does to colours.
class ColourTransform {
  public:
    ColourTransform() = default;
    ColourTransform(const ColourTransform &) = delete;
    ColourTransform &operator=(const ColourTransform &) = delete;
    virtual ~ColourTransform() = default;

    /// [3 x pixels] interleaved, in place. From several threads at a time.
    virtual void apply(float *rgb, std::size_t pixels) const = 0;
};

/// A configuration that is open. What it throws is std::runtime_error with OpenColorIO's reason.
class ColourConfig {
  public:
    ColourConfig() = default;
    ColourConfig(const ColourConfig &) = delete;
    ColourConfig &operator=(const ColourConfig &) = delete;
    virtual ~ColourConfig() = default;

    [[nodiscard]] virtual std::vector<std::string> displays() const = 0;                        ///< the default first
    [[nodiscard]] virtual std::vector<std::string> views(const std::string &display) const = 0; ///< the default first
    [[nodiscard]] virtual std::vector<std::string> looks() const = 0;
    [[nodiscard]] virtual std::vector<std::string> spaces() const = 0;
    [[nodiscard]] virtual bool hasSpace(const std::string &name) const = 0; ///< by name, alias or role
    /// Whether it says how its colours relate to ACES 2065-1, so that linear Rec. 709 needs no name in it.
    [[nodiscard]] virtual bool knowsAces() const = 0;
    /// From `space` (empty: linear Rec. 709 by way of ACES 2065-1) to a view. `look` empty: the view's own looks.
    [[nodiscard]] virtual std::unique_ptr<const ColourTransform> view(const std::string &space, const std::string &display,
                                                                      const std::string &view, const std::string &look) const = 0;
};

} // namespace taut
