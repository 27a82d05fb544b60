#include "taut/render/facet.h"

#include "taut/scene/texture_pyramid.h"

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

/// From slopes as the map's pyramid has them to those in the rest tangent frame, in metres per metre: columns.
struct SlopeScale {
    Vec2 x{1, 0}, y{0, 1};
    [[nodiscard]] Vec2 times(const Vec2 &s) const { return x * s.x + y * s.y; }
    /// xx, xy, yy of G C G^T.
    [[nodiscard]] Vec3 times(const Vec3 &c) const {
        const auto entry = [&](int i, int j) { return x[i] * x[j] * c.x + (x[i] * y[j] + y[i] * x[j]) * c.y + y[i] * y[j] * c.z; };
        return {entry(0, 0), entry(0, 1), entry(1, 1)};
    }
};
SlopeScale scaleOf(const SlopeMap &map, const SurfacePoint &point, const TextureSampler &sampler) {
    if (map.kind != SlopeMap::Kind::Height) return {{map.scale, 0}, {0, map.scale}};
    const UvMetric g = uvMetric(point, sampler);
    if (!(g.ux > 0 && g.vy > 0)) return {Vec2(0), Vec2(0)};
    return {Vec2(1, -g.vx / g.vy) * (map.scale / g.ux), {0, map.scale / g.vy}};
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
    const UvPoint &uv = place.point.uv;
    const int set = texture.sampler.uvSet;
    const SlopeScale scale = scaleOf(map, place.point, texture.sampler);
    const UvFootprint &footprint = uv.footprintOf(set);
    SlopeStatistics slopes;
    if (texture.slopes && footprint.isGiven() && texture.slopes->levelOf(texture.sampler, footprint) > 0) {
        const TexturePyramid::Values m = texture.slopes->mean(texture.sampler, uv.set(set), footprint);
        const Vec3 covariance(m[2] - m[0] * m[0], m[3] - m[0] * m[1], m[4] - m[1] * m[1]);
        slopes = {scale.times(Vec2(m[0], m[1])), scale.times(covariance)};
        slopes.covariance.x = std::fmax(slopes.covariance.x, 0.0F);
        slopes.covariance.z = std::fmax(slopes.covariance.z, 0.0F);
    } else {
        const Vec3 texel(lookup(texture, uv.set(set)));
        slopes.mean = scale.times(map.kind == SlopeMap::Kind::Normal ? slopeOfNormal(texel) : Vec2(texel));
    }
    slopes.mean = held(inPointFrame(slopes.mean, place.at)) * place.point.facing;
    return slopes;
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
