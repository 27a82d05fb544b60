/// The built-in environment: a photographer's studio for metal, by formula. Large soft boxes give long clean highlights whose
/// width shows the roughness; dark gaps between them give the reflections contrast; a warm floor and cool walls tell up
/// from down. The camera is taken to stand towards -y, so the key is over its left shoulder and the rim behind the object.

#include "taut/scene/environment.h"

#include "taut/base/parallel.h"

namespace taut {

namespace {

constexpr int kWidth = 512;
constexpr int kHeight = 256;

/// A rectangle far away, seen from the origin.
struct SoftBox {
    Vec3 towards;    ///< its centre
    Vec3 across;     ///< roughly along its width
    float halfWidth; ///< tangents of the half angles
    float halfHeight;
    float edge; ///< width of the soft edge, same unit
    Vec3 radiance;
};

float smoothStep(float x) {
    const float t = glm::clamp(x, 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

/// 1 inside the box, 0 outside, smooth between; a little brighter at the centre, as lit cloth is.
float coverage(const SoftBox &box, const Vec3 &w) {
    const Vec3 n = glm::normalize(box.towards);
    const Vec3 s = glm::normalize(box.across - n * glm::dot(box.across, n));
    const float depth = glm::dot(w, n);
    if (depth <= 0.05F) return 0;
    const float x = std::fabs(glm::dot(w, s)) / depth;
    const float y = std::fabs(glm::dot(w, glm::cross(n, s))) / depth;
    const float inside = smoothStep((box.halfWidth - x) / box.edge) * smoothStep((box.halfHeight - y) / box.edge);
    return inside * (1 - 0.3F * sqr(x / box.halfWidth)) * (1 - 0.2F * sqr(y / box.halfHeight));
}

const SoftBox kBoxes[] = {
    // key: a long strip overhead and to the left
    {Vec3(-0.75F, -0.45F, 1.0F), Vec3(0.5F, -1, 0), 0.95F, 0.34F, 0.10F, Vec3(6.0F, 5.8F, 5.5F)},
    // rim: upright, behind to the right
    {Vec3(0.8F, 0.9F, 0.35F), Vec3(1, -0.9F, 0), 0.20F, 0.75F, 0.08F, Vec3(4.2F, 4.5F, 4.9F)},
    // fill: large and weak, right of the camera
    {Vec3(1.0F, -0.75F, 0.30F), Vec3(0.75F, 1, 0), 0.45F, 0.60F, 0.30F, Vec3(0.9F, 0.96F, 1.05F)},
    // kicker: a thin strip low to the left, outside the view of a camera that looks along +y
    {Vec3(-1.0F, 0.05F, 0.15F), Vec3(0.05F, 1, 0), 0.08F, 0.50F, 0.05F, Vec3(2.6F, 2.5F, 2.3F)},
};

/// Walls, ceiling and the floor that sends some of the key back.
Vec3 room(const Vec3 &w) {
    const Vec3 wall(0.085F, 0.10F, 0.125F);
    const Vec3 ceiling(0.05F, 0.055F, 0.065F);
    const Vec3 floorFar(0.16F, 0.155F, 0.15F);
    const Vec3 floorNear(0.42F, 0.39F, 0.35F);
    const Vec3 above = glm::mix(wall, ceiling, smoothStep(w.z * 1.6F));
    const float pool = 0.65F + 0.35F * glm::dot(Vec2(w.x, w.y), Vec2(-0.6F, -0.5F)); // brighter under the key
    const Vec3 below = glm::mix(floorFar, floorNear, smoothStep(-w.z)) * pool;
    return glm::mix(below, above, smoothStep(w.z / 0.12F + 0.5F));
}

// The neutral studio: no colour but that of the object, and a backdrop that is one grey from the floor up to where a framed view ends.
const SoftBox kNeutralBoxes[] = {
    // key: a large cloth overhead and to the left, for soft shadows
    {Vec3(-0.75F, -0.45F, 1.0F), Vec3(0.5F, -1, 0), 0.72F, 0.34F, 0.12F, Vec3(6.0F)},
    // rim: upright, behind to the right
    {Vec3(0.8F, 0.9F, 0.40F), Vec3(1, -0.9F, 0), 0.20F, 0.75F, 0.08F, Vec3(3.0F)},
    // fill: large and weak, right of the camera
    {Vec3(1.0F, -0.75F, 0.30F), Vec3(0.75F, 1, 0), 0.45F, 0.60F, 0.30F, Vec3(0.45F)},
    // kicker: a strip to the left, outside the view of a camera that looks along +y
    {Vec3(-1.0F, 0.05F, 0.25F), Vec3(0.05F, 1, 0), 0.10F, 0.60F, 0.06F, Vec3(1.8F)},
};

Vec3 neutralRoom(const Vec3 &w) {
    constexpr float kBackdrop = 0.30F;
    constexpr float kCeiling = 0.06F;
    constexpr float kBehind = 0.04F; // the dark of a studio behind the camera gives metal its contrast
    const float around = smoothStep(0.5F + 0.9F * glm::dot(Vec2(w.x, w.y), glm::normalize(Vec2(-0.5F, 1.0F))));
    const float wall = glm::mix(kBehind, kBackdrop, around);
    return Vec3(glm::mix(wall, kCeiling, smoothStep(1.4F * w.z - 0.1F)));
}

template <std::size_t N> Environment environmentOf(Vec3 (*room)(const Vec3 &), const SoftBox (&boxes)[N]) {
    Environment e;
    e.width = kWidth;
    e.height = kHeight;
    e.constant = false;
    e.texels.resize(std::size_t{kWidth} * kHeight);
    parallelFor(kHeight, 16, [&](std::size_t row) {
        const float theta = kPi * (static_cast<float>(row) + 0.5F) / kHeight;
        for (int column = 0; column < kWidth; ++column) {
            const float azimuth = 2 * kPi * (0.5F - (static_cast<float>(column) + 0.5F) / kWidth);
            const Vec3 w(std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta));
            Vec3 sum = glm::max(room(w), Vec3(0.05F));
            for (const SoftBox &box : boxes) sum = glm::mix(sum, box.radiance, coverage(box, w));
            e.texels[row * kWidth + static_cast<std::size_t>(column)] = sum;
        }
    });
    buildSampling(e);
    return e;
}

} // namespace

Environment studioEnvironment() {
    return environmentOf(room, kBoxes);
}

Environment neutralStudioEnvironment() {
    return environmentOf(neutralRoom, kNeutralBoxes);
}

} // namespace taut
