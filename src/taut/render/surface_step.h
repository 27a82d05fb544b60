#pragma once
/// What a hit reads of a deforming surface, at one time within the shutter: filled from the gradient as the plan wants it.

#include "taut/plan/bvh_policy.h"
#include "taut/plan/plan.h"

namespace taut {

/// Everything is in render space, but for instanced objects (RenderObject::placements). Arrays that a plan has no use for are empty.
struct SurfaceStep {
    std::vector<Vec3> positions;          ///< [vertices + 1]: Embree reads 16 bytes at the last
    std::vector<Vec3> normals;            ///< [vertices] unit; outward
    std::vector<Vec4> tangents;           ///< [vertices] rotated tangent and sense, polarGradient()
    std::vector<SymmetricTensor> stretch; ///< [vertices] V over lambda in the form of the interpolation scheme; [triangles] V
                                          ///< where it is constant on faces; one element: the whole mesh's; empty: the identity
    std::vector<Vec3> lean;               ///< [vertices] tangential part of F n0, over lambda
    std::vector<float> inverseLambda;     ///< [vertices] that V is already multiplied by, where it leans and roughens
    std::vector<Vec3> ds, dt;             ///< [vertices] with the scheme DsDt
};

/// One object of the scene with its buffers.
struct RenderObject : ObjectSurface {
    MeshPlan plan;
    std::vector<SurfaceStep> steps; ///< equally spaced over the shutter; one without motion blur
    bool rigid = false;
    bool roughens = false; ///< one of its materials does, by the strain of A, and A is known (no stored M, `follow`)
    bool moved = true; ///< by the last frame that it was brought to
    Index geometry = kNone;
    bool mayBeAbsent = false; ///< where one of its materials is (mayBeAbsent); traversal asks about each of its hits then
    BvhPolicy bvh;

    // Rigid objects that move: their one step is filled once, in rest space about the centre of their box (local space), and only
    // placed from then on.
    bool instanced = false;
    std::vector<Affine> placements; ///< [times in the shutter] render from local space; empty: steps are in render space
    Vec3 localCentre{0};            ///< rest space: the origin of local space
    std::vector<Vec4> restTangents; ///< [vertices] of a rigid object, in rest space, with their sense; until its steps are filled

    /// [vertices] of a mesh with a stored M, else empty. Then `stretch` of a step is sqrt(M M^T), and the material's alpha has no say.
    std::vector<float> storedPoisson;

    std::vector<Vec3> metrics; ///< [triangles] of the estimator Face, restMetrics()

    /// Whether `stretch` holds one tensor a triangle.
    [[nodiscard]] bool stretchOnFaces() const {
        return plan.estimator == GradientEstimator::Face || plan.interpolation == GradientInterpolation::Face;
    }
};

/// Builds the object's surface, unless `out` has taken over that of the plan, and what the plan needs beside it, for so many times in
/// the shutter. `animated`: other frames follow.
void prepareRenderObject(const Object &object, const RenderSettings &render, const MeshPlan &plan, std::size_t times, bool animated,
                         RenderObject &out);

/// Brings one of the shutter's times to a frame. False where a rigid object has not moved since. Adds to the seconds of positions and
/// gradients.
bool moveObject(RenderObject &object, std::size_t step, double frame, double fps, const DMat4 &renderFromWorld, double &deformationSeconds,
                double &gradientSeconds);

} // namespace taut
