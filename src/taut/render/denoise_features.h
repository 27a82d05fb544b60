#pragma once
/// What the denoiser is told of the first surface that a pixel sees: what other renderers know of it, and what this one knows of its gloss.

#include "taut/base/vec.h"
#include "taut/deform/affine.h"
#include "taut/render/ray_batch.h"

#include <array>
#include <cstdint>
#include <vector>

namespace taut {

class RenderScene;
struct SurfacePoint;

/// Channels, in their order.
enum DenoiseFeature : std::uint8_t {
    kNormal = 0,      ///< of the facet, world space, on the viewer's side
    kAlbedo = 3,      ///< base colour, held at kMostAlbedo
    kDepth = 6,       ///< natural logarithm of the distance along the view
    kHalfway = 7,     ///< minus the slope of the half vector to a distant light, but for a constant: n - wo / 2, world space
    kLogStretch = 10, ///< logarithms of the singular values of A, max and min
    kGloss = 12,      ///< t1 t1^T / alphaMax^2 + t2 t2^T / alphaMin^2 in world space, xx xy xz yy yz zz: slopes to units of the lobe
    kMotion = 18,     ///< from where the point is to where it was in the frame before, pixels; where that is known
    kDenoiseFeatures = 20
};

inline constexpr float kMostAlbedo = 8;
/// Lobes narrower than that are told apart no further.
inline constexpr float kLeastGloss = 0.01F;

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

/// Features of a pixel, rounded for keeping: means over its probes (denoise_probes.cpp). Any bits are finite values.
struct PixelFeatures {
    std::uint16_t probes = 0;                      ///< camera rays that told; 0: none has
    std::uint16_t edge = 0;                        ///< 1 where surfaces end in the pixel or beside it
    std::uint16_t covered = 0;                     ///< share of them that saw something, of kWhole: alpha
    std::uint16_t met = 0;                         ///< share that met a surface or a light, not the environment alone
    std::uint16_t moving = 0;                      ///< share whose motion is known
    std::uint16_t noise[2] = {0, 0};               ///< variance of the means of normal and of albedo, the mean of three channels
    std::array<std::uint16_t, kMotion> channels{}; ///< normal and albedo over all probes, 0 where nothing is met; others over hits
    std::array<std::int32_t, 2> motion{};          ///< over those whose motion is known
    static constexpr float kWhole = 65535;

    /// A channel before kMotion, or of the motion.
    [[nodiscard]] float at(int feature) const;
    /// Variance of the mean of normal (0) or albedo (1).
    [[nodiscard]] float noiseOf(int which) const;
    bool operator==(const PixelFeatures &) const = default;
};

/// Means of what the probes of a pixel tell, in their order. Of a surface that is met again and again the first few say what it is like,
/// the others only how much of the pixel it covers.
class FeatureMeans {
  public:
    /// No surface was met. `covered`: something was seen all the same; `met`: a light.
    void addNothing(bool covered, bool met) {
        ++probes_;
        covered_ += covered ? 1 : 0;
        met_ += met ? 1 : 0;
    }
    /// A surface was met. Whether its features are asked for, to be told next.
    bool addHit(Index object, float distance);
    /// kDenoiseFeatures values.
    void tell(const float *features, bool motionKnown);
    [[nodiscard]] PixelFeatures rounded(bool edge) const;
    /// To begin with another pixel.
    void clear() {
        probes_ = covered_ = met_ = 0;
        surfaces_.clear();
    }

  private:
    struct Surface {
        Index object = kNone;
        float distance = 0;
        int hits = 0, told = 0, moving = 0;
        std::array<double, kDenoiseFeatures> sums{};
        std::array<double, kDepth> squares{};
    };
    int probes_ = 0, covered_ = 0, met_ = 0;
    std::vector<Surface> surfaces_;
    std::size_t last_ = 0; // that is asked about
};

} // namespace taut
