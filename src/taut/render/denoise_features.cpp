#include "taut/render/denoise_features.h"

#include "taut/render/shading.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace taut {

namespace {

/// Where a point of render space is seen, pixels from the centre, y down; false behind the camera.
bool project(const Vec3 &p, double fovY, double orthoHeight, int height, Vec2 &pixels) {
    if (orthoHeight > 0) {
        const auto scale = static_cast<float>(height / orthoHeight);
        pixels = Vec2(p.x, -p.y) * scale;
        return true;
    }
    if (!(p.z < 0)) return false;
    const auto scale = static_cast<float>(0.5 * height / std::tan(0.5 * fovY));
    pixels = Vec2(p.x, -p.y) * (scale / -p.z);
    return true;
}

void putVector(float *out, const Vec3 &v) {
    for (int c = 0; c < 3; ++c) out[c] = v[c];
}

/// Probes of a pixel that meet an object at distances further apart have met it in two places.
constexpr float kSameDistance = 0.1F;
/// Probes of a surface in a pixel that tell what it is like.
constexpr int kMostTold = 8;

/// Steps of a unit that channels are kept in; 0: the upper half of a float.
float stepsOf(int feature) {
    if (feature >= kMotion) return 65536;
    if (feature >= kGloss) return 0;
    if (feature >= kLogStretch || feature == kDepth) return 2048;
    if (feature >= kHalfway) return 16384;
    return feature >= kAlbedo ? 32767 / kMostAlbedo : 32767;
}

std::uint16_t upperHalf(float x) {
    return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(std::isfinite(x) ? x : 0.0F) + 0x7fffU) >> 16U);
}
float ofUpperHalf(std::uint16_t bits) {
    const float x = std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16U);
    return std::isfinite(x) ? x : 0;
}
/// In steps, held at a limit.
std::int32_t inSteps(double x, float steps, double most) {
    return std::isfinite(x) ? static_cast<std::int32_t>(std::lrint(std::clamp(x * static_cast<double>(steps), -most, most))) : 0;
}

float logOf(float x) {
    return std::log(std::clamp(x, 1e-6F, 1e6F));
}

/// The lobe's widths and directions as one tensor.
void putGloss(float *out, const SurfacePoint &point, const Mat3 &worldFromRender) {
    if (!bsdfInfo(point.bsdf.type).microsurface) {
        std::fill_n(out, 6, 0.0F);
        return;
    }
    const EquivalentAlpha alpha = equivalentAlpha(point.bsdf.micro);
    const float c = std::cos(alpha.phi);
    const float s = std::sin(alpha.phi);
    const auto place = [&](const Vec3 &local) { return worldFromRender * point.facet.fromLocal(local); };
    const Vec3 t1 = place(Vec3(c, s, 0));
    const Vec3 t2 = place(Vec3(-s, c, 0));
    const auto weight = [](float a) {
        const float held = std::max(a, kLeastGloss);
        return std::isfinite(held) ? 1 / (held * held) : 0.0F;
    };
    const float w1 = weight(alpha.max);
    const float w2 = weight(alpha.min);
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j, ++k) out[k] = w1 * t1[i] * t1[j] + w2 * t2[i] * t2[j];
}

} // namespace

FrameBefore::FrameBefore(const RenderScene &scene) : fovY_(scene.camera().fovY), orthoHeight_(scene.camera().orthoHeight) {
    for (const RenderObject &object : scene.objects()) {
        Shape shape;
        for (const SurfaceStep &step : object.steps) shape.steps.push_back(step.positions);
        shape.placements = object.placements;
        objects_.push_back(std::move(shape));
    }
}

bool FrameBefore::motionOf(const RenderScene &scene, const SurfacePoint &point, float time, Vec2 &pixels) const {
    const auto index = static_cast<std::size_t>(point.object - scene.objects().data());
    if (index >= objects_.size()) return false;
    const Shape &shape = objects_[index];
    const auto at = [&](const std::vector<Vec3> &p) {
        return p[point.corners.x] * point.barycentrics.x + p[point.corners.y] * point.barycentrics.y +
               p[point.corners.z] * point.barycentrics.z;
    };
    const std::size_t last = shape.steps.size() - 1;
    const float place = time * static_cast<float>(last);
    const std::size_t step = std::min(static_cast<std::size_t>(place), last);
    Vec3 then = at(shape.steps[step]);
    if (step < last) then = glm::mix(then, at(shape.steps[step + 1]), place - static_cast<float>(step));
    if (!shape.placements.empty()) then = transformPoint(affineAt(shape.placements, time), then);
    const int height = scene.scene().render.height;
    Vec2 now;
    Vec2 was;
    if (!project(then, fovY_, orthoHeight_, height, was) ||
        !project(point.position, scene.camera().fovY, scene.camera().orthoHeight, height, now))
        return false;
    pixels = was - now;
    return std::isfinite(pixels.x) && std::isfinite(pixels.y) && glm::length(pixels) < 16384;
}

