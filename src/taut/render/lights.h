#pragma once
/// Choosing and sampling lights from a point; everything in render space. Every sampler has its density beside it, so that both
/// ends of multiple importance sampling agree.

#include "taut/render/light_tree.h"
#include "taut/scene/scene.h"

#include <span>
#include <vector>

namespace taut {

enum class LightKind : std::uint8_t { Environment, Quad, Sphere, Directional, Point, Spot, Mesh };

/// One light that can be chosen.
struct LightEntry {
    LightKind kind = LightKind::Environment;
    Vec3 radiance{0};          ///< as in scene.h's Light
    Vec3 origin{0};            ///< quad corner; sphere, point, spot centre
    Vec3 u{0}, v{0};           ///< quad edges
    Vec3 alongU{0}, alongV{0}; ///< quad: what a vector in its plane is multiplied by to have its coordinates along the edges
    Vec3 direction{0};         ///< quad normal; directional and spot: the way light travels
    float area = 0;            ///< quad
    float radius = 0;
    Vec3 centre{0}; ///< quad: what its distance is taken to
    float cosInner = 1, cosOuter = 0;
    bool twoSided = false;
    bool cameraVisible = false;
    Index firstPart = kNone; ///< in LightTable::parts; none: reaches everywhere alike
    // Mesh emitters: positions belong to the frame's geometry.
    std::vector<std::span<const Vec3>> steps; ///< at equally spaced times in the shutter
    std::span<const Affine> placements;       ///< of an instanced object, whose one step is in local space
    std::span<const Index3> triangles;
    bool mirrored = false;
};

/// What is chosen: a light, or a triangle of a mesh emitter.
struct LightPart {
    Index entry = kNone;
    Index triangle = 0;
};

struct LightSample {
    Vec3 direction{0}; ///< unit, towards the light
    float distance = kInfinity;
    Vec3 radiance{0};
    float pdf = 0;      ///< per steradian, choice included; delta lights: the probability of the choice
    bool delta = false; ///< can't be met by a scattered ray
};

/// Veach 1997, section 9.2.
inline float powerHeuristic(float a, float b) {
    const float a2 = a * a;
    return a2 / (a2 + b * b);
}

/// Tables of at most this many choices are weighed one by one, which is exact and as fast as a tree.
inline constexpr std::size_t kFewChoices = 16;

struct LightTable {
    std::vector<LightEntry> entries;
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

/// Makes the entries ready to be chosen.
void prepareChoice(LightTable &table);

/// Probability with which sampleLight chooses an entry (and its triangle, of a mesh emitter) at `point`: after the irradiance it could
/// send there, unoccluded. Where the choices are few, and between the tree and what reaches everywhere, a share is spread evenly, so
/// that no light is starved.
float choiceProbability(const LightTable &table, const LightPart &part, const Vec3 &point);

/// The light that a number uniform in [0, 1) chooses at `point`, with the probability; none where none can send anything.
struct LightChoice {
    Index entry = kNone;
    Index triangle = 0;
    float probability = 0;
};
LightChoice chooseLight(const LightTable &table, const Vec3 &point, float choose);

/// A light sample from `point` at a time in the shutter; pdf 0 where the chosen light sends nothing there. `choose` and `u` uniform
/// in [0, 1).
LightSample sampleLight(const LightTable &table, const Vec3 &point, float time, float choose, const Vec2 &u);
/// The same once the light is chosen.
LightSample sampleLight(const LightTable &table, const LightChoice &choice, const Vec3 &point, float time, const Vec2 &u);

/// A quad or sphere light met by a ray. These lights are not geometry: they cast no shadow, hide nothing from scattered rays and
/// are passed through from behind, so that the light of many is the sum of each alone.
struct LightHit {
    Index entry = kNone;
    float t = kInfinity;
    float absCosine = 0;
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

/// Density with which sampleLight returns the direction of a hit on a quad or sphere light: at distance t along unit `direction`, on
/// a surface whose normal makes |cos| with it.
float lightHitPdf(const LightTable &table, Index entry, const Vec3 &point, float t, float absCosine);
/// The same of a hit on a triangle of a mesh emitter at a time in the shutter.
float emitterHitPdf(const LightTable &table, const LightPart &part, const Vec3 &point, float time, float t, float absCosine);

/// Corner of a mesh emitter's triangle at a time in the shutter.
Vec3 emitterPosition(const LightEntry &entry, Index vertex, float time);

} // namespace taut
