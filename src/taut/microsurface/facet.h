#pragma once
/// One facet: where its normal lies between two directions, where it sends light, and how that stretches solid angle
/// (Walter, Marschner, Li & Torrance 2007, sections 4.1, 4.2). eta = index beyond / index on wo's side.

#include "taut/base/vec.h"

namespace taut::facet {

/// The direction beyond the interface, or false at total internal reflection, where `wi` means nothing. `cosine` = <wo, wm> > 0, eta as
/// above.
[[gnu::always_inline]] inline bool refract(const Vec3 &wo, const Vec3 &wm, float cosine, float eta, Vec3 &wi) {
    const float inverse = 1 / eta;
    const float c2 = 1 - inverse * inverse * (1 - cosine * cosine);
    wi = glm::normalize(wm * (inverse * cosine - std::sqrt(c2 > 0 ? c2 : 0.0F)) - wo * inverse);
    return c2 > 0;
}

/// Normal of a facet that refracts wo to wi, towards wo, not normalised: the half vector of eq. 16 on the viewer's side.
inline Vec3 refractionHalf(const Vec3 &wo, const Vec3 &wi, float eta) {
    const float sign = eta > 1 ? -1.0F : 1.0F;
    return sign * (wo + eta * wi);
}

/// d wm / d wi of a refraction (eq. 17), from <wo, wm> > 0 and <wi, wm> < 0; 0 where no facet can do it.
inline float refractionJacobian(float cosO, float cosI, float eta) {
    const float denominator = sqr(cosO + eta * cosI);
    return cosO > 0 && cosI < 0 && denominator > 0 ? eta * eta * -cosI / denominator : 0.0F;
}

} // namespace taut::facet