bool writeDenoiseFeatures(const RenderScene &scene, const SurfacePoint &point, const Vec3 &wo, float time, const FrameBefore *before,
                          float *out) {
    const Mat3 worldFromRender(DMat3(scene.worldFromRender()));
    const Vec3 n = worldFromRender * point.facet.n;
    putVector(out + kNormal, n);
    putVector(out + kAlbedo, glm::clamp(point.baseColor, Vec3(0), Vec3(kMostAlbedo)));
    out[kDepth] = logOf(-point.position.z);
    putVector(out + kHalfway, n - 0.5F * (worldFromRender * wo));
    const Vec2 stretch = singularValues(point.stretch.x, point.stretch.y, point.stretch.y, point.stretch.z);
    out[kLogStretch] = logOf(stretch.x);
    out[kLogStretch + 1] = logOf(stretch.y);
    putGloss(out + kGloss, point, worldFromRender);
    Vec2 motion(0);
    const bool known = before != nullptr && before->motionOf(scene, point, time, motion);
    out[kMotion] = motion.x;
    out[kMotion + 1] = motion.y;
    return known;
}

float PixelFeatures::at(int feature) const {
    const float steps = stepsOf(feature);
    if (feature >= kMotion) return static_cast<float>(motion[static_cast<std::size_t>(feature - kMotion)]) / steps;
    const std::uint16_t bits = channels[static_cast<std::size_t>(feature)];
    return steps == 0 ? ofUpperHalf(bits) : static_cast<float>(static_cast<std::int16_t>(bits)) / steps;
}

float PixelFeatures::noiseOf(int which) const {
    return std::fabs(ofUpperHalf(noise[which]));
}

bool FeatureMeans::addHit(Index object, float distance) {
    ++probes_;
    ++covered_;
    ++met_;
    const auto isSame = [&](const Surface &s) {
        return s.object == object && std::fabs(s.distance - distance) <= kSameDistance * std::min(s.distance, distance);
    };
    const auto found = std::find_if(surfaces_.begin(), surfaces_.end(), isSame);
    last_ = static_cast<std::size_t>(found - surfaces_.begin());
    if (found == surfaces_.end()) surfaces_.push_back({object, distance});
    ++surfaces_[last_].hits;
    return surfaces_[last_].told < kMostTold;
}

void FeatureMeans::tell(const float *features, bool motionKnown) {
    Surface &s = surfaces_[last_];
    ++s.told;
    s.moving += motionKnown ? 1 : 0;
    const std::size_t known = motionKnown ? kDenoiseFeatures : kMotion;
    for (std::size_t i = 0; i < known; ++i) {
        const double x = std::isfinite(features[i]) ? static_cast<double>(features[i]) : 0.0;
        s.sums[i] += x;
        if (i < kDepth) s.squares[i] += x * x;
    }
}

PixelFeatures FeatureMeans::rounded(bool edge) const {
    PixelFeatures f;
    if (probes_ == 0) return f;
    const auto share = [&](double of) { return static_cast<std::uint16_t>(std::lrint(65535 * of / probes_)); };
    f.probes = static_cast<std::uint16_t>(std::min(probes_, 65535));
    f.edge = edge ? 1 : 0;
    f.covered = share(covered_);
    f.met = share(met_);
    if (surfaces_.empty()) return f;
    double hits = 0;
    double moving = 0;
    std::array<double, kDenoiseFeatures> sums{};
    std::array<double, kDepth> squares{};
    for (const Surface &s : surfaces_) { // each counts by how often it is met
        const double of = static_cast<double>(s.hits) / s.told;
        hits += s.hits;
        moving += of * s.moving;
        for (std::size_t i = 0; i < kDenoiseFeatures; ++i) sums[i] += of * s.sums[i];
        for (std::size_t i = 0; i < kDepth; ++i) squares[i] += of * s.squares[i];
    }
    f.moving = share(moving);
    double noise[2] = {0, 0};
    for (int i = 0; i < kMotion; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double mean = sums[k] / (i < kDepth ? probes_ : hits);
        const float steps = stepsOf(i);
        f.channels[k] = steps == 0 ? upperHalf(static_cast<float>(mean)) : static_cast<std::uint16_t>(inSteps(mean, steps, 32767));
        if (i < kDepth && probes_ > 1)
            noise[i < kAlbedo ? 0 : 1] += std::max(0.0, squares[k] / probes_ - mean * mean) / (3.0 * (probes_ - 1));
    }
    for (std::size_t k = 0; k < 2; ++k) f.noise[k] = upperHalf(static_cast<float>(noise[k]));
    if (moving == 0) return f;
    for (std::size_t k = 0; k < 2; ++k) f.motion[k] = inSteps(sums[kMotion + k] / moving, stepsOf(kMotion), 0x1p30);
    return f;
}

} // namespace taut
