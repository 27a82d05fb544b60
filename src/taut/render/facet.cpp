#include "taut/render/facet.h"

#include "taut/scene/texture_pyramid.h"

#include "taut/microsurface/mesostructure.h"

namespace taut {

namespace {

Vec2 held(const Vec2 &slope) {
    const float length = glm::length(slope);
    if (!(length < kInfinity)) return Vec2(0);
    return length > kSteepestSlope ? slope * (kSteepestSlope / length) : slope;
}

/// A triangle's metric at rest.
UvMetric uvMetric(const SlopePlace &place, const TextureSampler &sampler) {
    const Surface &surface = place.object.surface;
    const std::vector<Vec3> &points = place.object.mesh().positions;
    const std::vector<Vec2> &uvs = sampler.uvSet == 1 ? surface.uvs1 : surface.uvs;
    if (uvs.empty()) return {};
    const auto rest = [&](Index vertex) { return surface.restFromObject * points[surface.surfacePosition[surface.vertexSurface[vertex]]]; };
    const auto moved = [&](Index vertex) {
        const Vec2 uv = uvs[vertex];
        if (!sampler.moved) return uv;
        const Vec3 down(uv.x, 1 - uv.y, 1);
        return Vec2(glm::dot(sampler.moveU, down), 1 - glm::dot(sampler.moveV, down));
    };
    const Index3 &t = place.corners;
    const DVec3 e1(rest(t.y) - rest(t.x));
    const DVec3 e2(rest(t.z) - rest(t.x));
    const DVec2 d1(moved(t.y) - moved(t.x));
    const DVec2 d2(moved(t.z) - moved(t.x));
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
SlopeScale scaleOf(const SlopeMap &map, const SlopePlace &place, const TextureSampler &sampler) {
    if (map.kind != SlopeMap::Kind::Height) return {{map.scale, 0}, {0, map.scale}};
    const UvMetric g = uvMetric(place, sampler);
    if (!(g.ux > 0 && g.vy > 0)) return {Vec2(0), Vec2(0)};
    return {Vec2(1, -g.vx / g.vy) * (map.scale / g.ux), {0, map.scale / g.vy}};
}

/// From the rest frame to the shading frame where nothing is stretched.
DMat3 turnOf(const SurfacePoint &point, float sense) {
    return surfaceDeformation(DVec3(1, 0, 1), DVec2(point.tangent), static_cast<double>(sense), 1);
}

/// The mesh's deformation there, from the rest frame (t0, b0, n) to the point's shading frame, over lambda.
DMat3 deformationOf(const Material &material, const SurfacePoint &point, float sense) {
    const bool leans = point.object->object->lean;
    const float lambda = material.poisson == 0 || leans ? 1.0F : lambdaOf(point.stretch, material.poisson);
    return surfaceDeformation(DVec3(point.stretch), DVec2(point.tangent), static_cast<double>(sense), 1 / static_cast<double>(lambda),
                              leans ? DVec2(point.lean) : DVec2(0));
}

} // namespace

SlopeStatistics slopesAt(const SlopeMap &map, const SlopePlace &place) {
    if (!map.isGiven()) return {};
    const Texture &texture = place.scene.textures[map.texture];
    const UvPoint &uv = place.uv;
    const int set = texture.sampler.uvSet;
    const SlopeScale scale = scaleOf(map, place, texture.sampler);
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
    slopes.mean = held(inPointFrame(slopes.mean, place.at));
    return slopes;
}

HitFacet facetAt(const Material &material, const RestRoughness &rest, const SlopeStatistics &slopes, const SurfacePoint &point, float sense,
                 const MicroTransform &plain) {
    HitFacet facet{{}, plain, false};
    if (!slopes.tilt()) return facet;
    const SlopeStatistics seen{slopes.mean * point.facing, slopes.covariance};
    const auto axis = rest.rotation == 0 ? Vector2<double>(1, 0) : Vector2<double>(std::cos(rest.rotation), std::sin(rest.rotation));
    const BasicBlock<double> block = restBlock<double>(static_cast<double>(rest.alphaX), static_cast<double>(rest.alphaY), axis);
    const bool stored = !point.object->storedPoisson.empty(); // then nothing is known of A, and the facet turns alone
    const auto mapped = mappedTransform(stored ? turnOf(point, sense) : deformationOf(material, point, sense), seen, block);
    if (!mapped || !(mapped->frame.n.z > kLeastFacing)) return facet;
    facet.frame = mapped->frame;
    facet.tilted = true;
    if (material.facets == FacetModel::Leans && !stored) facet.micro = mapped->micro;
    return facet;
}

} // namespace taut
