#pragma once
/// Shading of many hits at once, structure of arrays: what hits on one material need, in loops that the compiler vectorises
/// (base/instructions.h). The formulas are those of hits one by one, by the same functions, and no compiler may fuse or reorder their
/// sums (-ffp-contract=off, no fast math): the bits are the same, to which a test holds whole pictures.
///
/// laneMaterial() says which materials go this way. All others go one by one (shading.h), as do mapped ones on meshes with a stored M.
/// Lanes that are `scattersAlone` are seen at once and scatter one by one (shade_hit.cpp).
///
/// The order of a batch: gather (gather.cpp), view(), aim(), connect(), scatter().

#include "taut/base/instructions.h"
#include "taut/base/lanes.h"
#include "taut/microsurface/mesostructure.h"
#include "taut/microsurface/reflection_sampler.h"
#include "taut/render/light_candidates.h"
#include "taut/render/shading.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace taut {

/// Up to kSize hits on one material. Directions called local are in the shading frame.
struct alignas(64) HitLanes {
    static constexpr int kSize = 64;
    /// Lanes are worked on in whole vectors: the lanes from `count` to the next multiple of this repeat the first.
    static constexpr int kStep = 16;
    using Vectors = Lanes3<kSize>;

    int count = 0;

    // Gathered: the surface (surface_geometry.h) and the path.
    Vectors position, e1, e2, normal, tangent;
    float tangentSense[kSize], corners[kSize];
    Vectors diagonal, offDiagonal; ///< V as SymmetricTensor
    int deforms[kSize];            ///< 0: V is the identity, whatever those hold
    bool hasOthers = false;        ///< a mesh of one of the lanes deforms in another way: HitDeformation of these
    int other[kSize];              ///< 1: one of these
    Vec3 otherStretch[kSize];
    Vec2 otherTangent[kSize], otherLean[kSize];
    int followsPoisson[kSize]; ///< 0: lambda is in V already
    int stored[kSize];         ///< 1: of a mesh with a stored M, and otherStretch is sqrt(M M^T)
    float strain[kSize];
    Vectors wo;    ///< render space
    Vectors color; ///< the material's values there, textures looked up
    float metallic[kSize], alphaX[kSize], alphaY[kSize];
    float cosine[kSize], sine[kSize];   ///< of the rest rotation
    bool leans = false;                 ///< M may, in one of the lanes, and facets be tilted: what follows is set then
    float slopeX[kSize], slopeY[kSize]; ///< SlopeStatistics
    Vectors slopeSpread;
    Vectors specularColor; ///< of a material with layers: KHR_materials_specular and the share of a coat
    float specular[kSize], clearcoat[kSize];
    Vectors throughput;
    float etaScale[kSize], time[kSize];
    std::uint32_t sample[kSize], seed[kSize];
    Index path[kSize];

    // view(): frame, M and the numbers of this event.
    Vectors geometricNormal;
    Vectors s, t, n; ///< of what scatters: the shading frame, or a tilted facet's
    int tilted[kSize];
    Vectors woLocal; ///< in that frame
    float clearance[kSize];
    float facing[kSize], sense[kSize];
    Vectors stretch; ///< in the frame: ss, st, tt
    double inverseLambda[kSize];
    float tangentX[kSize], tangentY[kSize];
    float a[kSize], b[kSize], d[kSize], inverseA[kSize], inverseD[kSize], det[kSize];
    float p[kSize], q[kSize];
    int inRange[kSize]; ///< whether a, b, d are M's; else singular values are to be clamped
    float length[kSize], area[kSize], capBound[kSize], pdfScale[kSize];
    int correlated[kSize]; ///< Bsdf::correlated
    Vectors reflected;     ///< of kinds with several lobes: by the facets, on average; and what they cover
    float cover[kSize];
    float facets[kSize], diffuse[kSize], kept[kSize]; ///< LobeShares
    float coated[kSize], under[kSize];                ///< and of those with layers: LobeShares::coat and under
    float coatReflected[kSize];                       ///< LayerView::coatShare
    int dark[kSize], suffices[kSize];
    bool compensates = false; ///< light of several facets is given back in one of the lanes: MultipleScattering, 0 in the others
    int several[kSize];       ///< whether, in that lane
    int scattersAlone[kSize]; ///< 1: this lane scatters by itself: light of several facets is to be followed, or no loop knows the material
    float loss[kSize], lossMean[kSize], chance[kSize];
    Vectors severalColor;
    float compensation[kSize]; ///< multiple::compensation of a direction
    float viewLoss[kSize];     ///< 1 - E of the view, where the diffuse part has to know
    int cone[kSize];           ///< 1: caps would waste too much, ReflectionCone is sampled; else 0
    struct Cones {
        Vectors axisNormal, disk;
        float alongX[kSize], alongY[kSize], tiltX[kSize], tiltY[kSize], inverseAxis[kSize];
    } cones; ///< of those lanes
    float lightChoice[kSize], lightU[kSize], lightV[kSize], scatterU[kSize], scatterV[kSize], coin[kSize], roulette[kSize];

