#pragma once
/// Published formulations of the same microsurface, each under its name: what the forms of ggx.h are checked and charted against.
/// Equal in exact arithmetic; each loses digits somewhere in float (docs/precision.md). Templates over the real type. Nothing
/// renders with them.
///
/// They share a shape, so that a loop can go over formulations: built from a transform, with D(wm), G1(w), reflectionPdf(wo, wi)
/// of visible normals and weight(wo, wi) = G2 / G1(wo), height-correlated. Unit directions, wo.z and wi.z > 0, upright M.

#include "taut/microsurface/ggx.h"

namespace taut::reference {

/// Walter et al. 2007 with (alphaX, alphaY, rotation), as textbooks write it: tan^2 over cos^4 for D (eq. 33), tan^2 under the root of G1
/// (eq. 34), with alpha^2 replaced by its anisotropic form (Burley 2012; Heitz 2014, eq. 85 and 80).
template <class T> class Walter {
  public:
    Walter(T alphaX, T alphaY, T rotation) : alphaX_(alphaX), alphaY_(alphaY), cosine_(std::cos(rotation)), sine_(std::sin(rotation)) {}
    explicit Walter(const BasicEquivalentAlpha<T> &alpha) : Walter(alpha.max, alpha.min, alpha.phi) {}

    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(glm::normalize(wo + wi)); }
    [[nodiscard]] T D(const Vector3<T> &wm) const {
        if (!(wm.z > 0)) return 0;
        const T cos2 = wm.z * wm.z;
        const T sin2 = std::fmax(T(0), 1 - cos2);
        const T tan2 = sin2 / cos2;
        const Vector2<T> c = azimuth(wm);
        const T e = tan2 * (sqr(c.x / alphaX_) + sqr(c.y / alphaY_));
        return 1 / (std::numbers::pi_v<T> * alphaX_ * alphaY_ * cos2 * cos2 * sqr(1 + e));
    }
    [[nodiscard]] T lambda(const Vector3<T> &w) const {
        const T cos2 = w.z * w.z;
        const T tan2 = std::fmax(T(0), 1 - cos2) / cos2;
        const Vector2<T> c = azimuth(w);
        return (std::sqrt(1 + tan2 * (sqr(c.x * alphaX_) + sqr(c.y * alphaY_))) - 1) / 2;
    }
    [[nodiscard]] T G1(const Vector3<T> &w) const { return 1 / (1 + lambda(w)); }
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const { return G1(wo) * D(wo, wi) / (4 * wo.z); }
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = lambda(wo);
        return (1 + o) / (1 + o + lambda(wi));
    }

  private:
    /// cos and sin of the azimuth against the rougher axis.
    [[nodiscard]] Vector2<T> azimuth(const Vector3<T> &w) const {
        const Vector2<T> turned(cosine_ * w.x + sine_ * w.y, cosine_ * w.y - sine_ * w.x);
        const T length = glm::length(turned);
        return length > 0 ? turned / length : Vector2<T>(1, 0);
    }
    T alphaX_, alphaY_, cosine_, sine_;
};

/// GGX as textbooks write it with (alphaX, alphaY): x^2/alphaX^2 + y^2/alphaY^2 + z^2 of the unit half vector (Heitz 2014, eq. 85), Lambda
/// from the same sum under a root; here with a rotation.
template <class T> class Textbook {
  public:
    explicit Textbook(const BasicEquivalentAlpha<T> &alpha)
        : alphaX_(alpha.max), alphaY_(alpha.min), cosine_(std::cos(alpha.phi)), sine_(std::sin(alpha.phi)) {}

    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(glm::normalize(wo + wi)); }
    [[nodiscard]] T D(const Vector3<T> &wm) const {
        if (!(wm.z > 0)) return 0;
        const Vector2<T> w = turned(wm);
        const T e = sqr(w.x / alphaX_) + sqr(w.y / alphaY_) + wm.z * wm.z;
        return 1 / (std::numbers::pi_v<T> * alphaX_ * alphaY_ * e * e);
    }
    [[nodiscard]] T lambda(const Vector3<T> &w) const {
        const Vector2<T> t = turned(w);
        return (std::sqrt(1 + (sqr(alphaX_ * t.x) + sqr(alphaY_ * t.y)) / (w.z * w.z)) - 1) / 2;
    }
    [[nodiscard]] T G1(const Vector3<T> &w) const { return 1 / (1 + lambda(w)); }
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const { return G1(wo) * D(wo, wi) / (4 * wo.z); }
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = lambda(wo);
        return (1 + o) / (1 + o + lambda(wi));
    }

  private:
    [[nodiscard]] Vector2<T> turned(const Vector3<T> &w) const { return {cosine_ * w.x + sine_ * w.y, cosine_ * w.y - sine_ * w.x}; }
    T alphaX_, alphaY_, cosine_, sine_;
};

