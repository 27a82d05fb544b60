#pragma once
/// Multiple scattering on the transformed GGX microsurface, exactly: a random walk of light from facet to facet
/// (Heitz, Hanika, d'Eon & Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model"), for every M.
///
/// Directions are in local shading space, unit. The transform leaves heights alone, so a flight between facets is that of the
/// standard microsurface along M^-1 w; a bounce takes a visible normal and reflects or refracts in local space. Heights enter only
/// through the share C1(h) of the surface that lies below h, kept as the depth -ln C1(h): 0 at the top, infinite at the bottom.
/// A flight then is depth -> depth + e / (-Lambda(w)), e exponential, Lambda signed: out of the surface where it ends above 0.
/// Light on the far side of the interface is walked in the point-mirrored surface, which has the same statistics: there the
/// signs of directions are turned and C1 becomes 1 - C1.
///
/// An Interface says what a facet does to light. `kTransmits` false, and
///     Vec3 reflectance(float cosine, bool beyond) const
/// or `kTransmits` true, the same function with three equal channels, and
///     float relativeIndex(bool beyond) const          index on the other side / index on the side of the light
///     bool refract(const Vec3 &v, const Vec3 &wm, float cosine, bool beyond, Vec3 &w) const
/// `beyond`: the light is on the far side of the interface. `cosine` = <v, wm> > 0, v points back along the light.

#include "taut/microsurface/facet.h"
#include "taut/microsurface/ggx.h"
#include "taut/microsurface/walk_depth.h"

namespace taut::walk {

/// PCG32 (O'Neill 2014, XSH RR): what one walk draws its numbers from.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL + 0xda3e39cb94b95bdbULL) { bits(); }
    std::uint32_t bits() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ULL + 1442695040888963407ULL;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> turn) | (shifted << ((32 - turn) & 31));
    }
    /// In [0, 1).
    float uniform() { return static_cast<float>(bits() >> 8) * 0x1p-24F; }
    /// Exponential with mean 1, in (0, 23).
    float exponential() { return -std::log((static_cast<float>(bits()) + 0.5F) * 0x1p-32F); }

  private:
    std::uint64_t state_;
};

/// What the first and the last facet of an evaluated walk are drawn by, uniform in [0, 1): worth stratifying.
struct Ends {
    Vec2 first{0.5F}, last{0.5F};
};
/// With what all facets between draw from.
struct Numbers {
    Ends ends;
    std::uint32_t seed = 0;
};
inline Ends drawEnds(Random &random) {
    Ends ends;
    for (float *u : {&ends.first.x, &ends.first.y, &ends.last.x, &ends.last.y}) *u = random.uniform(); // in this order
    return ends;
}
inline Numbers numbersOf(std::uint32_t seed) {
    Random random(seed);
    const Ends ends = drawEnds(random);
    return {ends, random.bits()};
}

/// Facets after which a walk is given up: the light that is still inside is lost. At alpha = 10 that is less than 1e-5 of it.
inline constexpr int kMostBounces = 1024;
/// Facets after which dim walks end by Russian roulette.
inline constexpr int kRouletteStart = 4;

/// Light that meets a facet.
struct Vertex {
    Vec3 v;              ///< back along the light, in the frame of its side (turned over where beyond)
    float depth;         ///< -ln C1 of the height, in the frame of its side
    Vec3 throughput;     ///< of everything before this facet
    int bounce;          ///< 1: the first facet
    bool beyond = false; ///< on the far side of the interface
};

/// Where a walk leaves the surface.
struct Exit {
    Vec3 w;              ///< unit, local
    Vec3 throughput{1};  ///< energy; radiance carried across the interface is this / eta^2
    int bounces = 0;     ///< facets met
    bool beyond = false; ///< left through the far side, w.z < 0
};

/// Depth of the same height seen from the other side: -ln(1 - exp(-depth)).
inline float turnedDepth(float depth) {
    return depth > 60 ? 1e-26F : std::fmin(-std::log(-std::expm1(-depth)), 60.0F);
}

