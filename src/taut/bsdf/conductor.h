#pragma once
/// A conductor known by its colour: Schlick's reflectance.

#include "taut/bsdf/reflector.h"

namespace taut {

struct ConductorBsdf : Reflector<ConductorBsdf> {
    static void make(const MaterialValues &material, Bsdf &bsdf) { bsdf.f0 = material.color; }
    [[gnu::always_inline]] static SchlickInterface interface(const Bsdf &bsdf) { return {bsdf.f0}; }
};

} // namespace taut
