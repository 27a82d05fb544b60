#include "taut/render/facet.h"

#include "taut/microsurface/mesostructure.h"

namespace taut {

namespace {

/// Normals of a facet that face away from its mesh, or nearly, are not followed: no map means an overhang.
constexpr float kLeastFacing = 1e-3F;

Vec2 held(const Vec2 &slope) {
    const float length = glm::length(slope);
    if (!(length < kInfinity)) return Vec2(0);
    return length > kSteepestSlope ? slope * (kSteepestSlope / length) : slope;
}

/// A triangle's metric at rest.
UvMetric uvMetric(const SurfacePoint &point, const TextureSampler &sampler) {
    const Surface &surface = point.object->surface;
    const std::vector<Vec3> &points = point.object->mesh().positions;
    const std::vector<Vec2> &uvs = sampler.uvSet == 1 ? surface.uvs1 : surface.uvs;
    if (uvs.empty()) return {};
    const auto rest = [&](Index vertex) { return surface.restFromObject * points[surface.surfacePosition[surface.vertexSurface[vertex]]]; };
    const auto place = [&](Index vertex) {
        const Vec2 uv = uvs[vertex];
        if (!sampler.moved) return uv;
        const Vec3 down(uv.x, 1 - uv.y, 1);
        return Vec2(glm::dot(sampler.moveU, down), 1 - glm::dot(sampler.moveV, down));
    };
    const Index3 &t = point.corners;
    const DVec3 e1(rest(t.y) - rest(t.x));
    const DVec3 e2(rest(t.z) - rest(t.x));
    const DVec2 d1(place(t.y) - place(t.x));
    const DVec2 d2(place(t.z) - place(t.x));
    const double det = d1.x * d2.y - d1.y * d2.x;
    if (det == 0) return {};
    const DVec3 du = (e1 * d2.y - e2 * d1.y) / det;
    const DVec3 dv = (e2 * d1.x - e1 * d2.x) / det;
    const double ux = glm::length(du);
    if (!(ux > 0)) return {};
    const double vx = glm::dot(du, dv) / ux;
    return {static_cast<float>(ux), static_cast<float>(vx), static_cast<float>(std::sqrt(std::max(0.0, glm::dot(dv, dv) - vx * vx)))};
}

/// Tangents and normals are interpolated as they are, and what a map bakes counts on them as they come out (MikkTSpace): the direction
/// x T + y B + z N, its slope in the orthonormal frame of the point.
Vec2 inPointFrame(const Vec2 &slope, const InterpolatedSurface &at) {
    const Vec3 tangent(at.tangent);
    const float length = glm::length(at.normal);
    if (!(length > 0)) return slope;
    const float along = glm::dot(tangent, at.normal) / length;
    const float across = std::sqrt(std::fmax(0.0F, glm::dot(tangent, tangent) - along * along));
    const float up = slope.x * along + length;
    if (!(across > 0) || !(up > 0)) return slope;
    return Vec2(slope.x, slope.y * length) * (across / up);
}

Vec2 decoded(const SlopeMap &map, const Vec3 &texel, const SlopePlace &place, const TextureSampler &sampler) {
    switch (map.kind) {
    case SlopeMap::Kind::Normal: {
        const Vec3 n = 2.0F * texel - Vec3(1);
        const Vec2 side(n.x, n.y);
        const float least = glm::length(side) / kSteepestSlope;
        return side * (map.scale / std::fmax(std::fmax(n.z, least), 1e-6F));
    }
    case SlopeMap::Kind::Bump: return Vec2(texel) * map.scale;
    case SlopeMap::Kind::Height: {
        const UvMetric g = uvMetric(place.point, sampler);
        if (!(g.ux > 0 && g.vy > 0)) return Vec2(0);
        return Vec2(texel.x / g.ux, (texel.y - texel.x * g.vx / g.ux) / g.vy) * map.scale;
    }
    }
    return Vec2(0);
}

/// From the rest frame to the shading frame where nothing is stretched.
DMat3 turnOf(const SurfacePoint &point, float sense) {
    const DVec2 t(point.tangent);
    const DVec2 b = DVec2(-t.y, t.x) * static_cast<double>(sense);
    return surfaceDeformation({t.x, b.x, t.y, b.y});
}

} // namespace

SlopeStatistics slopesAt(const SlopeMap &map, const SlopePlace &place) {
    if (!map.isGiven()) return {};
    const Texture &texture = place.scene.textures[map.texture];
    const Vec3 texel(lookup(texture, place.point.uv));
    const Vec2 slope = inPointFrame(decoded(map, texel, place, texture.sampler), place.at);
    return {held(slope) * place.point.facing, Vec3(0)};
}

DMat3 deformationOf(const Material &material, const SurfacePoint &point, float sense) {
    const DVec3 v(point.stretch);
    const bool leans = point.object != nullptr && point.object->object->lean;
    const double area = std::fabs(v.x * v.z - v.y * v.y);
    const double lambda = material.poisson == 0 || leans
                              ? 1.0
                              : static_cast<double>(normalStretch(std::fmax(static_cast<float>(area), 1e-12F), material.poisson));
    const DVec2 t = DVec2(point.tangent) / lambda;
    const DVec2 b = DVec2(-t.y, t.x) * static_cast<double>(sense);
    return surfaceDeformation({v.x * t.x + v.y * t.y, v.x * b.x + v.y * b.y, v.y * t.x + v.z * t.y, v.y * b.x + v.z * b.y},
                              leans ? DVec2(point.lean) : DVec2(0));
}

HitFacet facetAt(const Material &material, const RestRoughness &rest, const SlopeStatistics &slopes, const SurfacePoint &point, float sense,
                 const MicroTransform &plain) {
    HitFacet facet{{}, plain, false};
    if (slopes.mean == Vec2(0) && slopes.covariance == Vec3(0)) return facet;
    const auto axis = rest.rotation == 0 ? Vector2<double>(1, 0) : Vector2<double>(std::cos(rest.rotation), std::sin(rest.rotation));
    const BasicBlock<double> block = restBlock<double>(static_cast<double>(rest.alphaX), static_cast<double>(rest.alphaY), axis);
    const bool stored = !point.object->storedPoisson.empty(); // then nothing is known of A, and the facet turns alone
    const auto mapped = mappedTransform(stored ? turnOf(point, sense) : deformationOf(material, point, sense), slopes, block);
    if (!mapped || !(mapped->frame.n.z > kLeastFacing)) return facet;
    facet.frame = mapped->frame;
    facet.tilted = true;
    if (material.facets == FacetModel::Leans && !stored) facet.micro = mapped->micro;
    return facet;
}

} // namespace taut
