#include "taut/render/aov.h"

namespace taut {

namespace {

Vec3 worldPoint(const RenderScene &scene, const Vec3 &p) {
    return Vec3(DVec3(scene.worldFromRender() * glm::dvec4(DVec3(p), 1)));
}
Vec3 worldVector(const RenderScene &scene, const Vec3 &v) {
    return Vec3(DMat3(scene.worldFromRender()) * DVec3(v));
}

/// Rest position, object space, of the control mesh (of the refined one under subdivision).
Vec3 restPosition(const SurfacePoint &point) {
    const Surface &surface = point.object->surface;
    const std::vector<Vec3> &positions = point.object->mesh().positions;
    const auto at = [&](Index vertex) { return positions[surface.surfacePosition[surface.vertexSurface[vertex]]]; };
    return at(point.corners.x) * point.barycentrics.x + at(point.corners.y) * point.barycentrics.y +
           at(point.corners.z) * point.barycentrics.z;
}

/// M turned from the shading frame into the frame of the rotated tangent.
MicroTransform inTangentFrame(const SurfacePoint &point) {
    const MicroTransform &m = point.bsdf.micro;
    const Vec2 t = point.tangent;
    return microTransform(t.x * m.a, t.x * m.b + t.y * m.d, -t.y * m.a, t.x * m.d - t.y * m.b);
}

} // namespace

void writeAovs(const RenderScene &scene, const SurfacePoint &point, std::span<const Aov> aovs, float *out) {
    const MicroTransform m = inTangentFrame(point);
    const auto put3 = [&](const Vec3 &v) {
        for (int c = 0; c < 3; ++c) *out++ = v[c];
    };
    for (const Aov aov : aovs) {
        switch (aov) {
        case Aov::Depth: *out++ = -point.position.z; break;
        case Aov::Albedo: put3(point.baseColor); break;
        case Aov::Normal: put3(worldVector(scene, point.geometricNormal)); break;
        case Aov::ShadingNormal: put3(worldVector(scene, point.frame.n)); break;
        case Aov::Position: put3(worldPoint(scene, point.position)); break;
        case Aov::RestPosition: put3(restPosition(point)); break;
        case Aov::Uv:
            *out++ = point.uv.x;
            *out++ = point.uv.y;
            break;
        case Aov::M: put3({m.a, m.b, m.d}); break;
        case Aov::Stretch: {
            const Vec2 sigma = singularValues(point.stretch.x, point.stretch.y, point.stretch.y, point.stretch.z);
            *out++ = sigma.x;
            *out++ = sigma.y;
            break;
        }
        case Aov::Alpha: {
            const EquivalentAlpha alpha = equivalentAlpha(m);
            put3({alpha.max, alpha.min, alpha.phi});
            break;
        }
        }
    }
}

} // namespace taut
