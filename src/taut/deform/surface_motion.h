#pragma once
/// One mesh at one time: positions, normals and the surface gradient at every render vertex. Nothing is allocated after the
/// first frame.
///
/// Chain, each step carrying position and gradient exactly:
///   control points (morphs, sequences) -> skin or rigid carrier -> deformers -> render space
/// Morphed, sequenced and subdivided points have no closed form: there the gradient starts from the area-weighted fit of
/// surface.h. Skinning includes the gradient of the weights.

#include "taut/deform/deformer.h"
#include "taut/deform/surface.h"

#include <span>
#include <string>
#include <vector>

namespace taut {

/// 3x4 affine map, column-major: columns x, y, z, translation.
using Affine = glm::mat4x3;

inline Vec3 transformPoint(const Affine &m, const Vec3 &p) {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}
inline Vec3 transformVector(const Affine &m, const Vec3 &v) {
    return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

/// Between equally spaced maps, entry by entry; `time` in 0 to 1.
inline Affine affineAt(std::span<const Affine> maps, float time) {
    if (maps.size() == 1) return maps[0];
    const std::size_t last = maps.size() - 1;
    const float at = time * static_cast<float>(last);
    const std::size_t before = static_cast<std::size_t>(at) < last ? static_cast<std::size_t>(at) : last - 1;
    const float u = at - static_cast<float>(before);
    Affine m;
    for (int c = 0; c < 4; ++c) m[c] = glm::mix(maps[before][c], maps[before + 1][c], u);
    return m;
}

/// What moves one mesh at one time. Where there are no deformers, `joints` and `carrier` lead straight into render space.
struct MotionState {
    std::span<const Vec3> control;   ///< object space, [positions]
    bool controlMoved = false;       ///< control differs from the rest mesh: the gradient starts from the fit
    std::vector<Affine> joints;      ///< for a skinned mesh; else empty
    Affine carrier{1};               ///< for a mesh without a skin, and for vertices without influences
    std::vector<Deformer> deformers; ///< act in the space that joints / carrier lead into
    DMat4 renderFromDeformed{1};     ///< used where there are deformers
    bool mirrored = false;           ///< the map as a whole turns orientation over
};

/// How a surface gradient is computed. All but Analytic use final positions alone.
enum class GradientEstimator {
    Face,         ///< constant per triangle (face_gradient.h); first order
    Area,         ///< area-weighted mean of the faces around a vertex
    Angle,        ///< angle-weighted mean
    LeastSquares, ///< the one-ring's best linear map
    Limit,        ///< exact derivatives of the limit surface (subdivided meshes)
    Analytic,     ///< carried through skin and deformers; from an Area fit where control points move by themselves
};

/// Gradient of every surface vertex in render space: x, and f1 = dx/de1, f2 = dx/de2 in the tangent plane of the unit normal.
struct SurfaceGradient {
    std::vector<Vec3> position, f1, f2, normal;
    std::vector<Vec4> points; ///< scratch: control points, padded for four lanes
    bool wantNormalImage = false;
    std::vector<Vec3> normalImage; ///< where wanted: F n0, the image of the rest normal under the deformers and what carries them,
                                   ///< the third column of F; by the Analytic estimator only, else empty
};

/// Attributes of the render vertices at one time, in render space.
struct SurfaceFrame {
    std::vector<Vec3> positions; ///< one more than there are vertices: Embree reads 16 bytes at the last
    std::vector<Vec3> normals;   ///< unit; outward
    std::vector<Vec3> ds, dt;    ///< images of the rest tangent frame: F t0, F b0
};

/// Evaluates gradient and positions of all surface vertices. Throws RunError naming `name` where a position is not finite.
void evaluateGradient(const Surface &surface, const MotionState &motion, const SkinWeights &skin, GradientEstimator estimator,
                      const std::string &name, SurfaceGradient &out);

/// The same from positions alone, which are already in render space: those of the surface's mesh, or of the cage of a limit surface.
void fitGradient(const Surface &surface, std::span<const Vec3> renderPoints, bool mirrored, const std::string &name, SurfaceGradient &out);

/// Positions of control points in render space (for subdivision, and where only positions are wanted).
void evaluatePositions(const MotionState &motion, const SkinWeights &skin, std::vector<Vec3> &out);

/// Spreads surface vertices to render vertices: out.ds = t0.x f1 + t0.y f2, ...
void spreadToVertices(const Surface &surface, const SurfaceGradient &gradient, SurfaceFrame &out);

/// Makes the shape in `gradient` the rest state: from then on the same shape has A = identity, with t0 along its ds.
void setRestFrom(Surface &surface, const SurfaceGradient &gradient);

} // namespace taut
