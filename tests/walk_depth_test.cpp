/// Depths of a walk as distributions: the chances of flights against heights that are drawn, light of several facets against walks that
/// are counted, and what is won.

#include "catch.h"
#include "random_transforms.h"
#include "running_mean.h"

#include "taut/base/warp.h"
#include "taut/microsurface/random_walk.h"

using namespace taut;
using taut::test::direction;
using taut::test::randomTransforms;
using taut::test::RunningMean;

namespace {

void checkAgree(const RunningMean &a, const RunningMean &b) {
    CHECK(a.mean() > 0);
    CHECK(std::fabs(a.mean() - b.mean()) < 4 * std::sqrt(a.variance() + b.variance()) + 1e-6 * a.mean());
}

const std::vector<MicroTransform> kSurfaces{microTransformFromAlpha(1, 1), microTransformFromAlpha(0.3F, 0.3F), microTransform(1, 2, 0, 1),
                                            microTransformFromAlpha(1, 0.1F), microTransform(1.2F, 0.4F, 0, 0.9F, 0.4F, -0.3F)};

} // namespace

TEST_CASE("Depth phases: one flight up or down, in closed form", "[walk][depth]") {
    const MicroTransform m = microTransform(1, 0.7F, 0, 1.3F);
    const double a = 1.7; // rate of the first depth
    for (const double theta : {20.0, 70.0, 110.0, 175.0})
        for (const double lambda : {0.0, 0.3, 40.0}) {
            const Vec3 w = direction(theta, 30);
            const walk::Flight flight(m, w);
            const double rate = flight.up ? static_cast<double>(ggx::lambda(m, w)) : 1 + static_cast<double>(ggx::lambda(m, -w));
            walk::DepthPhases depth(static_cast<float>(a));
            CHECK(depth.escape(static_cast<float>(lambda)) == Approx(a / (a + lambda)));
            // Integrals of a exp(-a t) and rate exp(-rate s) over what stays inside.
            const double stopped = flight.up ? rate / (a + rate) : 1.0;
            const double left = flight.up ? stopped * a / (a + lambda) : a / (a + lambda) * rate / (rate + lambda);
            CHECK(static_cast<double>(flight.area * depth.stopThenEscape(flight, static_cast<float>(lambda))) ==
                  Approx(left).epsilon(1e-5));
            CHECK(static_cast<double>(depth.stop(flight, 0.4F)) == Approx(stopped).epsilon(1e-5));
            CHECK(static_cast<double>(depth.escape(static_cast<float>(lambda))) * stopped == Approx(left).epsilon(1e-5));
        }
    // Grazing, straight up and straight down stay finite.
    for (const Vec3 &w : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 1e-30F)}) {
        walk::DepthPhases depth(2);
        CHECK(std::isfinite(depth.stopThenEscape(walk::Flight(m, w), 0.5F)));
        const float chance = depth.stop(walk::Flight(m, w), 0.999F);
        CHECK((chance >= 0 && chance <= 1));
        CHECK(std::isfinite(depth.escape(1e20F)));
    }
}

TEST_CASE("Depth phases: long flights up and down leave as often as drawn heights do", "[walk][depth]") {
    const std::vector<Vec3> flights{direction(110, 10), direction(60, 80), direction(150, 200), direction(95, 300), direction(75, 20)};
    const Vec3 wi = direction(50, 140);
    for (const MicroTransform &m : kSurfaces) {
        const Vec3 wo = direction(35, 250);
        const float lambda = ggx::lambda(m, wi);
        walk::Random random(5);
        std::vector<RunningMean> drawn(flights.size());
        std::vector<RunningMean> known(flights.size());
        std::vector<RunningMean> ahead(flights.size());
        for (int i = 0; i < 200000; ++i) {
            float depth = walk::firstDepth(m, wo, random.exponential());
            walk::DepthPhases phases(walk::Flight(m, -wo).rate());
            double chance = 1;
            for (std::size_t k = 0; k < flights.size(); ++k) {
                const walk::Flight flight(m, flights[k]);
                if (depth >= 0) depth = walk::flight(m, flights[k], depth, random.exponential());
                drawn[k].add(depth >= 0 ? static_cast<double>(walk::escape(m, wi, depth)) : 0.0);
                ahead[k].add(chance * static_cast<double>(flight.area * phases.stopThenEscape(flight, lambda)));
                chance *= static_cast<double>(phases.stop(flight, random.uniform()));
                known[k].add(chance * static_cast<double>(phases.escape(lambda)));
            }
        }
        for (std::size_t k = 0; k < flights.size(); ++k) {
            INFO("flights " << k + 1 << ", det " << m.det);
            checkAgree(drawn[k], known[k]);
            checkAgree(drawn[k], ahead[k]);
        }
    }
}

TEST_CASE("Evaluated light of several facets is the share of walks that meet several", "[walk][furnace]") {
    std::vector<MicroTransform> all = randomTransforms(12);
    all.insert(all.end(), kSurfaces.begin(), kSurfaces.end());
    for (const MicroTransform &m : all)
        for (const double theta : {15.0, 70.0, 95.0}) {
            const Vec3 wo = direction(theta, 60);
            walk::Random random(8);
            RunningMean counted;
            RunningMean evaluated;
            const walk::UniformReflector mirror;
            for (int i = 0; i < 40000; ++i) {
                const Vec2 first(random.uniform(), random.uniform());
                const walk::Exit exit = walk::sample(m, wo, mirror, first, random);
                counted.add(exit.bounces > 1 ? 1.0 : 0.0);
                const Vec3 wi = squareToCosineHemisphere({random.uniform(), random.uniform()});
                evaluated.add(
                    static_cast<double>(walk::evaluateMultiple(m, wo, wi, mirror, walk::drawEnds(random), random).x / (kInvPi * wi.z)));
            }
            INFO("theta " << theta << ", det " << m.det << ": " << counted.mean() << ", " << evaluated.mean() << " +- "
                          << std::sqrt(evaluated.variance()));
            CHECK(std::fabs(counted.mean() - evaluated.mean()) < 4.5 * std::sqrt(counted.variance() + evaluated.variance()));
        }
}

TEST_CASE("Integrated heights and both ends leave less than a third of the variance of next events", "[walk]") {
    const walk::UniformReflector mirror;
    for (const MicroTransform &m : kSurfaces) {
        double logarithms = 0;
        int pairs = 0;
        for (const double view : {5.0, 40.0, 75.0})
            for (const double light : {10.0, 50.0, 80.0})
                for (const double turn : {0.0, 100.0, 180.0}) {
                    const Vec3 wo = direction(view, 30);
                    const Vec3 wi = direction(light, 30 + turn);
                    walk::Random random(4);
                    RunningMean before;
                    RunningMean now;
                    for (int i = 0; i < 20000; ++i) {
                        const walk::Ends ends = walk::drawEnds(random);
                        before.add(static_cast<double>(walk::evaluateByNextEvents(m, wo, wi, mirror, ends.first, random).x));
                        now.add(static_cast<double>(walk::evaluateMultiple(m, wo, wi, mirror, ends, random).x));
                    }
                    logarithms += std::log(now.variance() / before.variance());
                    ++pairs;
                }
        INFO("det " << m.det);
        CHECK(std::exp(logarithms / pairs) < 1.0 / 3);
    }
}
