/// Orthonormal frames, close to where their field is singular too.

#include "taut/base/frame.h"

#include "catch.h"

#include <random>

using namespace taut;

TEST_CASE("A frame from a normal is orthonormal everywhere", "[base][frame]") {
    std::mt19937 random(4);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> exponent(-9, 0);
    float worst = 0;
    for (int i = 0; i < 100000; ++i) {
        // Half of the normals anywhere, half crowded around -z, down to 1e-9 of it.
        DVec3 n(gauss(random), gauss(random), gauss(random));
        if (i % 2 == 1) n = DVec3(DVec2(n) * std::pow(10.0, exponent(random)), -1);
        const Vec3 normal(glm::normalize(n));
        for (const Frame &f : {smoothFrameFromNormal(normal), quickFrameFromNormal(normal),
                               frameFromNormalTangent(normal, Vec3(gauss(random), gauss(random), gauss(random)))}) {
            worst = std::max({worst, std::fabs(glm::dot(f.s, f.n)), std::fabs(glm::dot(f.s, f.t)), std::fabs(glm::dot(f.t, f.n)),
                              std::fabs(glm::length(f.s) - 1), std::fabs(glm::length(f.t) - 1)});
            REQUIRE(glm::dot(glm::cross(f.s, f.t), f.n) > 0.999F);
        }
    }
    CHECK(worst < 2e-6F);
}
