#pragma once
/// The kinds of BSDF, a row each: what readers of scenes, plans and loops over hits ask about a kind, they ask here.
///
/// A kind TYPE is a struct TYPEBsdf in a file of its own, which bsdf_dispatch.h includes, of static functions
///     void make(const MaterialValues &, Bsdf &)                            from a material at a hit
///     BsdfEval evaluate(const BsdfView &, const Vec3 &wi)                  fCos, and the density of sample(), most of the same terms
///     std::optional<Vec3> sample(const BsdfView &, const Vec2 &u, float lobe)
/// and, where its row says so,
///     manyFacets: auto interface(const Bsdf &)                             what a facet does to a walk's light (interfaces.h)
///     lanes:      BsdfEval above(const Bsdf &, const MicroTransform &, const LobeView &, const Vec3 &wo, const Vec3 &wi)
///                 LaneSample sampleLane(const Bsdf &, const MicroTransform &, const LobeView &, float cap, const Vec3 &wo,
///                                       const Vec2 &u, float lobe)         the same for wi.z > 0, without branches;
///                 BsdfEval below(as above)                                 and, of what transmits there, for wi.z < 0
/// In layers `float split(const Bsdf &, const Vec3 &wo)` is the share of samples that the upper one gets. A kind with lobes beside its
/// facets' that light of several facets can be followed on has
///     void prepare(BsdfView &, MultipleScattering &)                       once a hit: LayerView, and what layers above take
///     BsdfEval beside(const BsdfView &, const Vec3 &wi)                    those lobes alone, with the density of
///     std::optional<Vec3> sampleBeside(const BsdfView &, const Vec2 &u, float lobe)

#include <array>
#include <cstdint>
#include <string_view>

namespace taut {

/// Keys of a scene file's material that only some kinds read; all read `color` but those with kF0Key.
enum BsdfKey : std::uint8_t {
    kF0Key = 1,       ///< metal or f0
    kIorKey = 2,      ///< ior
    kMetallicKey = 4, ///< metallic, roughness, anisotropy
};

// clang-format off
#define TAUT_BSDFS(ROW)                                                                                                                    \
    ROW(Conductor,         .name = "conductor", .keys = kF0Key, .manyFacets = true, .lanes = true)                                         \
    ROW(Metal,             .name = "conductor", .keys = kF0Key, .manyFacets = true, .lanes = true)                                         \
    ROW(Dielectric,        .name = "dielectric", .keys = kIorKey, .manyFacets = true, .transmits = true, .refracts = true, .lanes = true)  \
    ROW(Diffuse,           .name = "diffuse", .microsurface = false, .lanes = true)                                                        \
    ROW(Coated,            .name = "coated", .keys = kIorKey, .lanes = true)                                                               \
    ROW(MetallicRoughness, .name = "metallic_roughness", .keys = kIorKey | kMetallicKey, .manyFacets = true, .transmits = true, .lanes = true) \
    ROW(ThinGlass,         .name = "thin_glass", .keys = kIorKey, .transmits = true)
// clang-format on

#define TAUT_ENUMERATOR(TYPE, ...) TYPE,
/// Conductor: Schlick's reflectance; Metal: a measured index, what a scene file's conductor with `metal` becomes.
enum class BsdfType : std::uint8_t { TAUT_BSDFS(TAUT_ENUMERATOR) };
#undef TAUT_ENUMERATOR

struct BsdfInfo {
    BsdfType type;
    std::string_view name;    ///< as a scene file's `type`
    unsigned keys = 0;        ///< BsdfKey
    bool microsurface = true; ///< has an M: reads alpha, rotation, masking, Poisson's ratio
    bool manyFacets = false;  ///< light that meets several facets can be followed
    bool transmits = false;   ///< to the other side of the surface, where the material lets it
    bool refracts = false;    ///< which is another medium: seen from the inside the index is inverted, and radiance scales; of
                              ///< metallic-roughness the material says so (Bsdf::refracts)
    bool lanes = false;       ///< many hits can be shaded at once (render/hit_lanes.h)

    [[nodiscard]] constexpr bool reads(BsdfKey key) const { return (keys & key) != 0; }
    /// Whether a closed lobe can stand in for light of several facets: all of that is reflected.
    [[nodiscard]] constexpr bool compensates() const { return manyFacets && !refracts; }
};

#define TAUT_INFO(TYPE, ...) BsdfInfo{.type = BsdfType::TYPE, __VA_ARGS__},
inline constexpr std::array kBsdfs{TAUT_BSDFS(TAUT_INFO)};
#undef TAUT_INFO

constexpr const BsdfInfo &bsdfInfo(BsdfType type) {
    return kBsdfs[static_cast<std::size_t>(type)];
}

} // namespace taut
