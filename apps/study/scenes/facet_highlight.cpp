#include "study/scenes/facet_highlight.h"

#include "study/scenes/sampling_plate.h"

#include "taut/base/parallel.h"
#include "taut/bsdf/bsdf.h"
#include "taut/render/embree_scene.h"

namespace taut::chart {

namespace {

constexpr float kSky = 0.1F;
constexpr int kMostBounces = 32;

/// Radiance that a point of the plate receives from wi; the eye is where sampling_plate.h has it, the lamp larger.
float radianceFrom(const Vec3 &position, const Vec3 &wi) {
    static const LampLight kLamp{{-0.35F, 1.5F, 0.7F}, {0.7F, 0, 0}, {0, 0.25F, 0.5F}};
    return wi.z > 0 ? kSky + kLamp.radianceFrom(position, wi) : 0.0F;
}

/// A place on the plate and the direction to the eye, of a pixel and two random numbers.
struct View {
    Vec3 position, wo;
};
View viewOf(int pixel, const Vec2 &u) {
    const float x = (static_cast<float>(pixel % kHighlightSize) + u.x) / kHighlightSize;
    const float y = (static_cast<float>(pixel / kHighlightSize) + u.y) / kHighlightSize;
    const Vec3 position(2 * x - 1, 1 - 2 * y, 0); // rows from the top
    return {position, glm::normalize(Vec3(0, -2.0F, 1.6F) - position)};
}

/// A picture, pixel by pixel: `mean`(pixel) is its radiance.
template <class Mean> Pixels picture(const Mean &mean) {
    Pixels pixels(3 * std::size_t{kHighlightSize} * kHighlightSize, 1.0F);
    parallelFor(pixels.size() / 3, 16, [&](std::size_t i) {
        const auto value = static_cast<float>(mean(static_cast<int>(i)));
        pixels[3 * i] = pixels[3 * i + 1] = pixels[3 * i + 2] = value;
    });
    return pixels;
}

} // namespace

struct FacetPatch::State {
    MicroTransform m;
    std::vector<Vec3> positions; ///< one more than is indexed
    std::vector<Index3> triangles;
    float top = 0;
    EmbreeScene embree{false};
};

FacetPatch::FacetPatch(const Mesh &patch, const MicroTransform &m) : state_(std::make_unique<State>()) {
    state_->m = m;
    state_->positions = patch.positions;
    for (const Vec3 &p : patch.positions) state_->top = std::fmax(state_->top, p.z);
    state_->positions.emplace_back(0);
    for (std::size_t f = 0; f < patch.faceCount(); ++f) {
        const Index *corner = &patch.cornerPositions[patch.faceOffsets[f]];
        state_->triangles.emplace_back(corner[0], corner[1], corner[2]);
    }
    state_->embree.addTriangles({state_->positions}, {state_->triangles});
    state_->embree.commit();
}

FacetPatch::~FacetPatch() = default;

Pixels FacetPatch::render(int samples, bool allBounces, std::uint32_t seed) const {
    const State &s = *state_;
    const auto count = static_cast<std::size_t>(samples);
    return picture([&](int pixel) {
        const std::uint32_t name = hash(static_cast<std::uint32_t>(pixel), seed);
        std::vector<Ray> rays(count);
        std::vector<Vec3> positions(count);
        std::vector<Hit> hits(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const View view = viewOf(pixel, sobol2(i, name));
            // A point of the mean plane, far enough from the rim for the way past the highest facets.
            const Vec2 disk = 0.6F * squareToDisk(sobol2(i, hash(name, 1)));
            const Vec3 target(s.m.a * disk.x + s.m.b * disk.y, s.m.d * disk.y, 0);
            rays[i].origin = target + (1.01F * s.top / view.wo.z) * view.wo;
            rays[i].direction = -view.wo;
            positions[i] = view.position;
        }
        double sum = 0;
        for (int bounce = 0; bounce < kMostBounces && !rays.empty(); ++bounce) {
            hits.resize(rays.size());
            s.embree.intersect(rays, false, hits);
            std::size_t left = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (hits[i].geometry == kNone) { // out
                    if (bounce > 0) sum += static_cast<double>(radianceFrom(positions[i], rays[i].direction));
                    continue;
                }
                if (bounce > 0 && !allBounces) continue; // shadowed
                const Index3 &corners = s.triangles[hits[i].primitive];
                const Vec3 &a = s.positions[corners.x];
                const Vec3 n = glm::normalize(glm::cross(s.positions[corners.y] - a, s.positions[corners.z] - a));
                const Vec3 at = rays[i].origin + hits[i].t * rays[i].direction;
                const Vec3 wi = glm::normalize(glm::reflect(rays[i].direction, n));
                rays[left].origin = at + 1e-6F * n;
                rays[left].direction = wi;
                positions[left] = positions[i];
                ++left;
            }
            rays.resize(left);
        }
        return sum / samples;
    });
}

Pixels renderMicrosurface(const MicroTransform &m, int samples, bool allBounces, std::uint32_t seed) {
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.micro = m;
    bsdf.f0 = Vec3(1);
    bsdf.multiscatter = allBounces ? Multiscatter::Walk : Multiscatter::Off;
    return picture([&](int pixel) {
        const std::uint32_t name = hash(static_cast<std::uint32_t>(pixel), seed);
        double sum = 0;
        for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(samples); ++i) {
            const View view = viewOf(pixel, sobol2(i, name));
            const ScatteringPoint point(bsdf, view.wo);
            const auto s = point.sample(sobol2(i, hash(name, 1)), sobol1(i, hash(name, 2)), hash(i, name));
            if (s) sum += static_cast<double>(s->weight.x * radianceFrom(view.position, s->wi));
        }
        return sum / samples;
    });
}

} // namespace taut::chart
