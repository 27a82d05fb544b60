#pragma once
/// glTF's metallic-roughness material: Schlick's reflectance over a diffuse part that metal has none of (glTF 2.0, appendix B).

#include "taut/bsdf/layered.h"

namespace taut {

struct MetallicRoughnessBsdf : Layered<MetallicRoughnessBsdf> {
    static void make(const MaterialValues &material, Bsdf &bsdf) {
        const float metallic = glm::clamp(material.metallic, 0.0F, 1.0F);
        bsdf.albedo = material.color * (1 - metallic);
        bsdf.f0 = glm::mix(Vec3(sqr((material.ior - 1) / (material.ior + 1))), material.color, metallic);
        bsdf.diffuseEscape = material.coatEscape;
    }
    static SchlickInterface interface(const Bsdf &bsdf) { return {bsdf.f0}; }
};

} // namespace taut
