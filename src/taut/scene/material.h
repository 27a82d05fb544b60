#pragma once
/// A material as plain data: what a scene file or a .glb says of it, with every default filled in.

#include "taut/bsdf/bsdf_table.h"
#include "taut/bsdf/multiscatter_choice.h"

#include <string>

namespace taut {

/// A number or one channel of a texture times that number.
struct FloatParam {
    float value = 0;
    Index texture = kNone; ///< into Scene::textures
    int channel = 0;
};

/// A linear RGB colour or a texture times that colour.
struct ColorParam {
    Vec3 value{1};
    Index texture = kNone;
};

enum class Masking { Correlated, Separable };

/// alpha is GGX alpha (slope scale), never its square root. alphaX is along the tangent (dP/du), alphaY across.
struct Material {
    std::string name;
    BsdfType type = BsdfType::Diffuse;
    ColorParam color;     ///< diffuse and coated: albedo; conductor: F0; dielectric: transmission tint; metallic-roughness: base colour
    Vec3 conductorEta{1}; ///< metal: eta + i k
    Vec3 conductorK{0};
    FloatParam alphaX{0.1F};
    FloatParam alphaY{0.1F};
    bool alphaIsRoughness = false; ///< the parameters above are glTF roughness: alpha = (value * texture)^2
    FloatParam rotation;           ///< radians, counter-clockwise from the tangent
    float ior = 1.5F;              ///< all that read it (bsdf_table.h)
    FloatParam metallic;           ///< metallic-roughness only
    float anisotropyStrength = 0;  ///< KHR_materials_anisotropy: alpha along the direction = mix(alpha, 1, strength^2)
    Index anisotropyTexture = kNone;
    float poisson = 0; ///< [-1, 0.5]: lambda = det(A)^(-nu/(1-nu)); -1: the normal stretches as the surface does
    Masking masking = Masking::Correlated;
    Multiscatter multiscatter = Multiscatter::Auto;
};

/// What is done about light of a material that meets several facets, where a plan says `planned` for those that leave it open; Auto: by
/// the M of each hit. The model rests on correlated heights.
inline Multiscatter multiscatterOf(const Material &material, Multiscatter planned) {
    if (!bsdfInfo(material.type).manyFacets) return Multiscatter::Off;
    if (material.multiscatter != Multiscatter::Auto) return material.multiscatter;
    return material.masking == Masking::Correlated ? planned : Multiscatter::Off;
}

} // namespace taut