/// The usual form of real-time shaders: cos^2 (alpha^2 - 1) + 1, the only angle used being cos; alpha taken at the azimuth.
template <class T> class CosineSquared {
  public:
    explicit CosineSquared(const BasicEquivalentAlpha<T> &alpha)
        : alphaX_(alpha.max), alphaY_(alpha.min), cosine_(std::cos(alpha.phi)), sine_(std::sin(alpha.phi)) {}

    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(glm::normalize(wo + wi)); }
    [[nodiscard]] T D(const Vector3<T> &wm) const {
        if (!(wm.z > 0)) return 0;
        const Vector2<T> c = azimuthSquared(wm);
        const T alpha2 = 1 / (c.x / sqr(alphaX_) + c.y / sqr(alphaY_));
        const T base = wm.z * wm.z * (alpha2 - 1) + 1;
        return alpha2 * alpha2 / (std::numbers::pi_v<T> * alphaX_ * alphaY_ * base * base);
    }
    [[nodiscard]] T G1(const Vector3<T> &w) const { return 2 * w.z / (w.z + root(w)); }
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const { return G1(wo) * D(wo, wi) / (4 * wo.z); }
    /// V2 / V1, Heitz 2014's correlated form as shaders have it.
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = root(wo);
        return wi.z * (wo.z + o) / (wo.z * root(wi) + wi.z * o);
    }

  private:
    [[nodiscard]] Vector2<T> azimuthSquared(const Vector3<T> &w) const {
        const T x = sqr(cosine_ * w.x + sine_ * w.y);
        const T y = sqr(cosine_ * w.y - sine_ * w.x);
        return x + y > 0 ? Vector2<T>(x, y) / (x + y) : Vector2<T>(1, 0);
    }
    /// sqrt(alpha^2 + (1 - alpha^2) cos^2).
    [[nodiscard]] T root(const Vector3<T> &w) const {
        const Vector2<T> c = azimuthSquared(w);
        const T alpha2 = c.x * sqr(alphaX_) + c.y * sqr(alphaY_);
        return std::sqrt(alpha2 + (1 - alpha2) * w.z * w.z);
    }
    T alphaX_, alphaY_, cosine_, sine_;
};

