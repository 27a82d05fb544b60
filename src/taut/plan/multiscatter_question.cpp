#include "taut/plan/multiscatter_question.h"

#include "taut/microsurface/transform.h"

#include <algorithm>

namespace taut {

namespace {

/// Total variation between the compensation's lobe and the walk's, weighed for the smoothing that any light does to lobes so broad.
constexpr float kCompensationLobeError = 0.35F;
/// Variance of the light of several facets over that of independent paths without next events, measured over the scenes of `taut chart
/// plan` and `render`: with it, mended error over noise, squared, comes out within a factor of three where it is near one.
constexpr float kNoiseShare = 0.33F;
/// Relative variance of a sample of such light between reflecting facets, where heights are integrated out (random_walk.h) and lights are
/// sampled: of a plate of alpha 0.15 under a lamp, 4 samples a pixel; 0.4 at alpha 0.5. Held by taut_tests "[noise]".
constexpr float kReflectedVariance = 3;
/// A grazing view loses more than the average over views; facets of a map are seen at grazing angles everywhere.
constexpr float kGrazingLoss = 2;
constexpr float kMappedLoss = 5;

/// Share of diffuse light that meets several facets.
float lossAt(const Vec2 &alpha) {
    return 1 - energy::averageAlbedo(microTransformFromAlpha(alpha.x, alpha.y));
}

/// Noise of light that meets several facets over the light itself, both root mean squares of a pixel of n samples.
///
/// A share s, the loss, of the paths meets several facets. Let all of them see radiances of mean m and mean square q = m^2 / coverage.
/// Single scattering weighs each sample by 1 - s: its mean is s m short, its variance (1 - s)^2 (q - m^2) / n. A walk gives every path
/// its whole light instead, which has the variance (q - m^2) / n. So the square of its noise over what it mends is
///     (2 - s) (1 / coverage - 1) / (n s)
/// and a share of that where samples are stratified and lights are looked for as well: even light gets no noisier, small lights do
/// where n s coverage, the number of paths that find one, is small.
float noiseOverLight(float loss, float coverage, int samples) {
    return std::sqrt(kNoiseShare * (2 - loss) * (1 / coverage - 1) / (static_cast<float>(samples) * loss));
}

/// How much of what a material's objects see is bright, at most. Its last facet spreads a light over the width of its lobe.
float coverageOfMaterial(const Scene &scene, Index material, const SceneLights &lights, int frame, const Vec2 &alpha) {
    float coverage = 0;
    for (const Object &object : scene.objects) {
        if (std::find(object.materials.begin(), object.materials.end(), material) == object.materials.end()) continue;
        const Bounds box = worldBounds(object, frame, scene.render.fps);
        if (!box.empty()) coverage = std::fmax(coverage, lightCoverage(lights, box, 4 * kPi * alpha.x * alpha.y)); // 1 / the peak of D / 4
    }
    return coverage > 0 ? coverage : 1;
}

} // namespace

MultiscatterPlan planMultiscatter(const Material &material, const Vec2 &greatestAlpha, float budget, const PlanScales &scales,
                                  const PlanCosts &costs) {
    MultiscatterPlan plan;
    const bool isOpen = material.multiscatter == Multiscatter::Auto && multiscatterOf(material, Multiscatter::Auto) == Multiscatter::Auto;
    if (!isOpen) return plan;
    const float loss = lossAt(greatestAlpha);
    plan.negligibleLoss = 0.5F * budget / kGrazingLoss;
    const float seen = material.slopes.isGiven() ? kMappedLoss : kGrazingLoss;
    Question q{{{Multiscatter::Off, scales.off * seen * loss, 0, 0, {}}}, 0};
    if (bsdfInfo(material.type).compensates() && costs.compensation < costs.walkAt(loss))
        q.choices.push_back(
            {Multiscatter::Auto, scales.compensation * (kGrazingLoss * plan.negligibleLoss + kCompensationLobeError * loss), costs.compensation, 0, {}});
    q.choices.push_back({Multiscatter::Walk, 0, costs.walkAt(loss), 0, {}});
    float left = budget;
    take(q, left);
    plan.model = q.answer<Multiscatter>();
    plan.error = q.choices[q.taken].error;
    plan.question = std::move(q);
    return plan;
}

void weighNoise(const Scene &scene, Index material, const Vec2 &greatestAlpha, const SceneLights &lights, int frame,
                MultiscatterPlan &plan) {
    const float coverage = coverageOfMaterial(scene, material, lights, frame, greatestAlpha);
    float noise = noiseOverLight(lossAt(greatestAlpha), coverage, scene.render.spp);
    if (!bsdfInfo(scene.materials[material].type).refracts)
        noise = std::min(noise, std::sqrt(kReflectedVariance / static_cast<float>(scene.render.spp)));
    Question &q = *plan.question;
    const float lost = q.choices.front().error;
    for (std::size_t i = 1; i < q.choices.size(); ++i) q.choices[i].noise = noise * lost;
    if (!(noise > 1)) return;
    q.taken = 0;
    plan.model = Multiscatter::Off;
    plan.error = lost;
}

} // namespace taut
