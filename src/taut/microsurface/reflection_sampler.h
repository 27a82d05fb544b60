#pragma once
/// Reflected directions of the transformed GGX without waste: visible normals, restricted to those that reflect above the
/// horizon. Every sample is used, where caps (Dupuy & Benyoub 2023; bounded: Eto & Tokuyoshi 2023) throw away most on a rough,
/// anisotropic or skewed surface. Derivation, equation numbers and measurements: docs/reflection_sampling.md.
///
/// In short: with o = M^-1 wo / L(wo), the standard normals m that reflect above the horizon fill a quadratic cone m^T K m > 0,
/// K = o z^T + z o^T - o.z M^-1 M^-T, on which visible normals have the density o.m. Seen along the axis e of the cone (K's one
/// positive eigenvector) it cuts an ellipse out of the unit sphere. A uniform point of that ellipse, lifted to the sphere, has the
/// density e.m; m and its mirror image through e, both in the cone, share their density in the ratio of o.m: one weighted coin.

#include "taut/microsurface/ggx.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace taut {

/// The cone of the standard normals that reflect above the horizon, for a (M, wo): M upright, wo.z > 0. Without branches, for loops over
/// many.
struct ReflectionCone {
    Vec3 axisNormal{0, 0, 1}; ///< M^-T e, the cone's axis in local space
    Vec3 disk{1, 0, 1};       ///< [x 0; y z]: unit disk to M^-T (b, 0)
    Vec2 along{0, 0};         ///< e.b as a linear form of the disk
    Vec2 tilt{0, 0};          ///< o.(b - (e.b) e) / o.e as a linear form of the disk
    float inverseAxis = 1;
    float pdfScale = 0;  ///< density over D
    bool usable = false; ///< within float's range

    [[gnu::always_inline]] static ReflectionCone of(const MicroTransform &m, const Vec3 &wo) {
        ReflectionCone cone;
        const float inverseZ = 1 / wo.z;
        const float skew = -m.b * m.inverseA * m.inverseD; // M^-1 = [1/a skew; 0 1/d]
        const float nXY = skew * m.inverseD;
        const float nYY = sqr(m.inverseD);
        const Vec2 tangent(wo.x * inverseZ, wo.y * inverseZ);
        const Vec2 t(m.inverseA * tangent.x + skew * tangent.y, m.inverseD * tangent.y);
        Invariants n;
        n.trace = sqr(m.inverseA) + sqr(skew) + nYY;
        n.det = sqr(m.inverseA * m.inverseD);
        const Vec2 adjoint = n.det * Vec2(m.a * tangent.x, m.b * tangent.x + m.d * tangent.y); // adj(N) t = det N M^T tau
        n.t2 = glm::dot(t, t);
        n.tangent2 = glm::dot(tangent, tangent);
        n.adjoint2 = glm::dot(adjoint, adjoint);

        const float axis = n.axisFromAbove();
        const float q = n.determinant(axis);
        const float inverseQ = 1 / q;
        const float inverseRootQ = std::sqrt(inverseQ);
        const float slope = 1 + n.square(axis) * inverseQ * inverseQ; // |e|^2 / e.z^2
        const float facing = 1 + n.form(axis) * inverseQ;             // o.e / (o.z e.z)
        const float inverseRoot = 1 / std::sqrt(axis + nYY);
        // Density over D, eq. (9): 1 / (4 L(wo) o.e A B), A B the product of the ellipse's half axes.
        cone.pdfScale = slope * q * inverseRootQ / (4 * wo.z * axis * facing);
        cone.usable = (cone.pdfScale > 0) & (cone.pdfScale < kInfinity) & (slope < kInfinity);

        // sqrt(axis) W, with W W^T = (axis + N)^-1 lower triangular, takes the unit disk to the ellipse, seen along z, eq. (7);
        // M^-T of it the same in local space, where what cancels has cancelled on paper.
        const float eZ = 1 / std::sqrt(slope);
        const float root = std::sqrt(axis);
        const float wXX = root * inverseRootQ * (axis + nYY) * inverseRoot;
        const float wYX = -root * inverseRootQ * nXY * inverseRoot;
        const float wYY = root * inverseRoot;
        cone.disk = Vec3(m.inverseA * wXX, skew * axis * root * inverseRootQ * inverseRoot, m.inverseD * wYY);
        const Vec2 e = eZ * inverseQ * (axis * t + adjoint);
        cone.along = Vec2(wXX * e.x + wYX * e.y, wYY * e.y);
        const float inverseFacing = 1 / (facing * eZ);
        cone.tilt = inverseFacing * Vec2(wXX * t.x + wYX * t.y, wYY * t.y) - cone.along;
        cone.inverseAxis = 1 / axis;
        // M^-T e.
        const float scale = eZ * inverseQ;
        const float across = axis * m.inverseA * t.x;
        cone.axisNormal =
            Vec3(scale * (n.det * tangent.x + across), scale * (n.det * tangent.y + axis * (skew * t.x + m.inverseD * t.y)), eZ);
        return cone;
    }

