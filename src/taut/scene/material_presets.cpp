#include "taut/scene/material_presets.h"

#include "taut/bsdf/metals.h"

#include <array>

namespace taut {

namespace {

Material coated(const Vec3 &color, float ior, float alpha) {
    Material m;
    m.type = BsdfType::Coated;
    m.color.value = color;
    m.ior = ior;
    m.alphaX.value = m.alphaY.value = alpha;
    m.poisson = 0.5F; // both keep their volume: Treloar 1975, "The Physics of Rubber Elasticity"; Fung 1993, "Biomechanics", for skin
    return m;
}

Material aluminium(float alphaX, float alphaY) {
    Material m;
    m.type = BsdfType::Metal;
    for (const Metal &metal : metals()) {
        if (metal.name != "Al") continue;
        m.conductorEta = metal.eta;
        m.conductorK = metal.k;
    }
    m.alphaX.value = alphaX;
    m.alphaY.value = alphaY;
    m.poisson = 0.5F; // plastic flow keeps the volume
    return m;
}

/// Alpha per strain of aluminium that was annealed. Roughness grows linearly with strain and grain size (Stoudt & Ricker 2002, Metall.
/// Mater. Trans. A 33, 2883), in other ways for other modes of strain (Stoudt, Hubbard, Iadicola & Banovic 2009, ibid. 40, 1611): a tenth
/// of a grain per unit of strain, on waves of two grains, is a slope of 0.4 RMS in all. The tenth is an order of magnitude; alloys differ
/// by factors.
constexpr float kAluminiumRoughening = 0.4F;

std::array<MaterialPreset, 4> makePresets() {
    // Natural rubber, n = 1.519: Wood & Tilton 1949, J. Res. NBS 43, 57. Colour and alpha are a choice.
    const Material rubber = coated(Vec3(0.03F), 1.519F, 0.22F);
    // Skin: n = 1.4 and roughness as in Weyrich et al. 2006, "Analysis of Human Faces Using a Measurement-Based Skin Reflectance Model";
    // that it follows geometry, stretched shinier and compressed rougher: Nagano et al. 2015, "Skin Microstructure Deformation".
    const Material skin = coated(Vec3(0.62F, 0.36F, 0.26F), 1.4F, 0.3F);
    // Household foil is soft annealed; rolled, it is rougher across. Its alphas are a choice.
    Material foil = aluminium(0.06F, 0.14F);
    foil.roughening = kAluminiumRoughening;
    foil.yield = 0.002F; // the offset by which a yield strength is defined (ISO 6892-1)
    // Stoudt and Hubbard at NIST saw aluminium roughen from 1 % of strain to 12.
    Material annealed = aluminium(0.1F, 0.1F);
    annealed.roughening = kAluminiumRoughening;
    annealed.yield = 0.01F;
    return {{{"rubber", rubber}, {"skin", skin}, {"foil", foil}, {"annealed aluminium", annealed}}};
}

} // namespace

std::span<const MaterialPreset> materialPresets() {
    static const std::array<MaterialPreset, 4> presets = makePresets();
    return presets;
}

} // namespace taut