/// Depth at the end of a flight along `w` (unit, frame of its side) from `depth`; negative: the light is out. `e` is exponential.
inline float flight(const MicroTransform &m, const Vec3 &w, float depth, float e) {
    const Vec3 s = m.inverse(w);
    const float xy2 = s.x * s.x + s.y * s.y;
    const float length = std::sqrt(xy2 + s.z * s.z);
    // 1 / Lambda = 2 z / (L - z); upwards with L - z = xy^2 / (L + z), which does not cancel.
    if (s.z < 0) return depth - 2 * e * s.z / (length - s.z);
    const float up = 2 * e * s.z * (length + s.z);
    return up >= depth * xy2 ? -1.0F : depth - up / xy2;
}

/// Depth of the first facet for a viewer at wo: Lambda(-wo) = -1 - Lambda(wo). For wo below the horizon all heights alike, the limit
/// that gives Tokuyoshi's 2021 weight.
inline float firstDepth(const MicroTransform &m, const Vec3 &wo, float e) {
    return wo.z > 0 ? std::fmax(e / (1 + ggx::lambda(m, wo)), 1e-30F) : e;
}

/// Chance to leave upwards along `w` (w.z > 0, frame of its side) from `depth`: exp(-depth Lambda(w)).
inline float escape(const MicroTransform &m, const Vec3 &w, float depth) {
    return std::exp(-depth * ggx::lambda(m, w));
}

/// Density (solid angle of wi) of light that comes from v and is reflected by a facet towards wi, without Fresnel:
/// D(h) / (2 (v.z + L(v))). `cosine` receives <v, wm>.
inline float reflectionDensity(const MicroTransform &m, const Vec3 &v, float area, const Vec3 &wi, float &cosine) {
    const Vec3 h = v + wi;
    cosine = 0.5F * glm::length(h); // |v + wi|^2 = 2 (1 + <v, wi>)
    return ggx::distribution(m, v, wi) / (2 * area);
}

/// Density of light that comes from v and is refracted by a facet towards wi on the other side, without Fresnel (Walter et al. 2007,
/// eq. 21); 0 where no facet can do it.
inline float refractionDensity(const MicroTransform &m, const Vec3 &v, float area, const Vec3 &wi, float eta, float &cosine) {
    const Vec3 h = facet::refractionHalf(v, wi, eta);
    const float inverse = 1 / glm::length(h);
    cosine = glm::dot(v, h) * inverse;
    const float jacobian = facet::refractionJacobian(cosine, glm::dot(wi, h) * inverse, eta);
    return jacobian > 0 ? 2 * cosine * ggx::distribution(m, h) / area * jacobian : 0.0F;
}

/// Light scattered at `vertex` straight to `wi` (frame of the viewer, either side), with `leaving`(same side, direction upwards in
/// the frame of the side it leaves through) the chance to get out. Per solid angle, energy.
template <class Interface, class Leaving>
Vec3 nextEvent(const MicroTransform &m, const Interface &interface, const Vertex &vertex, const Vec3 &wi, const Leaving &leaving) {
    const Vec3 w = vertex.beyond ? -wi : wi;
    const float area = ggx::visibleArea(m, vertex.v, ggx::stretchedLength(m, vertex.v));
    float cosine = 0;
    if (w.z > 0) {
        const float density = reflectionDensity(m, vertex.v, area, w, cosine);
        if (!(density > 0)) return Vec3(0);
        return interface.reflectance(cosine, vertex.beyond) * (density * leaving(true, w));
    }
    if constexpr (Interface::kTransmits) {
        const float density = refractionDensity(m, vertex.v, area, w, interface.relativeIndex(vertex.beyond), cosine);
        if (!(density > 0)) return Vec3(0);
        return (Vec3(1) - interface.reflectance(cosine, vertex.beyond)) * (density * leaving(false, -w));
    }
    return Vec3(0);
}

