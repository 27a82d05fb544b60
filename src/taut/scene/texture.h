#pragma once
/// Textures: images read through OpenImageIO, held in memory as linear values, looked up bilinearly.

#include "taut/base/error.h"
#include "taut/base/vec.h"

#include <string>
#include <vector>

namespace taut {

enum class ColorSpace { Linear, Srgb, Auto }; ///< Auto: 8-bit images are sRGB, others linear

/// Texels in rows from the TOP, `channels` floats each (1, 3 or 4), scene-linear.
struct Texture {
    std::string name;
    int width = 1;
    int height = 1;
    int channels = 3;
    bool repeatU = true;
    bool repeatV = true;
    std::vector<float> texels;
};

/// Reads an image file: PNG, JPEG, OpenEXR, Radiance HDR or TIFF, told apart by its first bytes. Alpha is never decoded and
/// colours are not multiplied by it. Throws InputError (with OpenImageIO's reason) where it can't be read, is empty, larger
/// than 32768 texels a side or 2^28 in all, or holds values that are not finite.
Texture readTexture(const std::string &path, ColorSpace space);

/// Reads an image file held in memory (glTF buffer views); `name` is used in errors.
Texture readTextureFromMemory(const std::string &name, const std::vector<unsigned char> &bytes, ColorSpace space);

/// Bilinear lookup at uv (v up: (0, 0) is the lower left corner). Missing channels repeat the first (grey) and alpha is 1.
Vec4 lookup(const Texture &texture, const Vec2 &uv);

} // namespace taut
