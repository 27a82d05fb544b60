#pragma once
/// A diffuse surface under a clear coat.

#include "taut/bsdf/layered.h"

namespace taut {

struct CoatedBsdf : Layered<CoatedBsdf> {
    static void make(const MaterialValues &material, Bsdf &bsdf) {
        bsdf.albedo = material.color;
        bsdf.diffuseEscape = material.coatEscape;
    }
    static DielectricInterface interface(const Bsdf &bsdf) { return {bsdf.eta}; }
};

} // namespace taut
