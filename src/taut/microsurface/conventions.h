#pragma once
/// The gloss of a transformed microsurface in the parameters of other renderers, there and back.
///
/// D depends on M only through M M^T, so (alphaMax, alphaMin, phi) of equivalentAlpha() says all of an upright one, and every
/// renderer with an anisotropic GGX can show it. With q = alphaMin / alphaMax and g = sqrt(alphaMax alphaMin):
///
///   target               roughness                                anisotropy                      rotation    limits
///   alpha (Mitsuba,      alphaMax                                 alphaMin                        tangent     none
///     pbrt)
///   blender (Principled) sqrt(g)                                  (1 - q) / 0.9                   phi / 2 pi  alphaMax <= 1, q >= 0.1
///   blender_anisotropic  sqrt(g)                                  sqrt(q) - 1                     phi / 2 pi  alphaMax <= 1, q >= 1e-4
///   openpbr              ((alphaMax^2 + alphaMin^2) / 2)^(1/4)    1 - q                           tangent     roughness <= 1
///   materialx            sqrt(g)                                  1 - q                           phi         alphaMax <= 1, q >= 0.02
///   khr                  sqrt(alphaMin)                           sqrt((alphaMax - alphaMin) /    phi         alphaMax <= 1
///                                                                      (1 - alphaMin))
///
/// phi turns the tangent towards cross(normal, tangent), radians; in Blender as a share of a full turn, in [0, 1/2). Targets
/// whose rotation is "tangent" have no rotation input: their tangent is the direction of the rougher axis, phi from ours.
/// Sources: Blender, Cycles' svm_closure (Principled: aspect = sqrt(1 - 0.9 a); Anisotropic: a < 0 is alpha / (1 + a) along the
/// tangent, the sign opposite to Principled's); OpenPBR 1.1, "Microfacet model"; MaterialX, roughness_anisotropy; glTF,
/// KHR_materials_anisotropy (mix(alpha, 1, strength^2) along the direction); pbrt-v4 with "remaproughness" false.
///
/// What lies outside a target's limits is clipped: alphaMax to its largest value, then alphaMin to the least that the target's
/// anisotropy reaches from there. Callers count ConventionValues::clipped.

#include "taut/microsurface/transform.h"

#include <array>
#include <string_view>

