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
    float pmf = 0;     ///< probability of being chosen
    Vec3 radiance{0};  ///< as in scene.h's Light
    Vec3 origin{0};    ///< quad corner; sphere, point, spot centre
    Vec3 u{0}, v{0};   ///< quad edges
    Vec3 direction{0}; ///< quad normal; directional and spot: the way light travels
    float area = 0;    ///< quad, mesh
    float radius = 0;
    float cosInner = 1, cosOuter = 0;
    bool twoSided = false;
    bool cameraVisible = false;
    // Mesh emitters: triangles with cumulative areas; positions belong to the frame's geometry.
    std::span<const Vec3> positions;
    std::span<const Index3> triangles;
    std::vector<float> cumulativeArea;
    bool mirrored = false;
};

struct LightSample {
    Vec3 direction{0}; ///< unit, towards the light
    float distance = kInfinity;
    Vec3 radiance{0};
    float pdf = 0;      ///< per steradian, choice included; delta lights: the probability of the choice
    bool delta = false; ///< can't be met by a scattered ray
};

struct LightTable {
    std::vector<LightEntry> entries;
    std::vector<float> cumulative; ///< of pmf
    const Environment *environment = nullptr;
    Index environmentEntry = kNone;
    Mat3 worldFromRender{1}; ///< rotation
    float sceneRadius = 1;
};

/// Sets pmf and the choice table from each entry's power; a share is spread evenly so that no light is starved.
void finishLightTable(LightTable &table);

/// A light sample from `point`; pdf 0 where the chosen light sends nothing there. `choose` and `u` uniform in [0, 1).
LightSample sampleLight(const LightTable &table, const Vec3 &point, float choose, const Vec2 &u);

/// The nearest quad or sphere light that a ray meets before `farthest`. These lights are not geometry: they cast no shadow, and
/// are passed through from behind. `cameraRay`: only lights that the camera sees.
struct LightHit {
    Index entry = kNone;
    float t = kInfinity;
    float absCosine = 0;
};
LightHit intersectLights(const LightTable &table, const Vec3 &origin, const Vec3 &direction, float farthest, bool cameraRay);

/// Density with which sampleLight returns the direction of a hit on an emitter: at distance t along unit `direction`, on a
/// surface whose geometric normal makes |cos| with it.
float lightHitPdf(const LightEntry &entry, const Vec3 &point, float t, float absCosine);

/// Radiance that a ray leaving the scene along `direction` meets, and the density with which light sampling finds it.
Vec3 environmentRadiance(const LightTable &table, const Vec3 &direction);
float environmentPdf(const LightTable &table, const Vec3 &direction);

} // namespace taut