    /// A micro-normal (local space, not normalised) whose standard one, M^T wm, has the density o.m on the cone.
    [[nodiscard]] Vec3 normal(const Vec2 &u, float coin) const {
        const Vec2 p = std::sqrt(u.y) * unitCircle(u.x);
        // M^-T (b, 0) with b the point of the ellipse, seen along z; it lies at b - (e.b) e across the axis.
        const Vec2 point(disk.x * p.x, disk.y * p.x + disk.z * p.y);
        const float across = glm::dot(along, p); // e.b
        // e.m = sqrt(1 - |b|^2 + (e.b)^2), eq. (10), without cancellation.
        const float height = std::sqrt((1 - u.y) + glm::dot(point, point) * inverseAxis + across * across);
        // Where o.m is less than for the mirror image, that gets the difference, eq. (11).
        const bool isMirrored = coin * height < -glm::dot(tilt, p);
        const Vec2 b(isMirrored ? -point.x : point.x, isMirrored ? -point.y : point.y);
        const float rest = height - (isMirrored ? -across : across);
        return {b.x + rest * axisNormal.x, b.y + rest * axisNormal.y, rest * axisNormal.z};
    }

  private:
    /// K / o.z = [-N t; t^T 1] in the standard space of the triangular M, N the 2x2 block of M^-1 M^-T, by its invariants.
    struct Invariants {
        float trace;    ///< of N
        float det;      ///< of N
        float t2;       ///< |t|^2, t = o.xy / o.z
        float tangent2; ///< |tau|^2, tau = wo.xy / wo.z = M t
        float adjoint2; ///< |adj(N) t|^2

        /// det(x + N), t^T adj(x + N) t and |adj(x + N) t|^2: sums of terms of one sign.
        [[nodiscard]] float determinant(float x) const { return x * (x + trace) + det; }
        [[nodiscard]] float form(float x) const { return x * t2 + det * tangent2; }
        [[nodiscard]] float square(float x) const { return x * (x * t2 + 2 * det * tangent2) + adjoint2; }

        /// An upper bound, tight to 2e-3 (1e-6 on average), of the root of the secular equation x = 1 + t^T (x + N)^-1 t, eq. (5):
        /// K's positive eigenvalue over o.z. Replacing the right side by 1 + alpha / (x + beta) gives lower bounds: first with
        /// beta the mean of N that t sees, then touching at that. Newton's step on the cubic, convex there, ends above the root.
        [[nodiscard]] float axisFromAbove() const {
            const auto root = [](float alpha, float beta) {
                const float sum = 1 + beta;
                return 1 + 2 * alpha / (sum + std::sqrt(sum * sum + 4 * alpha));
            };
            float x = root(t2, std::max(0.0F, trace - det * tangent2 / std::max(1e-30F, t2)));
            const float ratio = form(x) / std::max(1e-36F, square(x));
            x = root(form(x) * ratio, std::max(0.0F, determinant(x) * ratio - x));
            const float q = determinant(x);
            x -= ((x - 1) * q - form(x)) / (q + (x - 1) * (2 * x + trace) - t2);
            return x + 4e-7F * x; // rounding must not turn it into a lower bound
        }
    };
};

/// Samples wi given wo; prepared once for a (M, wo). Local shading space, unit vectors, densities in solid angle.
///
/// Upright M and wo.z > 0: the share of samples below the horizon was under 0.2 % for every M and wo tried, about 1e-6 on average.
/// Elsewhere (a leaning M, wo below the horizon, values outside float's range) bounded or full spherical caps, or chords
/// (ggx::prefersChords).
class ReflectionSampler {
  public:
    /// Bounded caps are prepared sooner than the cone, which pays off where they reject more than `bearableWaste` of the samples seen
    /// from the normal (capWaste); 0: the cone wherever it can be had.
    ReflectionSampler(const MicroTransform &m, const Vec3 &wo, float bearableWaste = 0) : m_(m), wo_(wo) {
        if (prefersCone(m, wo, bearableWaste)) prepareCone();
        if (!cone_.usable) prepareCap();
    }

