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

/// Slopes between the mesh and the microsurface, in the frame of its tangents (x along dP/du): a normal map, or heights.
struct SlopeMap {
    enum class Kind : std::uint8_t {
        Normal, ///< tangent-space normals as glTF stores them, y up: 2 texel - 1
        Bump,   ///< heights in widths of the image, whose texels are square on the surface; the texture holds slopes (slope_texture.h)
        Height, ///< heights in metres at rest; likewise, per unit of u and v
    };
    Kind kind = Kind::Normal;
    Index texture = kNone; ///< kNone: the mesh's own normals
    float scale = 1;       ///< of the slopes
    [[nodiscard]] bool isGiven() const { return texture != kNone; }
};

/// How a material's textures are looked up. Map: at the point. Moments: over what a pixel sees, slopes by their mean and covariance
/// (microsurface/mesostructure.h). Auto: a plan's choice for maps of slopes, the map where nobody plans.
enum class TextureDetail : std::uint8_t { Map, Moments, Auto };

/// What a mapped facet does under a deformation. Leans: its micro-geometry is carried along (microsurface/mesostructure.h). Bends: what
/// most renderers do, for comparison: its normal turns, and the gloss is that of the mesh.
enum class FacetModel { Leans, Bends };

/// What becomes of opacity (glTF's alphaMode). Mask: below Material::alphaCutoff there is no surface, above it there is all of it. Blend:
/// that share of the light meets the surface, the rest goes on as if there were none.
enum class AlphaMode { Opaque, Mask, Blend };

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
    SlopeMap slopes;     ///< of all kinds
    SlopeMap coatSlopes; ///< metallic-roughness: of the clear coat, which follows no other
    FacetModel facets = FacetModel::Leans;
    TextureDetail detail = TextureDetail::Auto;
    float roughening = 0; ///< alpha per unit of equivalent strain beyond `yield` (microsurface/roughening.h)
    float yield = 0;      ///< strain

    FloatParam opacity{1}; ///< share of the surface that is there (glTF: alpha of the base colour, channel 3 of its texture)
    AlphaMode alphaMode = AlphaMode::Opaque;
    float alphaCutoff = 0.5F;  ///< with AlphaMode::Mask
    bool doubleSided = true;   ///< false: back faces are not there, for any ray
    bool vertexColors = false; ///< colour and opacity are multiplied by the mesh's own colours
    bool unlit = false;        ///< the colour is what is seen, under any light (KHR_materials_unlit)

    // Metallic-roughness only, each named by the extension of glTF 2.0 that defines it.
    FloatParam specular{1};                ///< KHR_materials_specular: scales F0 and F90 of the dielectric part
    ColorParam specularColor;              ///< F0 times this, held at 1
    FloatParam transmission{0};            ///< KHR_materials_transmission: share of the diffuse part that goes through instead
    bool thinWalled = true;                ///< false: what goes through is refracted into a volume (KHR_materials_volume)
    Vec3 attenuationColor{1};              ///< what is left of white light after attenuationDistance inside that volume
    float attenuationDistance = kInfinity; ///< in scene units
    FloatParam clearcoat{0};               ///< KHR_materials_clearcoat: share of a coat of index 1.5 on top
    FloatParam clearcoatRoughness{0};      ///< its glTF roughness
    ColorParam sheenColor{Vec3(0)};        ///< KHR_materials_sheen: of the fibres on top; black: none
    FloatParam sheenRoughness{0};          ///< their glTF roughness
    FloatParam iridescence{0};             ///< KHR_materials_iridescence: share of the reflection that a thin film colours
    float iridescenceIor = 1.3F;           ///< of the film
    float iridescenceMin = 100;            ///< nanometres, the film's thickness where `thickness` is 0
    float iridescenceMax = 400;            ///< and where it is 1
    FloatParam thickness{1};               ///< of the film, from min to max; a file without its texture means the maximum
};

/// use(index of a texture) for those of a material's colours and numbers, not its slopes.
template <class Use> void forEachTexture(const Material &material, const Use &use) {
    const auto ask = [&](const auto &...params) { ((params.texture != kNone ? use(params.texture) : void()), ...); };
    ask(material.color, material.alphaX, material.alphaY, material.rotation, material.metallic, material.opacity, material.specular,
        material.specularColor, material.transmission, material.clearcoat, material.clearcoatRoughness, material.sheenColor,
        material.sheenRoughness, material.iridescence, material.thickness);
}

/// Whether rays may pass the surface as if there were none.
inline bool mayBeAbsent(const Material &material) {
    return material.alphaMode != AlphaMode::Opaque || !material.doubleSided;
}

/// What is done about light of a material that meets several facets, where a plan says `planned` for those that leave it open; Auto: by
/// the M of each hit. The model rests on correlated heights.
inline Multiscatter multiscatterOf(const Material &material, Multiscatter planned) {
    const BsdfInfo &info = bsdfInfo(material.type);
    if (!info.manyFacets) return Multiscatter::Off;
    if (material.multiscatter != Multiscatter::Auto) return material.multiscatter;
    // What a dielectric's reflections lose to each other is a share of 4 %.
    if (info.reads(kMetallicKey) && material.metallic.value == 0) return Multiscatter::Off;
    return material.masking == Masking::Correlated ? planned : Multiscatter::Off;
}

} // namespace taut