namespace taut {

enum class Convention { Alpha, Blender, BlenderAnisotropic, OpenPbr, MaterialX, Khr };

struct ConventionInfo {
    Convention convention;
    std::string_view name;       ///< of the convention, as on the command line
    std::string_view roughness;  ///< names of its parameters; they follow the name and an underscore in a file
    std::string_view anisotropy; ///< alpha: alphaMin
    std::string_view rotation;   ///< empty: the tangent is the rougher axis
    float largestAlpha;          ///< kInfinity: none
    float leastRatio;            ///< of alphaMin to alphaMax
};

inline constexpr std::array<ConventionInfo, 6> kConventions{{
    {Convention::Alpha, "alpha", "u", "v", "", kInfinity, 0.0F},
    {Convention::Blender, "blender", "roughness", "anisotropic", "rotation", 1.0F, 0.1F},
    {Convention::BlenderAnisotropic, "blender_anisotropic", "roughness", "anisotropy", "rotation", 1.0F, 1e-4F},
    {Convention::OpenPbr, "openpbr", "roughness", "anisotropy", "", kInfinity, 0.0F},
    {Convention::MaterialX, "materialx", "roughness", "anisotropy", "rotation", 1.0F, 0.02F},
    {Convention::Khr, "khr", "roughness", "strength", "rotation", 1.0F, 0.0F},
}};

inline const ConventionInfo &conventionInfo(Convention convention) {
    return kConventions[static_cast<std::size_t>(convention)];
}

/// What a target is given. The meaning of each is in the table above.
struct ConventionValues {
    float roughness = 0, anisotropy = 0, rotation = 0;
    bool clipped = false; ///< the gloss lay outside the target's limits
};

namespace detail {

/// Values this little outside a limit are rounding, not clipping.
inline constexpr double kLimitSlack = 1e-6;

/// Clips to a target's limits; true where that changed something.
inline bool clipAlpha(const ConventionInfo &info, double &max, double &min) {
    bool clipped = false;
    if (info.convention == Convention::OpenPbr) { // roughness <= 1, and with it alphaMax^2 + alphaMin^2 <= 2
        const double size = std::sqrt(0.5 * (max * max + min * min));
        if (size > 1) {
            clipped = size > 1 + kLimitSlack;
            max /= size;
            min /= size;
        }
        return clipped;
    }
    if (max > static_cast<double>(info.largestAlpha)) {
        clipped = max > static_cast<double>(info.largestAlpha) * (1 + kLimitSlack);
        max = static_cast<double>(info.largestAlpha);
        min = std::fmin(min, max);
    }
    const double least = static_cast<double>(info.leastRatio) * max;
    if (min < least) {
        clipped = clipped || min < least * (1 - kLimitSlack);
        min = least;
    }
    return clipped;
}

} // namespace detail

/// In double: 1 - q and its likes lose digits, and must not lose more than the float that they end in.
inline ConventionValues toConvention(Convention convention, const EquivalentAlpha &alpha) {
    double max = static_cast<double>(alpha.max);
    double min = std::fmin(static_cast<double>(alpha.min), max); // isotropic ones may differ by a rounding
    ConventionValues out;
    out.clipped = detail::clipAlpha(conventionInfo(convention), max, min);
    const double q = max > 0 ? min / max : 1;
    const double rootOfG = std::sqrt(std::sqrt(max * min));
    const auto set = [&](double roughness, double anisotropy, double rotation) {
        out.roughness = static_cast<float>(roughness);
        out.anisotropy = static_cast<float>(anisotropy);
        out.rotation = static_cast<float>(rotation);
    };
    const double phi = static_cast<double>(alpha.phi);
    const double turn = phi / kTwoPi;
    const double blenderTurn = turn < 0 ? turn + 0.5 : turn; // period 1/2: 0 <= rotation, as Blender's sockets show it
    switch (convention) {
    case Convention::Alpha: set(max, min, 0); break;
    case Convention::Blender: set(rootOfG, (1 - q) / 0.9, blenderTurn); break;
    case Convention::BlenderAnisotropic: set(rootOfG, std::sqrt(q) - 1, blenderTurn); break;
    case Convention::OpenPbr: set(std::sqrt(std::sqrt(0.5 * (max * max + min * min))), 1 - q, 0); break;
    case Convention::MaterialX: set(rootOfG, 1 - q, phi); break;
    case Convention::Khr: set(std::sqrt(min), min < 1 ? std::sqrt((max - min) / (1 - min)) : 0, phi); break;
    }
    return out;
}

/// The inverse: what the target renders for `values`. phi is in (-pi/2, pi/2]; 0 where the convention has no rotation.
inline EquivalentAlpha fromConvention(Convention convention, const ConventionValues &values) {
    const double r = static_cast<double>(values.roughness);
    const double a = static_cast<double>(values.anisotropy);
    double phi = static_cast<double>(values.rotation);
    double x = 0; // alpha along the turned tangent
    double y = 0;
    switch (convention) {
    case Convention::Alpha:
        x = r;
        y = a;
        phi = 0;
        break;
    case Convention::Blender: {
        const double aspect = std::sqrt(1 - 0.9 * a);
        x = r * r / aspect;
        y = r * r * aspect;
        phi *= kTwoPi;
        break;
    }
    case Convention::BlenderAnisotropic:
        x = a < 0 ? r * r / (1 + a) : r * r * (1 - a);
        y = a < 0 ? r * r * (1 + a) : r * r / (1 - a);
        phi *= kTwoPi;
        break;
    case Convention::OpenPbr:
        x = r * r * std::sqrt(2 / (1 + (1 - a) * (1 - a)));
        y = (1 - a) * x;
        phi = 0;
        break;
    case Convention::MaterialX: {
        const double aspect = std::sqrt(1 - a);
        x = r * r / aspect;
        y = r * r * aspect;
        break;
    }
    case Convention::Khr:
        y = r * r;
        x = y + (1 - y) * a * a;
        break;
    }
    constexpr double kHalfTurn = kTwoPi / 2;
    if (x < y) phi += 0.5 * kHalfTurn;
    phi -= kHalfTurn * std::floor(phi / kHalfTurn); // [0, pi)
    if (phi > 0.5 * kHalfTurn) phi -= kHalfTurn;
    return {static_cast<float>(std::fmax(x, y)), static_cast<float>(std::fmin(x, y)), static_cast<float>(phi)};
}

} // namespace taut
