#include "taut/render/aov.h"

#include "taut/base/error.h"
#include "taut/render/shading.h"

#include <algorithm>

namespace taut {

namespace {

void put(float *out, const Vec2 &v) {
    out[0] = v.x;
    out[1] = v.y;
}
void put(float *out, const Vec3 &v) {
    for (int c = 0; c < 3; ++c) out[c] = v[c];
}

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

/// M, with its lean, in the frame whose z is the normal of the facet, the shading normal on the viewer's side where no map tilts it, and
/// whose x is the rotated tangent R t0 (polar decomposition A = V R), made perpendicular to that.
MicroTransform inTangentFrame(const SurfacePoint &point) {
    const MicroTransform &m = point.bsdf.micro;
    Vec2 t = point.tangent;
    if (point.tilted) {
        const Vec2 seen(point.facet.toLocal(point.frame.fromLocal(Vec3(t, 0))));
        const float length = glm::length(seen);
        if (length > 0) t = seen / length;
    }
    return microTransform(t.x * m.a, t.x * m.b + t.y * m.d, -t.y * m.a, t.x * m.d - t.y * m.b, t.x * m.p + t.y * m.q,
                          t.x * m.q - t.y * m.p);
}

const std::vector<AovInfo> kTable{
    {"depth", {"Z"}, [](const RenderScene &, const SurfacePoint &p, float *out) { *out = -p.position.z; }},
    {"albedo", {"Albedo.R", "Albedo.G", "Albedo.B"}, [](const RenderScene &, const SurfacePoint &p, float *out) { put(out, p.baseColor); }},
    {"normal",
     {"N.X", "N.Y", "N.Z"},
     [](const RenderScene &s, const SurfacePoint &p, float *out) { put(out, worldVector(s, p.geometricNormal)); }},
    {"shading_normal",
     {"Ns.X", "Ns.Y", "Ns.Z"},
     [](const RenderScene &s, const SurfacePoint &p, float *out) { put(out, worldVector(s, p.frame.n)); }},
    {"facet_normal", // n' of a mapped facet, on the viewer's side
     {"Nf.X", "Nf.Y", "Nf.Z"},
     [](const RenderScene &s, const SurfacePoint &p, float *out) { put(out, worldVector(s, p.facet.n)); }},
    {"position",
     {"P.X", "P.Y", "P.Z"},
     [](const RenderScene &s, const SurfacePoint &p, float *out) { put(out, worldPoint(s, p.position)); }},
    {"rest_position",
     {"Pref.X", "Pref.Y", "Pref.Z"},
     [](const RenderScene &, const SurfacePoint &p, float *out) { put(out, restPosition(p)); }},
    {"uv", {"u", "v"}, [](const RenderScene &, const SurfacePoint &p, float *out) { put(out, p.uv.first); }},
    {"m", // a, b, d of the upper triangular one
     {"M.X", "M.Y", "M.Z"},
     [](const RenderScene &, const SurfacePoint &p, float *out) {
         const MicroTransform m = inTangentFrame(p);
         put(out, Vec3(m.a, m.b, m.d));
     }},
    {"lean", // p, q of its third column
     {"Lean.X", "Lean.Y"},
     [](const RenderScene &, const SurfacePoint &p, float *out) {
         const MicroTransform m = inTangentFrame(p);
         put(out, Vec2(m.p, m.q));
     }},
    {"stretch", // singular values of A, the greater first
     {"Stretch.X", "Stretch.Y"},
     [](const RenderScene &, const SurfacePoint &p, float *out) {
         put(out, singularValues(p.stretch.x, p.stretch.y, p.stretch.y, p.stretch.z));
     }},
    {"alpha", // greatest, least, phi of the greatest from the rotated tangent in radians
     {"Alpha.X", "Alpha.Y", "Alpha.Z"},
     [](const RenderScene &, const SurfacePoint &p, float *out) {
         const EquivalentAlpha alpha = equivalentAlpha(inTangentFrame(p));
         put(out, Vec3(alpha.max, alpha.min, alpha.phi));
     }},
};

} // namespace

std::span<const AovInfo> aovTable() {
    return kTable;
}

const AovInfo &infoOf(Aov aov) {
    return kTable[static_cast<std::size_t>(aov)];
}

std::optional<Aov> findAov(std::string_view name) {
    for (std::size_t i = 0; i < kTable.size(); ++i)
        if (kTable[i].name == name) return static_cast<Aov>(i);
    return std::nullopt;
}

std::vector<Aov> aovsNamed(std::span<const std::string_view> names, std::string_view option) {
    std::vector<Aov> aovs;
    const auto add = [&](Aov aov) {
        if (std::find(aovs.begin(), aovs.end(), aov) == aovs.end()) aovs.push_back(aov);
    };
    for (const std::string_view name : names) {
        if (name == "all") {
            for (std::size_t i = 0; i < kTable.size(); ++i) add(static_cast<Aov>(i));
            continue;
        }
        const std::optional<Aov> aov = findAov(name);
        if (!aov) {
            std::vector<std::string_view> valid;
            for (const AovInfo &info : kTable) valid.push_back(info.name);
            valid.emplace_back("all");
            failUnknownName({std::string(option)}, name, valid);
        }
        add(*aov);
    }
    return aovs;
}

void writeAovs(const RenderScene &scene, const SurfacePoint &point, std::span<const Aov> aovs, float *out) {
    for (const Aov aov : aovs) {
        const AovInfo &info = infoOf(aov);
        info.write(scene, point, out);
        out += info.channels.size();
    }
}

} // namespace taut
