#include "taut/render/denoise_frames.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Differences beyond which a pixel of the frame before shows something else.
constexpr float kOtherNormal = 0.4F, kOtherAlbedo = 0.15F, kOtherAlpha = 0.2F, kOtherDepth = 0.1F;
/// Share of the four pixels around a place that must show the point.
constexpr float kLeastSeen = 0.6F;
/// The most that the older picture counts: no error is forgotten more slowly.
constexpr float kMostKept = 0.8F;
/// What the pictures differ by counts so much: a ghost weighs more than noise that stays.
constexpr float kCaution = 2.0F;
/// Radius over which the two pictures are held against each other.
constexpr int kAgreementRadius = 3;

} // namespace

struct FrameDenoiser::Before {
    Window window;
    DenoisePixels pixels;
    Denoised picture;
};

FrameDenoiser::FrameDenoiser(bool overFrames) : overFrames_(overFrames) {}
FrameDenoiser::FrameDenoiser(FrameDenoiser &&) noexcept = default;
FrameDenoiser &FrameDenoiser::operator=(FrameDenoiser &&) noexcept = default;
FrameDenoiser::~FrameDenoiser() = default;

namespace {

/// Whether pixel j of the frame before may show what pixel i of this one does.
bool isAlike(const DenoisePixels &now, std::size_t i, const DenoisePixels &then, std::size_t j) {
    float normal = 0;
    float albedo = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        normal = std::max(normal, std::fabs(now.normal[c][i] - then.normal[c][j]));
        albedo = std::max(albedo, std::fabs(now.albedo[c][i] - then.albedo[c][j]));
    }
    return normal < kOtherNormal && albedo < kOtherAlbedo && std::fabs(now.alpha[i] - then.alpha[j]) < kOtherAlpha &&
           std::fabs(now.depth[i] - then.depth[j]) < kOtherDepth;
}

/// The picture of the frame before, where the points of this one were.
struct Older {
    std::vector<float> rgb;
    Plane error; ///< mean square
    Plane seen;  ///< 1 where the point was in sight, else 0
};

Older olderPicture(const DenoisePixels &now, const DenoisePixels &then, const Denoised &picture) {
    const std::size_t count = now.count();
    Older older{std::vector<float>(3 * count), Plane(count), Plane(count)};
    parallelFor(static_cast<std::size_t>(now.height), 4, [&](std::size_t row) {
        for (int x = 0; x < now.width; ++x) {
            const std::size_t i = row * static_cast<std::size_t>(now.width) + static_cast<std::size_t>(x);
            if (now.moving[i] < 0.5F * now.alpha[i] || now.moving[i] == 0) continue;
            const float u = static_cast<float>(x) + now.motion[0][i];
            const float v = static_cast<float>(row) + now.motion[1][i];
            if (!(u > -1 && v > -1 && u < static_cast<float>(now.width) && v < static_cast<float>(now.height))) continue;
            const int left = static_cast<int>(std::floor(u));
            const int top = static_cast<int>(std::floor(v));
            float sum = 0;
            for (int k = 0; k < 4; ++k) {
                const int px = left + k % 2;
                const int py = top + k / 2;
                if (px < 0 || py < 0 || px >= now.width || py >= now.height) continue;
                const std::size_t j = static_cast<std::size_t>(py) * static_cast<std::size_t>(now.width) + static_cast<std::size_t>(px);
                const float weight = (1 - std::fabs(u - static_cast<float>(px))) * (1 - std::fabs(v - static_cast<float>(py)));
                if (!(weight > 0) || !isAlike(now, i, then, j)) continue;
                sum += weight;
                for (std::size_t c = 0; c < 3; ++c) older.rgb[3 * i + c] += weight * picture.rgb[3 * j + c];
                older.error[i] += weight * picture.error[j] * picture.error[j];
            }
            older.seen[i] = sum >= kLeastSeen ? 1.0F : 0.0F;
            if (older.seen[i] == 0) continue;
            for (std::size_t c = 0; c < 3; ++c) older.rgb[3 * i + c] /= sum;
            older.error[i] /= sum;
        }
    });
    return older;
}

/// Both pictures by the inverse of their errors; that of the older one is what it differs by from the newer, beyond the newer's own.
void blend(const DenoisePixels &now, const Older &older, Denoised &picture) {
    const std::size_t count = now.count();
    Plane apart(count);
    Plane expected(count);
    Plane seen = older.seen;
    for (std::size_t i = 0; i < count; ++i) {
        if (older.seen[i] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const float d = older.rgb[3 * i + c] - picture.rgb[3 * i + c];
            apart[i] += d * d / 3;
        }
        expected[i] = picture.error[i] * picture.error[i];
    }
    Plane close = apart; // what differs in one place is not to be lost among what agrees around it
    Plane closeSeen = seen;
    for (Plane *plane : {&close, &closeSeen}) boxMean(*plane, now.width, now.height, 1);
    for (Plane *plane : {&apart, &expected, &seen}) boxMean(*plane, now.width, now.height, kAgreementRadius);
    for (std::size_t i = 0; i < count; ++i) {
        if (older.seen[i] == 0 || !(seen[i] > 0)) continue;
        const float own = picture.error[i] * picture.error[i];
        const float shown = kCaution * std::max(apart[i] / seen[i], close[i] / closeSeen[i]) - expected[i] / seen[i];
        const float error = std::max({older.error[i], shown, 0.25F * own});
        const float kept = own + error > 0 ? std::min(kMostKept, own / (own + error)) : 0.0F;
        for (std::size_t c = 0; c < 3; ++c) picture.rgb[3 * i + c] += kept * (older.rgb[3 * i + c] - picture.rgb[3 * i + c]);
        picture.error[i] = std::sqrt((1 - kept) * (1 - kept) * own + kept * kept * error);
    }
}

} // namespace

Denoised FrameDenoiser::next(const Film &film) {
    if (!overFrames_) return denoise(film);
    DenoisePixels pixels = denoisePixelsOf(film, film.window());
    Denoised picture = denoise(film);
    if (before_ && before_->window == film.window()) blend(pixels, olderPicture(pixels, before_->pixels, before_->picture), picture);
    before_ = std::make_unique<Before>(Before{film.window(), std::move(pixels), picture});
    return picture;
}

} // namespace taut