/// Walks light from a viewer at wo. `first` are uniform numbers of the first facet (stratified ones pay off here). `visit` is called
/// with every Vertex; a walk that is given up returns a throughput of 0.
template <class Interface, class Visit>
Exit trace(const MicroTransform &m, const Vec3 &wo, const Interface &interface, const Vec2 &first, Random &random, const Visit &visit) {
    Vertex x{wo, firstDepth(m, wo, random.exponential()), Vec3(1), 1, false};
    Vec2 u = first;
    for (; x.bounce <= kMostBounces; ++x.bounce, u = {random.uniform(), random.uniform()}) {
        visit(x);
        const Vec3 wm = ggx::sampleVisibleNormal(m, x.v, u);
        const float cosine = glm::dot(x.v, wm);
        if (!(cosine > 0)) continue; // rounding: the facet is seen edge-on and the light passes it by
        const Vec3 reflected = interface.reflectance(cosine, x.beyond);
        Vec3 w;
        if constexpr (Interface::kTransmits) {
            if (random.uniform() < reflected.x || !interface.refract(x.v, wm, cosine, x.beyond, w)) {
                w = 2 * cosine * wm - x.v;
            } else {
                w = -w; // into the frame of the other side
                x.beyond = !x.beyond;
                x.depth = turnedDepth(x.depth);
            }
        } else {
            w = 2 * cosine * wm - x.v;
            x.throughput *= reflected;
        }
        w = glm::normalize(w);
        x.depth = flight(m, w, x.depth, random.exponential());
        if (x.depth < 0) return {x.beyond ? -w : w, x.throughput, x.bounce, x.beyond};
        x.v = -w;
        if (x.bounce < kRouletteStart) continue;
        const float survive = std::fmin(1.0F, 2 * maxComponent(x.throughput));
        if (survive < 1) {
            if (!(random.uniform() < survive)) break;
            x.throughput /= survive;
        }
    }
    return {Vec3(0, 0, 1), Vec3(0), x.bounce, false};
}

/// A direction by the whole walk; the throughput is the weight f cos / pdf with a density that nobody knows.
template <class Interface>
Exit sample(const MicroTransform &m, const Vec3 &wo, const Interface &interface, const Vec2 &first, Random &random) {
    return trace(m, wo, interface, first, random, [](const Vertex &) {});
}

/// Light of one bounce, f cos as energy per solid angle of wi, in closed form: the expectation of the walk's first facet, which is the
/// height-correlated lobe: 1 / (1 + Lo + Li) on one side, Beta(1 + Lo, 1 + Li) across (ggx::shadowing).
template <class Interface> Vec3 evaluateSingle(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const Interface &interface) {
    return nextEvent(m, interface, Vertex{wo, 0, Vec3(1), 1, false}, wi, [&](bool sameSide, const Vec3 &w) {
        const float lambdaI = ggx::lambda(m, w);
        if (!(wo.z > 0)) return 1 / (1 + lambdaI);
        const float lambdaO = ggx::lambda(m, wo);
        return (1 + lambdaO) * ggx::shadowing(lambdaO, lambdaI, sameSide, true);
    });
}

