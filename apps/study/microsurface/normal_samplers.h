#pragma once
/// The published ways to sample micro-normals of GGX, for every M, each beside its density. Rendering uses caps (ggx.h) and
/// ReflectionSampler; these are here to be compared and to be taken from.
///
///     DiskNormals         all normals, D cos, by the concentric disk (the talk; Walter et al. 2007)
///     HalfDiskNormals     visible normals by a disk projected along the view (Heitz 2018, JCGT 7(4))
///     ChordNormals        the same by chords of that disk, the strata of slopes of Heitz & d'Eon 2014 (ggx.h)
///     CapNormals          visible normals by a spherical cap (Dupuy & Benyoub 2023)
///     BoundedCapNormals   visible normals without most of those that reflect below the horizon (Eto & Tokuyoshi 2023), skewed M too
///
/// All were published for (alphaX, alphaY); they work in standard space, which M^-1 and M^-T lead to and from for any M. Those
/// of visible normals take a wo below the horizon as Tokuyoshi 2021 does: the visible area is wo.z + L(wo), whatever wo.z's sign.
///
/// Each has the shape
///     Sampler(const MicroTransform &m, const Vec3 &wo)         unit wo
///     Vec3 sample(const Vec2 &u) const                         wm, unit; u uniform in [0, 1)^2
///     float pdf(const Vec3 &h) const                           density of wm = h/|h| in solid angle, h of any length
/// and Reflected<Sampler>, Refracted<Sampler> turn it into one of directions wi.

#include "taut/base/warp.h"
#include "taut/microsurface/facet.h"
#include "taut/microsurface/reflection_sampler.h"

namespace taut {

/// Density (M^T wm).z D(wm): the cosine against the macro-normal where M is upright, against the lean where it is not.
class DiskNormals {
  public:
    static constexpr bool kRefracts = true;
    DiskNormals(const MicroTransform &m, const Vec3 & /*wo*/) : m_(m) {}

    [[nodiscard]] Vec3 sample(const Vec2 &u) const { return glm::normalize(m_.inverseTransposed(squareToCosineHemisphere(u))); }
    [[nodiscard]] float pdf(const Vec3 &h) const { return std::fmax(0.0F, m_.transposed(h).z) / glm::length(h) * ggx::distribution(m_, h); }

  private:
    MicroTransform m_;
};

/// What samplers of all visible normals share: their density.
class VisibleNormals {
  public:
    static constexpr bool kRefracts = true;
    VisibleNormals(const MicroTransform &m, const Vec3 &wo) : m_(m), wo_(wo) {}
    [[nodiscard]] float pdf(const Vec3 &h) const { return ggx::visibleNormalPdf(m_, wo_, h); }

  protected:
    MicroTransform m_;
    Vec3 wo_;
};

class HalfDiskNormals : public VisibleNormals {
  public:
    HalfDiskNormals(const MicroTransform &m, const Vec3 &wo) : VisibleNormals(m, wo), o_(glm::normalize(m.inverse(wo))) {
        const float xy2 = o_.x * o_.x + o_.y * o_.y;
        share_ = 0.5F * (o_.z < 0 ? xy2 / (1 - o_.z) : 1 + o_.z);
        t1_ = xy2 > 0 ? Vec3(-o_.y, o_.x, 0) / std::sqrt(xy2) : Vec3(1, 0, 0);
        t2_ = glm::cross(o_, t1_);
    }

    [[nodiscard]] Vec3 sample(const Vec2 &u) const {
        const float r = std::sqrt(u.x);
        const float phi = 2 * kPi * u.y;
        const float x = r * std::cos(phi);
        const float q = std::sqrt(1 - x * x);
        // Heitz 2018, section 3.2: y = (1 - s) q + s r sin(phi), height sqrt(q^2 - y^2); written by the gap q - y, which a view
        // from below makes small.
        const float gap = share_ * (q - r * std::sin(phi));
        const Vec3 normal = x * t1_ + (q - gap) * t2_ + std::sqrt(std::fmax(0.0F, gap * (2 * q - gap))) * o_;
        return glm::normalize(m_.inverseTransposed(normal));
    }

  private:
    Vec3 o_; ///< woStd
    Vec3 t1_, t2_;
    float share_; ///< of the disk's half axis: (1 + woStd.z) / 2
};

class ChordNormals : public VisibleNormals {
  public:
    using VisibleNormals::VisibleNormals;
    [[nodiscard]] Vec3 sample(const Vec2 &u) const { return glm::normalize(m_.inverseTransposed(ggx::sampleChord(m_, wo_, u))); }
};

class CapNormals : public VisibleNormals {
  public:
    using VisibleNormals::VisibleNormals;
    [[nodiscard]] Vec3 sample(const Vec2 &u) const { return ggx::sampleVisibleNormal(m_, wo_, u); }
};

/// The bound on the cap is from the least roughness of any direction, min(1, 1 / sigma_max), which is Eto & Tokuyoshi's
/// min(alphaX, alphaY, 1) where M is not skewed; the whole cap for leaning M and views from below. Leaves out normals that refract.
class BoundedCapNormals {
  public:
    static constexpr bool kRefracts = false;
    BoundedCapNormals(const MicroTransform &m, const Vec3 &wo)
        : m_(m), wo_(wo), o_(glm::normalize(m.inverse(wo))), bound_(ggx::capBound(m, wo)) {
        const float length = ggx::stretchedLength(m, wo);
        area_ = ggx::capArea(bound_, wo.z, length, ggx::visibleArea(m, wo, length));
    }

