#pragma once
/// A conductor known by its complex index of refraction.

#include "taut/bsdf/reflector.h"

namespace taut {

struct MetalBsdf : Reflector<MetalBsdf> {
    static void make(const MaterialValues &material, Bsdf &bsdf) {
        bsdf.conductorEta = material.conductorEta;
        bsdf.conductorK = material.conductorK;
    }
    [[gnu::always_inline]] static ConductorInterface interface(const Bsdf &bsdf) { return {bsdf.conductorEta, bsdf.conductorK}; }
};

} // namespace taut