    // aim(): light samples, render space; pdf 0: none. `weighted` is 0 for lights that no scattered ray can meet.
    Vectors lightDirection, lightRadiance;
    float lightPdf[kSize], lightWeighted[kSize], lightDistance[kSize];
    Index lightEntry[kSize];
    EnvironmentLanes sky; ///< those that go there
    LightChoices lights;
    CandidateChoice candidates[kSize]; ///< where lights are several: what keep() keeps
    Vectors keptDirection, keptContribution, keptOrigin;
    float keptDistance[kSize];
    Index keptEntry[kSize];

    // connect(): a shadow ray's start and what it would bring; nothing but where `connects` > 0.
    Vectors shadowOrigin, contribution;
    float connects[kSize];

    // scatter(): the next ray; the path ends but where `goesOn` > 0.
    float facetCoin[kSize]; ///< LaneSample
    float coatCoin[kSize];  ///< of the coat's, likewise
    Vectors scatterLocal, nextOrigin, nextDirection, nextThroughput;
    float scatterPdf[kSize], nextEtaScale[kSize];
    float usable[kSize]; ///< of what transmits: LaneSample
    float goesOn[kSize];

    /// The coat: a microsurface of its own on these hits, of which s, t and n are seen from that of the base.
    std::unique_ptr<HitLanes> coat;

    /// Lanes that loops run over.
    [[nodiscard]] int padded() const { return (count + kStep - 1) / kStep * kStep; }
    [[nodiscard]] bool allAlone() const {
        return std::all_of(scattersAlone, scattersAlone + count, [](int one) { return one != 0; });
    }
    [[nodiscard]] MicroTransform micro(std::size_t i) const {
        return {a[i], b[i], d[i], leans ? p[i] : 0.0F, leans ? q[i] : 0.0F, inverseA[i], inverseD[i], det[i]};
    }
};

/// A material as loops take it.
struct LaneMaterial {
    bool inLanes = false;
    bool varies = false;        ///< from hit to hit: by textures or colours of the mesh
    bool scattersAlone = false; ///< its lanes scatter one by one from what was gathered
    bool mapped = false;        ///< a map tilts its facets
    bool coatMapped = false;    ///< those of its coat
    bool layered = false;       ///< has a coat, or numbers of KHR_materials_specular that vary
    const PreparedMaterial *prepared = nullptr;
    Bsdf bsdf;             ///< its kind, seen from the outside; without an M
    MaterialValues values; ///< where it does not vary
    RestRoughness rest{1, 1, 0};
};
LaneMaterial laneMaterial(const PreparedMaterial &prepared);
/// Whether V is interpolated as it is, and nothing else is asked of the deformation.
bool isPlain(const RenderObject &object);

/// The sets of numbers that an event draws (sample_dimensions.h).
struct EventNumbers {
    std::uint32_t scatter, light, roulette;
    std::size_t lights = 2; ///< to choose from: numbers that one or none has no use for are left out
};

namespace lanes {

/// Fills the values of a lane, and of all lanes for a material that does not vary.
void setValues(HitLanes &lanes, std::size_t lane, const Vec3 &color, float metallic, const RestRoughness &rest);
void setValues(HitLanes &lanes, const LaneMaterial &material);
/// `slopes`: slopesAt() of a material's map.
void setSlopes(HitLanes &lanes, std::size_t lane, const SlopeStatistics &slopes);

/// Fills what follows the gathered part, for event number `numbers`.
void view(HitLanes &lanes, const LaneMaterial &material, const EventNumbers &numbers, Instructions instructions = widest());
/// These where there is a light.
void aim(HitLanes &lanes, const LaneMaterial &material, const LightTable &lights, int candidate = 0);
void connect(HitLanes &lanes, const LaneMaterial &material, Instructions instructions = widest());
/// One of several candidates (light_candidates.h): what connect() found of each is shown to the lanes' choices, and in the end what they
/// kept takes its place.
void keep(HitLanes &lanes);
void useKept(HitLanes &lanes, int candidates);
void scatter(HitLanes &lanes, const LaneMaterial &material, Instructions instructions = widest());

} // namespace lanes
} // namespace taut
