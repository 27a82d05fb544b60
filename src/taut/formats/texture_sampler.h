#pragma once
/// How a texture is looked up, beside what it holds: glTF 2.0, section 3.8.4, and KHR_texture_transform.

#include "taut/base/vec.h"

namespace taut {

/// What stands beyond an image's edge: the image again, its mirror image, its last texels.
enum class TextureWrap { Repeat, Mirror, Clamp };

struct TextureSampler {
    TextureWrap wrapU = TextureWrap::Repeat;
    TextureWrap wrapV = TextureWrap::Repeat;
    bool nearest = false; ///< the texel at the place; false: bilinear
    int uvSet = 0;        ///< of the mesh: 0 or 1
    /// Where `moved`, the place on the image is (moveU . (u, v, 1), moveV . (u, v, 1)), v downwards from the image's upper edge.
    bool moved = false;
    Vec3 moveU{1, 0, 0};
    Vec3 moveV{0, 1, 0};

    bool operator==(const TextureSampler &) const = default;
};

/// KHR_texture_transform: offset + rotation * scale, the rotation counter-clockwise as the image is seen.
inline void setTextureTransform(TextureSampler &sampler, const Vec2 &offset, float rotation, const Vec2 &scale) {
    const float c = std::cos(rotation);
    const float s = std::sin(rotation);
    sampler.moveU = {c * scale.x, s * scale.y, offset.x};
    sampler.moveV = {-s * scale.x, c * scale.y, offset.y};
    sampler.moved = sampler.moveU != Vec3(1, 0, 0) || sampler.moveV != Vec3(0, 1, 0);
}

} // namespace taut
