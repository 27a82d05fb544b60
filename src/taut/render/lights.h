#pragma once
/// Choosing and sampling lights from a point; everything in render space. Every sampler has its density beside it, so that both
/// ends of multiple importance sampling agree.

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
    float area = 0;            ///< quad, mesh
    float radius = 0;
    Vec3 centre{0}; ///< quad, mesh: what its distance is taken to
    float cosInner = 1, cosOuter = 0;
    bool twoSided = false;
    bool cameraVisible = false;
    // Mesh emitters: triangles with their cumulative areas when the shutter opens; positions belong to the frame's geometry.
    std::vector<std::span<const Vec3>> steps; ///< at equally spaced times in the shutter
    std::span<const Affine> placements;       ///< of an instanced object, whose one step is in local space
    std::span<const Index3> triangles;
    std::vector<float> cumulativeArea;
    bool mirrored = false;

    /// Whether a mesh emitter moves while the shutter is open.
    [[nodiscard]] bool moves() const { return steps.size() > 1 || placements.size() > 1; }
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

struct LightTable {
    std::vector<LightEntry> entries;
    const Environment *environment = nullptr;
    Index environmentEntry = kNone; ///< none for a constant one: only scattered rays find it
    Mat3 worldFromRender{1};        ///< rotation
};

/// Probability with which sampleLight chooses an entry at `point`: after the irradiance it could send there, unoccluded, with a
/// share spread evenly so that no light is starved.
float choiceProbability(const LightTable &table, Index entry, const Vec3 &point);

/// The light that a number uniform in [0, 1) chooses at `point`, with the probability; none where there are none.
struct LightChoice {
    Index entry = kNone;
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

/// Density with which sampleLight returns the direction of a hit on an emitter: at distance t along unit `direction`, on a
/// surface whose geometric normal makes |cos| with it. `growth`: area of a mesh emitter's triangle now over its area when the
/// shutter opened, by which triangles are chosen.
float lightHitPdf(const LightTable &table, Index entry, const Vec3 &point, float t, float absCosine, float growth = 1);

/// Corner of a mesh emitter's triangle at a time in the shutter.
Vec3 emitterPosition(const LightEntry &entry, Index vertex, float time);
/// What lightHitPdf() asks for.
float emitterGrowth(const LightEntry &entry, Index triangle, float time);

} // namespace taut
