#pragma once
/// One mesh at one time: positions, normals and the surface gradient at every render vertex. Nothing is allocated after the
/// first frame.
///
/// Chain, each step carrying position and gradient exactly:
///   control points (morphs, sequences) -> skin or rigid carrier -> deformers -> render space
/// Morphed, sequenced and subdivided points have no closed form: there the gradient starts from the area-weighted fit of
/// surface.h, turned to the normals that a file gives its morphs. Skinning includes the gradient of the weights.

#include "taut/deform/affine.h"
#include "taut/deform/deformer.h"
#include "taut/deform/estimators.h"
#include "taut/deform/orientation.h"
#include "taut/deform/stretch.h"

#include <span>
#include <string>
#include <vector>

namespace taut {

/// What moves one mesh at one time. Where there are no deformers, `joints` and `carrier` lead straight into render space.
struct MotionState {
    std::span<const Vec3> control;   ///< object space, [positions]
    std::span<const Vec3> normals;   ///< object space, [normals of the mesh], of any length: where morphs say what normals do; else empty
    bool controlMoved = false;       ///< control differs from the rest mesh: the gradient starts from the fit
    std::vector<Affine> joints;      ///< for a skinned mesh; else empty
    Affine carrier{1};               ///< for a mesh without a skin, and for vertices without influences
    std::vector<Deformer> deformers; ///< act in the space that joints / carrier lead into
    DMat4 renderFromDeformed{1};     ///< used where there are deformers
    bool mirrored = false;           ///< carrier and placement turn orientation over: what counts where the map is too flat to tell

    /// Whether the map's orientation may differ from vertex to vertex.
    [[nodiscard]] bool turnsVary(const SkinWeights &skin) const { return (!joints.empty() && !skin.empty()) || !deformers.empty(); }
    /// orientationOf() what follows the deformers.
    [[nodiscard]] int placedSide() const { return deformers.empty() ? 1 : orientationOf(DMat3(renderFromDeformed)); }
};

/// Gradient of every surface vertex in render space: x, and f1 = dx/de1, f2 = dx/de2 in the tangent plane of the unit normal.
struct SurfaceGradient {
    std::vector<Vec3> position, f1, f2, normal;
    Orientation orientation;      ///< of the map at the surface vertices, by the sign of its determinant; `normal` is the outer one
    std::vector<Vec3> moved;      ///< scratch: control points in render space, where the gradient is a fit to them
    Orientation movedOrientation; ///< scratch: of the map at those
    std::vector<Vec4> points;     ///< scratch: control points, padded for four lanes
    bool wantNormalImage = false;
    std::vector<Vec3> normalImage; ///< where wanted: F n0, the image of the rest normal under the deformers and what carries them,
                                   ///< the third column of F; by the Analytic estimator only, else empty
};

/// Attributes of the render vertices at one time, in render space.
struct DeformedVertices {
    std::vector<Vec3> positions; ///< one more than there are vertices: Embree reads 16 bytes at the last
    std::vector<Vec3> normals;   ///< unit; outward
    std::vector<Vec3> ds, dt;    ///< images of the rest tangent frame: F t0, F b0
};

/// Evaluates gradient and positions of all surface vertices. Throws RunError naming `name` where a position is not finite.
void evaluateGradient(const Surface &surface, const MotionState &motion, const SkinWeights &skin, GradientEstimator estimator,
                      const std::string &name, SurfaceGradient &out);

/// Gradient from positions alone, which are already in render space: those of the surface's mesh, or of the cage of a limit surface.
/// `points` says what the map does there.
void fitGradient(const Surface &surface, std::span<const Vec3> renderPoints, const Orientation &points, const std::string &name,
                 SurfaceGradient &out);

/// Positions of control points in render space (for subdivision, and where only positions are wanted).
void evaluatePositions(const MotionState &motion, const SkinWeights &skin, std::vector<Vec3> &out);
/// Images of the rest frame (t0, b0) of a render vertex, and the unit normal.
struct VertexGradient {
    Vec3 ds, dt, n;
};
inline VertexGradient gradientAt(const Surface &surface, const SurfaceGradient &gradient, std::size_t renderVertex) {
    const Index s = surface.vertexSurface[renderVertex];
    const Tangents image = tangentsFrom(surface.tangentCoefficients[renderVertex], gradient.f1[s], gradient.f2[s]);
    return {image.ds, image.dt, gradient.normal[s]};
}
inline PolarGradient polarAt(const Surface &surface, const SurfaceGradient &gradient, std::size_t renderVertex) {
    const VertexGradient g = gradientAt(surface, gradient, renderVertex);
    return polarGradient(g.ds, g.dt, g.n);
}

/// Spreads surface vertices to render vertices: out.ds = t0.x f1 + t0.y f2, ...
void spreadToVertices(const Surface &surface, const SurfaceGradient &gradient, DeformedVertices &out);

/// Makes the shape in `gradient` the rest state: from then on the same shape has A = identity, with t0 along its ds.
void setRestFrom(Surface &surface, const SurfaceGradient &gradient);

} // namespace taut