    /// Whether bounded caps reject more than `share` of the samples at wo = z. With a the smaller alpha or 1 they keep
    /// (1 + a^2) / sqrt((1 + alphaX^2) (1 + alphaY^2)) of them, eq. (8) over what the bound leaves; at other wo about as much.
    static bool capsWaste(const MicroTransform &m, float share) {
        const SlopeTensor<float> sigma = slopeTensor(m);
        const float all = sqr(1 - share) * (1 + sigma.xx + sigma.yy + sigma.determinant);
        return (all > 1) & (all > sqr(1 + std::min(sigma.smaller(), 1.0F)));
    }
    /// Whether a sampler made with this `bearableWaste` will try the cone.
    static bool prefersCone(const MicroTransform &m, const Vec3 &wo, float bearableWaste) {
        return canSampleCone(m, wo) & ((bearableWaste <= 0) | capsWaste(m, bearableWaste));
    }

    /// wi with density pdf(wi), or nothing where the sampled normal reflects below the horizon. u and coin are uniform in [0, 1).
    [[nodiscard]] std::optional<Vec3> sample(const Vec2 &u, float coin) const {
        const Vec3 wm = cone_.usable ? cone_.normal(u, coin) : ggx::spreadVisibleNormal(m_, wo_, u, capBound_);
        const Vec3 wi = (2 * glm::dot(wo_, wm) / glm::dot(wm, wm)) * wm - wo_;
        if (!(wi.z > 0)) return std::nullopt;
        return wi;
    }
    /// sample() for callers with two numbers: the coin is hashed from the bits of u.
    [[nodiscard]] std::optional<Vec3> sample(const Vec2 &u) const { return sample(u, coinFrom(u)); }

    /// Density of sample(): D(wm) times a constant; 0 for wi below the horizon.
    [[nodiscard]] float pdf(const Vec3 &wi) const { return wi.z > 0 ? ggx::distribution(m_, wo_, wi) * pdfScale() : 0.0F; }

    /// pdf(wi) / D(wm), the same for every wi: an evaluation that has D at hand needs no more.
    [[nodiscard]] float pdfScale() const { return cone_.usable ? cone_.pdfScale : capScale_; }
    /// Whether the cone is sampled; false where caps stand in for it.
    [[nodiscard]] bool samplesCone() const { return cone_.usable; }
    /// The share of all visible normals that reflect above the horizon, eq. (8), from above and within 0.2 % of itself: what the
    /// full cap keeps. Only where samplesCone().
    [[nodiscard]] float reflectedShare() const { return 1 / (2 * (wo_.z + ggx::stretchedLength(m_, wo_)) * cone_.pdfScale); }

  private:
    static bool canSampleCone(const MicroTransform &m, const Vec3 &wo) { return m.upright() & (wo.z > kLeastCosine); }

    /// Below this wo.z nothing is lost to the horizon that a float could tell.
    static constexpr float kLeastCosine = 1e-6F;

    [[gnu::noinline]] void prepareCone() { cone_ = ReflectionCone::of(m_, wo_); }

    void prepareCap() {
        capBound_ = ggx::reflectionBound(m_, wo_);
        const float length = ggx::stretchedLength(m_, wo_);
        capScale_ = 0.5F / ggx::capArea(capBound_, wo_.z, length, ggx::visibleArea(m_, wo_, length));
    }

    /// Uniform in [0, 1), unrelated to where u lies: a finaliser of 32 bits (MurmurHash3) over both numbers' bits.
    static float coinFrom(const Vec2 &u) {
        std::uint32_t x = std::bit_cast<std::uint32_t>(u.x) * 0x9e3779b1U + std::bit_cast<std::uint32_t>(u.y);
        x = (x ^ (x >> 16U)) * 0x85ebca6bU;
        x = (x ^ (x >> 13U)) * 0xc2b2ae35U;
        return static_cast<float>((x ^ (x >> 16U)) >> 8U) * 0x1p-24F;
    }

    MicroTransform m_;
    Vec3 wo_;
    ReflectionCone cone_;
    float capBound_ = 1;
    float capScale_ = 0;
};

} // namespace taut
