/// A map beside a million real facets: near, what it leaves out is their shade on one another; from afar, its moments.

#include "catch.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"
#include "study/scenes/relief.h"
#include "taut/plan/detail_question.h"

#include <iostream>

using namespace taut;
using namespace taut::test;
using namespace taut::chart;

namespace {

/// Even light from above that elevation, none from below it.
Environment lightAbove(double degrees) {
    Environment sky;
    sky.constant = false;
    sky.width = 4;
    sky.height = 180;
    sky.texels.clear();
    for (int row = 0; row < sky.height; ++row)
        sky.texels.resize(static_cast<std::size_t>(sky.width) * static_cast<std::size_t>(row + 1), Vec3(89.5 - row > degrees ? 1 : 0));
    buildSampling(sky);
    return sky;
}

/// The map and the facets, two independent pictures of each.
struct Pictures {
    double apart;    ///< root mean square of the difference of their expectations, over that of the pictures; negative: hidden by noise
    double brighter; ///< by which share the map is
};
Pictures compare(const Scene &mapped, const Scene &real, int spp) {
    std::vector<std::vector<float>> pictures;
    for (const Scene *scene : {&mapped, &real})
        for (int i = 0; i < 2; ++i)
            pictures.push_back(coloursOf(renderImage(*scene, 1, spp, {}, static_cast<std::uint32_t>(pictures.size()) + 1)));
    const auto mean = [&](std::size_t first) { return meanOf(pictures[first]) + meanOf(pictures[first + 1]); };
    return {expectedDifference(pictures[0], pictures[1], pictures[2], pictures[3]), mean(0) / mean(2) - 1};
}

constexpr int kSide = 724; ///< of the relief, in quads of two facets

Pictures nearUnder(const Environment &sky, const Relief &relief) {
    constexpr int kSize = 96;
    constexpr float kAlpha = 0.2F;
    Scene mapped = mappedReliefScene(relief, {}, kAlpha, kSize);
    Scene real = reliefScene(reliefMesh(relief, kSide), {}, kAlpha, kSize);
    mapped.environment = real.environment = sky;
    return compare(mapped, real, 64);
}

} // namespace

TEST_CASE("A map is a million real facets but for their shade: where no facet stands in another's light they are the same",
          "[mapped_shade]") {
    for (const float steep : {0.25F, 0.5F}) {
        const Relief relief{4, steep};
        const Pictures even = nearUnder(lightAbove(0), relief);
        const Pictures high = nearUnder(lightAbove(30), relief); // steeper than any facet
        std::cout << "slopes to " << steep << ": light from everywhere: apart " << even.apart << ", the map brighter by " << even.brighter
                  << "; from above 30 degrees: " << high.apart << ", " << high.brighter << std::endl;
        INFO("slopes to " << steep);
        CHECK(even.apart > 0.005);
        CHECK(even.brighter > 0.7 * even.apart); // what is missing is light that facets keep from each other
        CHECK(high.apart < 0.004);
        CHECK(std::fabs(high.brighter) < 0.001);
    }
}

TEST_CASE("Moments from afar are a million real facets within about twice the total variation of their fit", "[mapped_shade]") {
    const Relief waves{64, 0.25F};
    const float sigma = 0.5F * waves.steep; // of the slopes along each axis
    const Mesh relief = reliefMesh(waves, kSide);
    for (const float alpha : {0.15F, 0.3F})
        for (const std::vector<DeformerKeys> &motion :
             {std::vector<DeformerKeys>{stretchDeformer(DVec3(1.8, 0.8, 1))}, {shearDeformer(0.6)}}) {
            Scene moments = mappedReliefScene(waves, motion, alpha, 32);
            moments.materials[0].detail = TextureDetail::Moments;
            const Pictures far = compare(moments, reliefScene(relief, motion, alpha, 32), 256);
            const float variation = momentsFitError(sigma / alpha);
            std::cout << "alpha " << alpha << ": moments and facets apart by " << far.apart << ", total variation " << variation
                      << std::endl;
            INFO("alpha " << alpha);
            CHECK(std::fabs(far.apart) < 2.2F * variation);
        }
}
