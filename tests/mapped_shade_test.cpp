/// What a map leaves out of a relief of real facets: their shade on one another, and nothing else.

#include "catch.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"
#include "study/scenes/relief.h"

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
Pictures compare(const Relief &relief, const Environment &sky) {
    constexpr int kSize = 96;
    constexpr float kAlpha = 0.2F;
    Scene scenes[] = {mappedReliefScene(relief, {}, kAlpha, kSize), reliefScene(reliefMesh(relief, 724), {}, kAlpha, kSize)};
    std::vector<std::vector<float>> pictures;
    for (Scene &scene : scenes) {
        scene.environment = sky;
        for (int i = 0; i < 2; ++i)
            pictures.push_back(coloursOf(renderImage(scene, 1, 64, {}, static_cast<std::uint32_t>(pictures.size()) + 1)));
    }
    const auto mean = [&](std::size_t first) { return meanOf(pictures[first]) + meanOf(pictures[first + 1]); };
    return {expectedDifference(pictures[0], pictures[1], pictures[2], pictures[3]), mean(0) / mean(2) - 1};
}

} // namespace

TEST_CASE("A map is a million real facets but for their shade: where no facet stands in another's light they are the same",
          "[mapped_shade]") {
    for (const float steep : {0.25F, 0.5F}) {
        const Relief relief{4, steep};
        const Pictures even = compare(relief, lightAbove(0));
        const Pictures high = compare(relief, lightAbove(30)); // steeper than any facet
        std::cout << "slopes to " << steep << ": light from everywhere: apart " << even.apart << ", the map brighter by " << even.brighter
                  << "; from above 30 degrees: " << high.apart << ", " << high.brighter << std::endl;
        INFO("slopes to " << steep);
        CHECK(even.apart > 0.005);
        CHECK(even.brighter > 0.7 * even.apart); // what is missing is light that facets keep from each other
        CHECK(high.apart < 0.004);
        CHECK(std::fabs(high.brighter) < 0.001);
    }
}