/// The talk's chain: 1/pi times Jacobians of projection, stretch and reflection (CEDEC 2023, after "Microsurface Transformations"),
/// and the standard masking of M^-1 w.
template <class T> class JacobianChain {
  public:
    explicit JacobianChain(const BasicMicroTransform<T> &m) : m_(m) {}

    /// d disk / d wStd.
    [[nodiscard]] static T projectionJacobian(const Vector3<T> &wStd) { return wStd.z; }
    /// d wStd / d wm = |det M| <wStd, n>^3 / <wm, n>^3.
    [[nodiscard]] T stretchJacobian(const Vector3<T> &wStd, const Vector3<T> &wm) const {
        const T ratio = wStd.z / wm.z;
        return m_.det * ratio * ratio * ratio;
    }
    /// d wm / d wi.
    [[nodiscard]] static T reflectionJacobian(const Vector3<T> &wm, const Vector3<T> &wi) { return 1 / (4 * std::fabs(glm::dot(wm, wi))); }
    [[nodiscard]] static T refractionJacobian(const Vector3<T> &wo, const Vector3<T> &wm, const Vector3<T> &wi, T eta) {
        const T i = glm::dot(wm, wi);
        return eta * eta * std::fabs(i) / sqr(glm::dot(wm, wo) + eta * i);
    }

    /// Density of all micro-normals, D(wm) <wm, n>: the first two Jacobians.
    [[nodiscard]] T normalPdf(const Vector3<T> &wm) const {
        if (!(wm.z > 0)) return 0;
        const Vector3<T> wStd = glm::normalize(m_.transposed(wm));
        return std::numbers::inv_pi_v<T> * projectionJacobian(wStd) * stretchJacobian(wStd, wm);
    }
    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(glm::normalize(wo + wi)); }
    [[nodiscard]] T D(const Vector3<T> &wm) const { return wm.z > 0 ? normalPdf(wm) / wm.z : T(0); }
    [[nodiscard]] T G1(const Vector3<T> &w) const {
        const T c = glm::normalize(m_.inverse(w)).z;
        return 2 * std::fabs(c) / (1 + c);
    }
    /// Visible normals: G1(wo) <wo, wm> D(wm) / wo.z and the reflection's Jacobian.
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const Vector3<T> wm = glm::normalize(wo + wi);
        return G1(wo) * glm::dot(wo, wm) * D(wm) / std::fabs(wo.z) * reflectionJacobian(wm, wi);
    }
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = 1 / G1(wo);
        return o / (o + 1 / G1(wi) - 1);
    }

  private:
    BasicMicroTransform<T> m_;
};

/// M kept as the tensor S = M M^T alone (three numbers): D from wm^T S wm, lengths from its inverse.
template <class T> class Tensor {
  public:
    explicit Tensor(const BasicMicroTransform<T> &m) : xx_(m.a * m.a + m.b * m.b), xy_(m.b * m.d), yy_(m.d * m.d) {}

    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(glm::normalize(wo + wi)); }
    [[nodiscard]] T D(const Vector3<T> &wm) const {
        if (!(wm.z > 0)) return 0;
        const T square = xx_ * wm.x * wm.x + 2 * xy_ * wm.x * wm.y + yy_ * wm.y * wm.y + wm.z * wm.z;
        return std::sqrt(det()) / (std::numbers::pi_v<T> * square * square);
    }
    [[nodiscard]] T G1(const Vector3<T> &w) const { return 2 * w.z / (w.z + length(w)); }
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const { return D(wo, wi) / (2 * (wo.z + length(wo))); }
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = length(wo);
        return wi.z * (wo.z + o) / (wo.z * length(wi) + wi.z * o);
    }

  private:
    [[nodiscard]] T det() const { return xx_ * yy_ - xy_ * xy_; }
    [[nodiscard]] T length(const Vector3<T> &w) const {
        return std::sqrt((yy_ * w.x * w.x - 2 * xy_ * w.x * w.y + xx_ * w.y * w.y) / det() + w.z * w.z);
    }
    T xx_, xy_, yy_;
};

/// The forms of ggx.h in the same shape: what renders.
template <class T> class Stable {
  public:
    explicit Stable(const BasicMicroTransform<T> &m) : m_(m) {}

    [[nodiscard]] T G1(const Vector3<T> &w) const { return ggx::masking(m_, w); }
    [[nodiscard]] T D(const Vector3<T> &wo, const Vector3<T> &wi) const { return ggx::distribution(m_, wo, wi); }
    [[nodiscard]] T reflectionPdf(const Vector3<T> &wo, const Vector3<T> &wi) const {
        return D(wo, wi) / (2 * ggx::visibleArea(m_, wo, ggx::stretchedLength(m_, wo)));
    }
    [[nodiscard]] T weight(const Vector3<T> &wo, const Vector3<T> &wi) const {
        const T o = ggx::stretchedLength(m_, wo);
        return 2 * wi.z * ggx::visibility(wo.z, o, wi.z, ggx::stretchedLength(m_, wi), true) * ggx::visibleArea(m_, wo, o);
    }

  private:
    BasicMicroTransform<T> m_;
};

} // namespace taut::reference
