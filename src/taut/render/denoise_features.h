#pragma once
/// What the denoiser is told of the first surface on a path: what other renderers know of it, and what this one knows of its gloss.

#include "taut/deform/affine.h"
#include "taut/render/ray_batch.h"

#include <cstdint>
#include <vector>

namespace taut {

class RenderScene;
struct SurfacePoint;

/// Channels, in their order. Those before kSquared have second moments too.
enum DenoiseFeature : std::uint8_t {
    kNormal = 0,      ///< of the facet, world space, on the viewer's side
    kAlbedo = 3,      ///< base colour, held at kMostAlbedo
    kDepth = 6,       ///< natural logarithm of the distance along the view
    kHalfway = 7,     ///< minus the slope of the half vector to a distant light, but for a constant: n - wo / 2, world space
    kLogStretch = 10, ///< logarithms of the singular values of A, max and min
    kSquared = 12,    ///< how many of them are
    kGloss = 12,      ///< t1 t1^T / alphaMax^2 + t2 t2^T / alphaMin^2 in world space, xx xy xz yy yz zz: slopes to units of the lobe
    kMotion = 18,     ///< from where the point is to where it was in the frame before, pixels; where that is known
    kDenoiseFeatures = 20
};

inline constexpr float kMostAlbedo = 8;
/// Lobes narrower than that are told apart no further.
inline constexpr float kLeastGloss = 0.01F;

/// Whether a sample tells its features. They vary less than light does: after the first sixteen, every fourth does.
inline bool tellsFeatures(std::uint32_t sample) {
    return sample < 16 || sample % 4 == 0;
}

/// Where all surfaces and the camera were at a frame, kept while the scene is brought to the next one.
class FrameBefore {
  public:
    FrameBefore() = default;
    explicit FrameBefore(const RenderScene &scene);
    /// From the pixel position of a point of `scene` to that which it had: false where it was behind the camera.
    bool motionOf(const RenderScene &scene, const SurfacePoint &point, float time, Vec2 &pixels) const;

  private:
    struct Shape {
        std::vector<std::vector<Vec3>> steps; ///< [times in the shutter][vertices], as SurfaceStep::positions
        std::vector<Affine> placements;
    };
    std::vector<Shape> objects_;
    double fovY_ = 0;
    double orthoHeight_ = 0;
};

/// Writes kDenoiseFeatures values. `wo`: unit, render space, towards the viewer. `before`: null where no motion is asked for. True where
/// the motion is known.
bool writeDenoiseFeatures(const RenderScene &scene, const SurfacePoint &point, const Vec3 &wo, float time, const FrameBefore *before,
                          float *out);

} // namespace taut
