#pragma once
/// Choosing and sampling lights from a point; everything in render space. Every sampler has its density beside it, so that both
/// ends of multiple importance sampling agree. Lights are placed by place_lights.h.

#include "taut/render/environment_light.h"
#include "taut/render/light_tree.h"
#include "taut/render/mesh_emitter.h"
#include "taut/scene/lights/light_shapes.h"

#include <algorithm>
#include <span>
#include <vector>

namespace taut {

template <class... Shapes>
auto placedShapes(const std::variant<Shapes...> &) -> std::variant<decltype(place(Shapes(), DMat4()))..., MeshEmitter, EnvironmentLight>;
/// Any light in render space. Functions are called by std::visit, a switch where no alternative needs a destructor.
using PlacedShape = decltype(placedShapes(LightShape()));
static_assert(std::is_trivially_copyable_v<PlacedShape>);

/// One light that can be chosen.
struct LightEntry {
    Vec3 radiance{0};        ///< as in Light
    Index firstPart = kNone; ///< in LightTable::parts; none: reaches everywhere alike
    bool cameraVisible = false;
    PlacedShape shape;
};

/// What is chosen: a light, or a triangle of a mesh emitter.
struct LightPart {
    Index entry = kNone;
    Index triangle = 0;
};

/// Triangles of an object side by side that shine alike and are one entry of the light table.
struct EmitterRun {
    Index first = 0; ///< triangle of the object
    Index count = 0;
    Index entry = kNone;
};

/// The part of the light table that triangle `triangle` of an object with these runs is; entry kNone where it is none.
inline LightPart partOfTriangle(const std::vector<EmitterRun> &runs, Index triangle) {
    const auto next = std::upper_bound(runs.begin(), runs.end(), triangle, [](Index t, const EmitterRun &r) { return t < r.first; });
    if (next == runs.begin()) return {};
    const EmitterRun &run = *(next - 1);
    return triangle - run.first < run.count ? LightPart{run.entry, triangle - run.first} : LightPart{};
}

/// How many parts an entry is chosen by.
inline Index partCount(const LightEntry &entry) {
    const auto *mesh = std::get_if<MeshEmitter>(&entry.shape);
    return mesh != nullptr ? static_cast<Index>(mesh->triangles.size()) : 1;
}

/// Veach 1997, section 9.2.
inline float powerHeuristic(float a, float b) {
    const float a2 = a * a;
    return a2 / (a2 + b * b);
}

/// Tables of at most this many choices are weighed one by one, which is exact and as fast as a tree.
inline constexpr std::size_t kFewChoices = 16;

struct LightTable {
    std::vector<LightEntry> entries;
    std::vector<std::vector<EmitterRun>> emitters; ///< [objects] the entries that an object emits through; empty for most
    const Environment *environment = nullptr;
    Index environmentEntry = kNone; ///< none for a constant one: only scattered rays find it
    Mat3 worldFromRender{1};        ///< rotation

    // What prepareChoice() makes of the entries.
    std::vector<LightPart> parts;    ///< all that is somewhere: a mesh emitter's triangles side by side
    std::vector<LightNode> fewParts; ///< [parts] where the choices are few
    LightTree tree;                  ///< over `parts` where they are many
    std::vector<Index> everywhere;   ///< entries that reach everywhere alike: environment and directional lights
    std::size_t choices = 0;
    bool few = true;
};

// --- the choice: light_choice.cpp ------------------------------------------------------------------------------------

/// Makes the entries ready to be chosen.
void prepareChoice(LightTable &table);

/// What follows where there is more than one choice.
float probabilityAmong(const LightTable &table, const LightPart &part, const Receiver &at);

/// Probability with which sampleLight chooses an entry (and its triangle, of a mesh emitter) at a receiver: after the light it could
/// cause there, unoccluded. Where the choices are few, and between the tree and what reaches everywhere, a share is spread evenly, so
/// that no light is starved.
inline float choiceProbability(const LightTable &table, const LightPart &part, const Receiver &at) {
    return table.choices == 1 ? 1.0F : probabilityAmong(table, part, at);
}

/// The light that a number uniform in [0, 1) chooses at a receiver, with the probability; none where none can send anything.
struct LightChoice {
    Index entry = kNone;
    Index triangle = 0;
    float probability = 0;
};
LightChoice chooseAmong(const LightTable &table, const Receiver &at, float choose);
inline LightChoice chooseLight(const LightTable &table, const Receiver &at, float choose) {
    if (table.choices == 1) return {0, 0, 1};
    return table.entries.empty() ? LightChoice{} : chooseAmong(table, at, choose);
}

/// chooseLight() for many receivers at once where a tree chooses (not `few`): the same bits.
using LightChoices = ChoiceLanes<LightChoice>;
void chooseByTree(const LightTable &table, LightChoices &lanes, Instructions instructions = widest());

// --- samples: light_sampling.cpp -------------------------------------------------------------------------------------

/// A light sample from `point` at a time in the shutter, the choice in its density; pdf 0 where the light sends nothing there. `number`
/// uniform in [0, 1)^2.
LightSample sampleLight(const LightTable &table, const LightChoice &choice, const Vec3 &point, float time, const Vec2 &number);
/// The choice made as well.
inline LightSample sampleLight(const LightTable &table, const Receiver &at, float time, float choose, const Vec2 &number) {
    return sampleLight(table, chooseLight(table, at, choose), at.position, time, number);
}

// --- hits: light_hits.cpp --------------------------------------------------------------------------------------------

/// A light that is no geometry, met by a ray. Such lights cast no shadow, hide nothing from scattered rays and are passed through from
/// behind, so that the light of many is the sum of each alone.
struct LightHit : ShapeHit {
    Index entry = kNone;
};

/// Where the ray meets one light before `farthest`; entry kNone where it does not.
LightHit intersectLight(const LightTable &table, Index entry, const Vec3 &origin, const Vec3 &direction, float farthest);

/// Calls `meet(entry, farthest)` for every light that the ray may meet before `farthest`; it returns what is farthest from then on.
template <class Meet>
inline void visitLightsMet(const LightTable &table, const Vec3 &origin, const Vec3 &direction, float farthest, const Meet &meet) {
    if (table.few)
        for (Index entry = 0; entry < table.entries.size(); ++entry) farthest = meet(entry, farthest);
    else
        visitMetBy(table.tree, origin, direction, farthest, [&](Index part, float end) { return meet(table.parts[part].entry, end); });
}

/// Density with which sampleLight returns the direction of a hit, met by a ray from `at`.
float lightHitPdf(const LightTable &table, const LightHit &hit, const Receiver &at);
/// Density with which sampleLight returns the direction of a hit on a triangle of a mesh emitter at a time in the shutter: at distance t,
/// on a surface whose normal makes |cos| with the ray.
float emitterHitPdf(const LightTable &table, const LightPart &part, const Receiver &at, float time, float t, float absCosine);

} // namespace taut