/// Light of two and more bounces between reflecting facets, as evaluateMultiple(): a walk whose heights are integrated out, which never
/// leaves by itself but carries the chance that it has not (DepthPhases). The last two facets of every path are found in two ways, by the
/// walk's own next direction and by one that is drawn backwards from wi, weighed by the balance heuristic (Veach & Guibas 1995): where
/// one lobe is narrow the other way does not miss it.
template <class Interface>
Vec3 evaluateReflected(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const Interface &interface, const Ends &ends,
                       Random &random) {
    float area = ggx::visibleArea(m, wo, ggx::stretchedLength(m, wo));
    if (!(wi.z > 0) || !(area > 0)) return Vec3(0);
    const float lambdaI = ggx::lambda(m, wi);
    const float areaI = ggx::visibleArea(m, wi, ggx::stretchedLength(m, wi));
    // Backwards from wi: along v, from the facet before the last.
    const Vec3 lastNormal = ggx::sampleVisibleNormal(m, wi, ends.last);
    const float lastCosine = glm::dot(wi, lastNormal);
    const Vec3 toLast = -glm::normalize(2 * lastCosine * lastNormal - wi);
    const Flight lastFlight(m, toLast);
    float ignored = 0;
    const float backwards = reflectionDensity(m, wi, areaI, -toLast, ignored);
    const bool hasLast = lastCosine > 0 && backwards > 0;
    const Vec3 lastReflectance = interface.reflectance(lastCosine, false);

    Vec3 sum(0);
    Vec3 v = wo;
    DepthPhases depth(wo.z > 0 ? Flight(m, -wo).rate() : 1.0F); // as firstDepth()
    Vec3 throughput(1);
    Vec2 u = ends.first;
    for (int bounce = 1; bounce < kMostBounces; ++bounce, u = {random.uniform(), random.uniform()}) {
        // v -> toLast -> wi. The lobe of a facet that sees -w is D / (2 area(-w)), and its flight's chance has the factor area(-w).
        float cosine = 0;
        const float forwards = reflectionDensity(m, v, area, toLast, cosine);
        if (hasLast && forwards > 0) {
            const float pair = forwards * backwards * areaI / (forwards + backwards) * depth.stopThenEscape(lastFlight, lambdaI);
            sum += throughput * interface.reflectance(cosine, false) * lastReflectance * pair;
        }
        const Vec3 wm = ggx::sampleVisibleNormal(m, v, u);
        cosine = glm::dot(v, wm);
        if (!(cosine > 0)) continue; // rounding: the facet is seen edge-on and the light passes it by
        const Vec3 w = glm::normalize(2 * cosine * wm - v);
        throughput *= interface.reflectance(cosine, false);
        const Flight flight(m, w);
        // v -> w -> wi.
        const float there = reflectionDensity(m, v, area, w, ignored);
        const float back = reflectionDensity(m, wi, areaI, -w, cosine);
        if (there > 0 && back > 0) {
            const float pair = there * back * areaI / (there + back) * depth.stopThenEscape(flight, lambdaI);
            sum += throughput * interface.reflectance(cosine, false) * pair;
        }
        throughput *= depth.stop(flight, random.uniform());
        const float survive = maxComponent(throughput);
        if (survive < 1) {
            if (!(random.uniform() < survive)) break;
            throughput /= survive;
        }
        v = -w;
        area = flight.area;
    }
    return sum;
}

/// Light of two and more bounces by next-event estimation at every facet of a walk (Heitz et al. 2016, section 7).
template <class Interface>
Vec3 evaluateByNextEvents(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const Interface &interface, const Vec2 &first,
                          Random &random) {
    Vec3 sum(0);
    trace(m, wo, interface, first, random, [&](const Vertex &x) {
        if (x.bounce == 1) return;
        sum += x.throughput * nextEvent(m, interface, x, wi, [&](bool sameSide, const Vec3 &w) {
                   return escape(m, w, sameSide ? x.depth : turnedDepth(x.depth));
               });
    });
    return sum;
}

/// An unbiased estimate of the light of two and more bounces: f cos as energy per solid angle of wi, by one walk from wo.
template <class Interface>
Vec3 evaluateMultiple(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const Interface &interface, const Ends &ends,
                      Random &random) {
    if constexpr (Interface::kTransmits)
        return evaluateByNextEvents(m, wo, wi, interface, ends.first, random);
    else
        return evaluateReflected(m, wo, wi, interface, ends, random);
}

/// Both: the whole f cos, an unbiased estimate.
template <class Interface>
Vec3 evaluate(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const Interface &interface, const Ends &ends, Random &random) {
    return evaluateSingle(m, wo, wi, interface) + evaluateMultiple(m, wo, wi, interface, ends, random);
}

/// A mirror of one reflectance: the white furnace where it is 1.
struct UniformReflector {
    static constexpr bool kTransmits = false;
    Vec3 color{1};
    [[nodiscard]] Vec3 reflectance(float, bool) const { return color; }
};

} // namespace taut::walk
