#pragma once
/// Textures: images read through OpenImageIO, held in memory as linear values, looked up as their samplers say.

#include "taut/base/budget.h"
#include "taut/base/error.h"
#include "taut/base/vec.h"
#include "taut/formats/texture_sampler.h"

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace taut {

/// Auto: PNG, JPEG, WebP, TGA and BMP are sRGB at any depth (a PNG whose gamma is 1 is linear), 8-bit TIFF too; others are linear.
enum class ColorSpace { Linear, Srgb, Auto };

/// An array that copies share: textures of one image with other samplers cost no memory. Never changed once it is shared.
class SharedTexels {
  public:
    SharedTexels() = default;
    SharedTexels(std::vector<float> values) : owner_(std::make_shared<const std::vector<float>>(std::move(values))) {
        data_ = owner_->data();
    }
    SharedTexels(std::initializer_list<float> values) : SharedTexels(std::vector<float>(values)) {}

    [[nodiscard]] std::size_t size() const { return owner_ ? owner_->size() : 0; }
    [[nodiscard]] const float *begin() const { return data_; }
    [[nodiscard]] const float *end() const { return data_ + size(); }
    const float &operator[](std::size_t i) const { return data_[i]; }

  private:
    std::shared_ptr<const std::vector<float>> owner_;
    const float *data_ = nullptr; // one step less at each lookup
};

class TexturePyramid;

/// Texels in rows from the TOP, `channels` floats each (1, 3 or 4), scene-linear.
struct Texture {
    std::string name;
    int width = 1;
    int height = 1;
    int channels = 3;
    SharedTexels texels;
    TextureSampler sampler;
    // For those who look it up from afar (texture_pyramid.h); null: as it is.
    std::shared_ptr<const TexturePyramid> pyramid{}; ///< of its channels
    std::shared_ptr<const TexturePyramid> slopes{};  ///< of the moments of the slopes that it holds
};

/// What a pixel sees of a surface around a point, in texture coordinates: the axes of an ellipse, end to end. Zero: the point alone.
struct UvFootprint {
    Vec2 major{0}, minor{0};
    [[nodiscard]] bool isGiven() const { return major != Vec2(0) || minor != Vec2(0); }
};

/// Texture coordinates at a point of a mesh, which may have two sets of them.
struct UvPoint {
    Vec2 first{0};
    Vec2 second{0};
    UvFootprint footprint{}, secondFootprint{};
    UvPoint() = default;
    UvPoint(const Vec2 &uv) : first(uv) {}
    [[nodiscard]] const Vec2 &set(int number) const { return number == 1 ? second : first; }
    [[nodiscard]] const UvFootprint &footprintOf(int number) const { return number == 1 ? secondFootprint : footprint; }
};

/// Reads an image file: PNG, JPEG, OpenEXR, Radiance HDR, TIFF, WebP or BMP, told apart by its first bytes, or TGA, by its name. Alpha
/// is never decoded and colours are not multiplied by it. Of an OpenEXR file: the display window of the part with R, G and B. Values
/// that are not finite are held (not a number at 0, infinite at the greatest finite value) and counted in a warning. Throws
/// InputError (with OpenImageIO's reason) where it can't be read, ends early, is empty, larger than 32768 texels a side or 2^28 in
/// all, or where more than a quarter of the texels would be held. `budget` is asked before a decoder is; null: one of its own.
Texture readTexture(const std::string &path, ColorSpace space, Warnings &warnings, Budget *budget = nullptr);

/// Reads an image file held in memory (glTF buffer views); `name` is used in errors.
Texture readTextureFromMemory(const std::string &name, const std::vector<unsigned char> &bytes, ColorSpace space, Warnings &warnings,
                              Budget *budget = nullptr);

/// Reads a map of radiance: as readTexture with ColorSpace::Auto, and negative values are held at 0 and counted likewise.
Texture readRadiance(const std::string &path, Warnings &warnings, Budget *budget = nullptr);

/// The texture at uv (v up: (0, 0) is the lower left corner), which its sampler moves and filters. Missing channels repeat the first
/// (grey) and alpha is 1.
Vec4 lookup(const Texture &texture, const Vec2 &uv);
/// The mean over a footprint, where the texture has a pyramid.
Vec4 lookup(const Texture &texture, const Vec2 &uv, const UvFootprint &footprint);
/// At the set of UVs that the sampler reads.
inline Vec4 lookup(const Texture &texture, const UvPoint &point) {
    const Vec2 &uv = point.set(texture.sampler.uvSet);
    return texture.pyramid ? lookup(texture, uv, point.footprintOf(texture.sampler.uvSet)) : lookup(texture, uv);
}

/// The four texels of an image of that size that a bilinear lookup reads, and how far it is from the first to the second.
struct BilinearPlace {
    int column[2], row[2];
    float u, v;
};
BilinearPlace bilinearPlace(const TextureSampler &sampler, const Vec2 &uv, int width, int height);

} // namespace taut