    [[nodiscard]] Vec3 sample(const Vec2 &u) const { return ggx::sampleVisibleNormal(m_, wo_, u, bound_); }
    [[nodiscard]] float pdf(const Vec3 &h) const {
        const float cosine = glm::dot(wo_, h) / glm::length(h);
        if (!(cosine > 0)) return 0;
        const Vec3 s = m_.transposed(h);
        // The point of the cap is woStd reflected by the standard normal; an edge that rounds outwards keeps what was sampled.
        const float height = 2 * glm::dot(o_, s) * s.z / glm::dot(s, s) - o_.z;
        if (height < -bound_ * o_.z - 1e-6F) return 0;
        return 2 * cosine * ggx::distribution(m_, h) / area_;
    }

  private:
    MicroTransform m_;
    Vec3 wo_, o_;
    float bound_, area_;
};

/// Directions wi above the horizon by reflection on a sampled normal; the same shape as ReflectionSampler.
template <class Normals> class Reflected {
  public:
    Reflected(const MicroTransform &m, const Vec3 &wo) : wo_(wo), normals_(m, wo) {}

    /// Nothing where the normal faces away or reflects below the horizon.
    [[nodiscard]] std::optional<Vec3> sample(const Vec2 &u) const {
        const Vec3 wm = normals_.sample(u);
        const float cosine = glm::dot(wo_, wm);
        if (!(cosine > 0)) return std::nullopt;
        const Vec3 wi = glm::normalize(2 * cosine * wm - wo_);
        if (!(wi.z > 0)) return std::nullopt;
        return wi;
    }
    /// pdf(wm) / (4 <wo, wm>), and |wo + wi| = 2 <wo, wm>.
    [[nodiscard]] float pdf(const Vec3 &wi) const {
        const Vec3 h = wo_ + wi;
        const float length = glm::length(h);
        return wi.z > 0 && length > 0 ? normals_.pdf(h) / (2 * length) : 0.0F;
    }

  private:
    Vec3 wo_;
    Normals normals_;
};

/// Directions wi below the horizon by refraction; eta = index beyond / index on wo's side, not 1.
template <class Normals> class Refracted {
    static_assert(Normals::kRefracts);

  public:
    Refracted(const MicroTransform &m, const Vec3 &wo, float eta) : wo_(wo), eta_(eta), normals_(m, wo) {}

    /// Nothing where the normal faces away, reflects totally or refracts to above the horizon.
    [[nodiscard]] std::optional<Vec3> sample(const Vec2 &u) const {
        const Vec3 wm = normals_.sample(u);
        const float cosine = glm::dot(wo_, wm);
        Vec3 wi;
        if (!(cosine > 0) || !facet::refract(wo_, wm, cosine, eta_, wi) || !(wi.z < 0)) return std::nullopt;
        return wi;
    }
    [[nodiscard]] float pdf(const Vec3 &wi) const {
        if (!(wi.z < 0)) return 0;
        const Vec3 h = facet::refractionHalf(wo_, wi, eta_);
        const float length = glm::length(h);
        if (!(length > 0)) return 0;
        const float jacobian = facet::refractionJacobian(glm::dot(wo_, h) / length, glm::dot(wi, h) / length, eta_);
        return jacobian > 0 ? normals_.pdf(h) * jacobian : 0.0F;
    }

  private:
    Vec3 wo_;
    float eta_;
    Normals normals_;
};

/// A type as a value, for the loops below.
template <class T> struct Sampler { using Type = T; };
/// Calls f(name, Sampler<S>()) for every sampler S(m, wo) of reflected directions.
template <class F> void forEachReflectionSampler(const F &f) {
    f("all normals, concentric disk", Sampler<Reflected<DiskNormals>>());
    f("visible normals, Heitz 2018", Sampler<Reflected<HalfDiskNormals>>());
    f("visible normals, chords", Sampler<Reflected<ChordNormals>>());
    f("spherical caps", Sampler<Reflected<CapNormals>>());
    f("bounded caps", Sampler<Reflected<BoundedCapNormals>>());
    f("reflection sampler", Sampler<ReflectionSampler>());
}
/// Calls f(name, Sampler<S>()) for every sampler S(m, wo, eta) of refracted directions.
template <class F> void forEachRefractionSampler(const F &f) {
    f("all normals, concentric disk", Sampler<Refracted<DiskNormals>>());
    f("visible normals, Heitz 2018", Sampler<Refracted<HalfDiskNormals>>());
    f("visible normals, chords", Sampler<Refracted<ChordNormals>>());
    f("spherical caps", Sampler<Refracted<CapNormals>>());
}

} // namespace taut
