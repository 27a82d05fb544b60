#pragma once
/// Values of a deforming surface at a hit, between its triangle's corners and the times in the shutter: for hits one by one (shading.h)
/// and many at once (hit_lanes.h).

#include "taut/render/ray_batch.h"
#include "taut/render/surface_geometry.h"
#include "taut/render/surface_step.h"

namespace taut {

/// Takes a point of an instanced mesh from local to render space.
inline void place(InterpolatedSurface &point, const Affine &renderFromLocal) {
    point.position = transformPoint(renderFromLocal, point.position);
    point.e1 = transformVector(renderFromLocal, point.e1);
    point.e2 = transformVector(renderFromLocal, point.e2);
    point.normal = transformVector(renderFromLocal, point.normal);
    point.tangent = Vec4(transformVector(renderFromLocal, Vec3(point.tangent)), point.tangent.w);
    point.corners += extentOf(renderFromLocal[3]);
}

/// The corners of a hit's triangle at one time: between two steps of the shutter where there are several. kStill: there is one, which
/// saves a question for each value.
template <bool kStill> class HitCorners {
  public:
    HitCorners(const RenderObject &object, const Hit &hit, float time)
        : object_(object), corners_(object.surface.triangles[hit.primitive]), triangle_(hit.primitive),
          barycentrics_(1 - hit.u - hit.v, hit.u, hit.v), time_(time), first_(object.steps.data()) {
        if (kStill || object.steps.size() == 1) return;
        const std::size_t last = object.steps.size() - 1;
        const float at = time * static_cast<float>(last);
        const std::size_t before = std::min(static_cast<std::size_t>(at), last - 1);
        first_ += before;
        second_ = first_ + 1;
        u_ = at - static_cast<float>(before);
    }

    [[nodiscard]] const Index3 &corners() const { return corners_; }
    [[nodiscard]] const Vec3 &barycentrics() const { return barycentrics_; }
    /// Says which arrays are filled.
    [[nodiscard]] const SurfaceStep &step() const { return *first_; }

    /// A vertex array's value at the hit.
    template <class T> [[nodiscard]] T interpolate(std::vector<T> SurfaceStep::*values) const {
        return weighted(at(values, corners_.x), at(values, corners_.y), at(values, corners_.z));
    }

    /// In render space.
    [[nodiscard, gnu::always_inline]] InterpolatedSurface surface() const {
        const Vec3 p0 = at(&SurfaceStep::positions, corners_.x);
        const Vec3 p1 = at(&SurfaceStep::positions, corners_.y);
        const Vec3 p2 = at(&SurfaceStep::positions, corners_.z);
        InterpolatedSurface p;
        p.position = weighted(p0, p1, p2);
        const bool mirrored = object_.isMirrored(triangle_);
        p.e1 = mirrored ? p2 - p0 : p1 - p0;
        p.e2 = mirrored ? p1 - p0 : p2 - p0;
        p.normal = interpolate(&SurfaceStep::normals);
        p.tangent = interpolate(&SurfaceStep::tangents);
        p.corners = std::max(extentOf(p0), std::max(extentOf(p1), extentOf(p2)));
        if (object_.instanced) place(p, kStill ? object_.placements.front() : affineAt(object_.placements, time_));
        return p;
    }

    /// Whether V is one tensor for the triangle, as it is; else it is interpolated in the form of the object's scheme.
    [[nodiscard]] bool stretchIsConstant() const { return object_.stretchOnFaces() || first_->stretch.size() == 1; }
    /// V, where the step has it.
    [[nodiscard, gnu::always_inline]] SymmetricTensor stretch() const {
        if (first_->stretch.size() == 1) return at(&SurfaceStep::stretch, 0);
        return object_.stretchOnFaces() ? at(&SurfaceStep::stretch, triangle_) : interpolate(&SurfaceStep::stretch);
    }

  private:
    template <class T> [[nodiscard]] T at(std::vector<T> SurfaceStep::*values, Index i) const {
        const T &a = (first_->*values)[i];
        return kStill || second_ == nullptr ? a : mix(a, (second_->*values)[i]);
    }
    template <class T> [[nodiscard]] T weighted(const T &x, const T &y, const T &z) const {
        return x * barycentrics_.x + y * barycentrics_.y + z * barycentrics_.z;
    }
    [[nodiscard]] SymmetricTensor weighted(const SymmetricTensor &x, const SymmetricTensor &y, const SymmetricTensor &z) const {
        return {weighted(x.diagonal, y.diagonal, z.diagonal), weighted(x.offDiagonal, y.offDiagonal, z.offDiagonal)};
    }
    template <class T> [[nodiscard]] T mix(const T &x, const T &y) const { return glm::mix(x, y, u_); }
    [[nodiscard]] SymmetricTensor mix(const SymmetricTensor &x, const SymmetricTensor &y) const {
        return {glm::mix(x.diagonal, y.diagonal, u_), glm::mix(x.offDiagonal, y.offDiagonal, u_)};
    }

    const RenderObject &object_;
    Index3 corners_;
    Index triangle_;
    Vec3 barycentrics_;
    float time_;
    const SurfaceStep *first_;
    const SurfaceStep *second_ = nullptr;
    float u_ = 0;
};

} // namespace taut
