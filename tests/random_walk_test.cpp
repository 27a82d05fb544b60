/// The random walk on the microsurface: nothing lost, the single bounce in closed form, evaluation and sampling the same thing.

#include "catch.h"
#include "random_transforms.h"
#include "running_mean.h"
#include "statistics.h"

#include "taut/base/parallel.h"
#include "taut/base/warp.h"
#include "taut/bsdf/bsdf.h"
#include "taut/bsdf/interfaces.h"
#include "taut/microsurface/random_walk.h"

#include <random>

using namespace taut;
using taut::test::direction;
using taut::test::randomTransforms;
using taut::test::RunningMean;

namespace {

/// Directions to integrate an evaluation over the sphere or hemisphere: from the walk's first facet, cosine, and their density.
template <class Facets> struct Proposal {
    const MicroTransform &m;
    Vec3 wo;
    const Facets &facets;

    [[nodiscard]] float density(const Vec3 &wi) const {
        const float diffuse = kInvPi * std::fabs(wi.z) * (Facets::kTransmits ? 0.5F : 1.0F);
        float cosine = 0;
        const float area = ggx::visibleArea(m, wo, ggx::stretchedLength(m, wo));
        float mirror = 0;
        if constexpr (Facets::kTransmits)
            mirror = walk::nextEvent(m, facets, {wo, 0, Vec3(1), 1, false}, wi, [](bool, const Vec3 &) { return 1.0F; }).x;
        else if (wi.z > 0)
            mirror = walk::reflectionDensity(m, wo, area, wi, cosine);
        return 0.5F * (diffuse + mirror);
    }
    /// False where the facet sends light to where nothing leaves.
    bool sample(walk::Random &random, Vec3 &wi) const {
        const Vec2 u(random.uniform(), random.uniform());
        if (random.uniform() < 0.5F) {
            wi = squareToCosineHemisphere(u);
            if (Facets::kTransmits && random.uniform() < 0.5F) wi = -wi;
            return wi.z != 0;
        }
        const Vec3 wm = ggx::sampleVisibleNormal(m, wo, u);
        const float cosine = glm::dot(wo, wm);
        if (!(cosine > 0)) return false;
        if constexpr (Facets::kTransmits) {
            if (random.uniform() >= facets.reflectance(cosine, false).x) return facets.refract(wo, wm, cosine, false, wi) && wi.z < 0;
        }
        wi = glm::normalize(2 * cosine * wm - wo);
        return wi.z > 0;
    }
};

/// All light that the evaluation scatters from wo.
template <class Facets>
RunningMean integrateEvaluation(const MicroTransform &m, const Vec3 &wo, const Facets &facets, int samples, int seed) {
    const Proposal<Facets> proposal{m, wo, facets};
    RunningMean estimate;
    walk::Random random(static_cast<std::uint64_t>(seed));
    for (int i = 0; i < samples; ++i) {
        Vec3 wi;
        if (!proposal.sample(random, wi)) {
            estimate.add(0);
            continue;
        }
        estimate.add(
            static_cast<double>(luminance(walk::evaluate(m, wo, wi, facets, walk::drawEnds(random), random)) / proposal.density(wi)));
    }
    return estimate;
}

template <class Facets> walk::Exit sampleWalk(const MicroTransform &m, const Vec3 &wo, const Facets &facets, walk::Random &random) {
    const Vec2 first(random.uniform(), random.uniform());
    return walk::sample(m, wo, facets, first, random);
}

/// Bins of equal solid angle on the sphere.
constexpr int kZ = 10, kPhi = 12, kBins = kZ * kPhi;
int binOf(const Vec3 &w) {
    const int z = glm::clamp(static_cast<int>((w.z + 1) * 0.5F * kZ), 0, kZ - 1);
    const float phi = std::atan2(w.y, w.x) / (2 * kPi) + 0.5F;
    return z * kPhi + glm::clamp(static_cast<int>(phi * kPhi), 0, kPhi - 1);
}
Vec3 pointInBin(int bin, float u, float v) {
    const float z = 2 * (static_cast<float>(bin / kPhi) + u) / kZ - 1;
    const float phi = 2 * kPi * ((static_cast<float>(bin % kPhi) + v) / kPhi - 0.5F);
    const float r = std::sqrt(std::max(0.0F, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}
constexpr double kBinArea = 4 * 3.141592653589793 / kBins;

/// Light that leaves the surface in a walk from wo, by next events towards a direction taken at every facet from its own visible
/// normals, with the density of the textbook: D_vis times the Jacobian of reflection or refraction. 1 on average.
template <class Facets> double leavingLight(const MicroTransform &m, const Vec3 &wo, const Facets &facets, walk::Random &random) {
    double sum = 0;
    const Vec2 first(random.uniform(), random.uniform());
    walk::trace(m, wo, facets, first, random, [&](const walk::Vertex &x) {
        const Vec3 wm = ggx::sampleVisibleNormal(m, x.v, {random.uniform(), random.uniform()});
        const float cosine = glm::dot(x.v, wm);
        if (!(cosine > 0)) return;
        Vec3 wi = 2 * cosine * wm - x.v;
        float density = ggx::visibleNormalPdf(m, x.v, wm);
        float jacobian = 1 / (4 * cosine);
        bool across = false;
        if constexpr (Facets::kTransmits) {
            const float reflected = facets.reflectance(cosine, x.beyond).x;
            across = random.uniform() >= reflected;
            density *= across ? 1 - reflected : reflected;
            if (across) {
                if (!facets.refract(x.v, wm, cosine, x.beyond, wi)) return;
                const float eta = facets.relativeIndex(x.beyond);
                const float cosineBeyond = glm::dot(wi, wm);
                jacobian = eta * eta * std::fabs(cosineBeyond) / sqr(cosine + eta * cosineBeyond);
            }
        }
        // Does not leave at once; or lies on the rim of the hemisphere of normals, where rounding may make the density 0.
        if ((wi.z < 0) != across || !(density > 0)) return;
        const Vec3 event = walk::nextEvent(m, facets, x, x.beyond ? -wi : wi, [&](bool sameSide, const Vec3 &w) {
            return walk::escape(m, w, sameSide ? x.depth : walk::turnedDepth(x.depth));
        });
        sum += static_cast<double>(event.x / (density * jacobian));
    });
    return sum;
}

/// Furnace at one wo for each of the transforms: none beyond the bound for all together, next to none beyond three standard errors.
template <class Measure> void checkFurnace(const std::vector<MicroTransform> &transforms, double theta, const Measure &measure) {
    std::vector<RunningMean> estimates(transforms.size());
    parallelFor(transforms.size(), 1, [&](std::size_t i) {
        estimates[i] = measure(transforms[i], direction(theta, 37.0 * static_cast<double>(i)), static_cast<int>(i));
    });
    int beyondThree = 0;
    for (std::size_t i = 0; i < transforms.size(); ++i) {
        const RunningMean &e = estimates[i];
        INFO("transform " << i << ", theta " << theta << ": " << e.mean() << " +- " << std::sqrt(e.variance()));
        CHECK(e.off(1) < 4.2); // two-sided 1 % over 400 tests
        CHECK(std::sqrt(e.variance()) < 0.02);
        if (e.off(1) > 3) ++beyondThree;
    }
    CHECK(beyondThree <= 1 + static_cast<int>(transforms.size()) / 50);
}
template <class Facets> void checkLeaving(const std::vector<MicroTransform> &transforms, double theta, const Facets &facets, int walks) {
    checkFurnace(transforms, theta, [&](const MicroTransform &m, const Vec3 &wo, int seed) {
        RunningMean e;
        walk::Random random(static_cast<std::uint64_t>(seed));
        for (int i = 0; i < walks; ++i) e.add(leavingLight(m, wo, facets, random));
        return e;
    });
}

} // namespace

TEST_CASE("White furnace of the walk: all light leaves, for 60 random transforms", "[walk][furnace]") {
    const auto transforms = randomTransforms(60);
    // By chance a seventh of such runs has one of 60 beyond three standard errors; hence a bound for all together and one for how many.
    checkLeaving(transforms, 20, walk::UniformReflector{}, 1000000);
    checkLeaving(transforms, 75, walk::UniformReflector{}, 20000);
    checkLeaving(transforms, 89.9, walk::UniformReflector{}, 10000);
}

TEST_CASE("White furnace of the evaluation of rough surfaces", "[walk][furnace]") {
    // Smooth axes make the plain integral of an evaluation heavy-tailed; those are left to the test above.
    std::vector<MicroTransform> rough;
    for (const MicroTransform &m : randomTransforms(80))
        if (singularValues(m.a, m.b, 0, m.d).x < 1.6F && std::fabs(m.p) + std::fabs(m.q) < 1) rough.push_back(m);
    REQUIRE(rough.size() >= 10);
    for (const double theta : {20.0, 75.0})
        checkFurnace(rough, theta, [&](const MicroTransform &m, const Vec3 &wo, int seed) {
            return integrateEvaluation(m, wo, walk::UniformReflector{}, 60000, seed);
        });
}

TEST_CASE("Every walk leaves, upwards, with all its light", "[walk][furnace]") {
    walk::Random random(1);
    for (const MicroTransform &m : randomTransforms(60))
        for (const double theta : {0.0, 60.0, 89.99}) {
            for (int i = 0; i < 500; ++i) {
                const walk::Exit e = sampleWalk(m, direction(theta, 50), walk::UniformReflector{}, random);
                if (e.throughput != Vec3(1) || e.w.z < 0 || std::fabs(glm::length(e.w) - 1) > 1e-4F) FAIL("theta " << theta);
            }
        }
}

TEST_CASE("Mean number of bounces at normal incidence", "[walk]") {
    const auto bounces = [](const MicroTransform &m) {
        RunningMean e;
        walk::Random random(5);
        for (int i = 0; i < 400000; ++i) e.add(sampleWalk(m, Vec3(0, 0, 1), walk::UniformReflector{}, random).bounces);
        return e;
    };
    const auto check = [&](const MicroTransform &m, double truth) {
        const RunningMean e = bounces(m);
        CHECK(e.mean() == Approx(truth).margin(0.001 + 3 * std::sqrt(e.variance())));
    };
    check(microTransformFromAlpha(1, 1), 2.302);
    check(microTransform(1, 2, 0, 1), 3.263);
    check(microTransformFromAlpha(2, 2), 4.383);
    check(microTransform(10, 20, 0, 10), 1.046);
}

TEST_CASE("One bounce of the walk is the height-correlated lobe", "[walk]") {
    int tests = 0;
    double least = 1;
    const auto transforms = randomTransforms(10);
    for (const MicroTransform &m : transforms)
        for (const double theta : {10.0, 70.0}) {
            const Vec3 wo = direction(theta, 20);
            std::vector<double> observed(kBins + 1);
            std::vector<double> expected(kBins + 1);
            constexpr int kWalks = 50000;
            walk::Random random(11);
            for (int i = 0; i < kWalks; ++i) {
                const walk::Exit e = sampleWalk(m, wo, walk::UniformReflector{}, random);
                ++observed[static_cast<std::size_t>(e.bounces == 1 ? binOf(e.w) : kBins)];
            }
            double total = 0;
            constexpr int kNodes = 24;
            for (int bin = kBins / 2; bin < kBins; ++bin) {
                double sum = 0;
                for (int i = 0; i < kNodes * kNodes; ++i) {
                    const float u = (static_cast<float>(i % kNodes) + 0.5F) / kNodes;
                    const float v = (static_cast<float>(i / kNodes) + 0.5F) / kNodes;
                    const Vec3 wi = pointInBin(bin, u, v);
                    sum += static_cast<double>(walk::evaluateSingle(m, wo, wi, walk::UniformReflector{}).x);
                }
                expected[static_cast<std::size_t>(bin)] = sum / (kNodes * kNodes) * kBinArea * kWalks;
                total += expected[static_cast<std::size_t>(bin)];
            }
            expected[kBins] = kWalks - total;
            least = std::min(least, test::chiSquaredP(observed, expected));
            ++tests;
        }
    CHECK(least > test::sidak(0.01, tests));
}

TEST_CASE("The closed single bounce is what the BSDF evaluates, both sides", "[walk]") {
    walk::Random random(3);
    for (const MicroTransform &m : randomTransforms(20))
        for (const float eta : {1.5F, 1 / 1.5F, 1.1F}) {
            Bsdf glass;
            glass.type = BsdfType::Dielectric;
            glass.eta = eta;
            glass.micro = m;
            for (int i = 0; i < 50; ++i) {
                const Vec3 wo = squareToCosineHemisphere({random.uniform(), random.uniform()});
                const Vec3 wi = squareToSphere({random.uniform(), random.uniform()});
                const float found = walk::evaluateSingle(m, wo, wi, DielectricInterface{eta}).x;
                const float truth = ScatteringPoint(glass, wo).evaluate(wi).fCos.x * (wi.z < 0 ? eta * eta : 1);
                CHECK(found == Approx(truth).epsilon(2e-3).margin(1e-6));
            }
        }
}

TEST_CASE("Sampled walks and the mean of the stochastic evaluation are one distribution", "[walk]") {
    double least = 1;
    int tests = 0;
    const auto check = [&](const MicroTransform &m, const Vec3 &wo, const auto &facets, int samples) {
        std::vector<RunningMean> sampled(kBins);
        std::vector<RunningMean> evaluated(kBins);
        walk::Random random(23);
        constexpr int kWalks = 40000;
        for (int i = 0; i < kWalks; ++i) {
            const walk::Exit e = sampleWalk(m, wo, facets, random);
            RunningMean &bin = sampled[static_cast<std::size_t>(binOf(e.w))];
            bin.sum += static_cast<double>(e.throughput.x);
            bin.squares += static_cast<double>(sqr(e.throughput.x));
        }
        double statistic = 0;
        int used = 0;
        for (int b = 0; b < kBins; ++b) {
            RunningMean &s = sampled[static_cast<std::size_t>(b)];
            s.count = kWalks;
            RunningMean &e = evaluated[static_cast<std::size_t>(b)];
            for (int i = 0; i < samples; ++i) {
                const Vec3 wi = pointInBin(b, (static_cast<float>(i % 20) + random.uniform()) / 20, random.uniform());
                e.add(kBinArea * static_cast<double>(walk::evaluate(m, wo, wi, facets, walk::drawEnds(random), random).x));
            }
            if (s.sum < 20) continue;
            statistic += sqr(s.mean() - e.mean()) / (s.variance() + e.variance());
            ++used;
        }
        CHECK(used > 20);
        least = std::min(least, test::upperGamma(0.5 * used, 0.5 * statistic));
        ++tests;
    };
    for (const MicroTransform &m : {microTransformFromAlpha(1, 1), microTransform(1, 1.3F, 0, 0.8F), microTransformFromAlpha(2, 0.7F, 1),
                                    microTransform(1.2F, 0.4F, 0, 0.9F, 0.4F, -0.3F)})
        for (const double theta : {0.0, 65.0}) check(m, direction(theta, 30), SchlickInterface{Vec3(0.6F)}, 800);
    // Refraction at a second facet has narrow peaks: many samples, and surfaces that blur them.
    for (const MicroTransform &m : {microTransformFromAlpha(2, 1.5F), microTransform(0.6F, 0.4F, 0, 0.5F, 0.2F, 0)})
        for (const float eta : {1.5F, 1 / 1.4F}) check(m, direction(40, 30), DielectricInterface{eta}, 6000);
    CHECK(least > test::sidak(0.01, tests));
}

TEST_CASE("Coloured facets: the evaluation integrates to the sampled energy", "[walk]") {
    const ConductorInterface gold{Vec3(0.15557F, 0.42415F, 1.3831F), Vec3(3.6024F, 2.4721F, 1.9155F)};
    for (const MicroTransform &m : randomTransforms(10)) {
        const Vec3 wo = direction(40, 110);
        RunningMean sampled;
        walk::Random random(9);
        for (int i = 0; i < 30000; ++i) sampled.add(static_cast<double>(luminance(sampleWalk(m, wo, gold, random).throughput)));
        const RunningMean evaluated = integrateEvaluation(m, wo, gold, 30000, 10);
        CHECK(std::fabs(sampled.mean() - evaluated.mean()) < 3.7 * std::sqrt(sampled.variance() + evaluated.variance()));
        CHECK(sampled.mean() < 0.95);
    }
}

TEST_CASE("The stochastic evaluation is reciprocal in expectation", "[walk]") {
    const auto mean = [](const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const auto &facets) {
        RunningMean e;
        walk::Random random(31);
        for (int i = 0; i < 60000; ++i) {
            e.add(static_cast<double>(walk::evaluateMultiple(m, wo, wi, facets, walk::drawEnds(random), random).x));
        }
        return e;
    };
    const auto agree = [](const RunningMean &a, double scaleA, const RunningMean &b, double scaleB) {
        CHECK(a.mean() > 0);
        CHECK(std::fabs(a.mean() * scaleA - b.mean() * scaleB) <
              3.7 * std::sqrt(a.variance() * scaleA * scaleA + b.variance() * scaleB * scaleB));
    };
    const Vec3 a = direction(25, 10);
    const Vec3 b = direction(65, 140);
    for (const MicroTransform &m :
         {microTransformFromAlpha(1, 0.5F, 0.4F), microTransform(0.7F, 1, 0, 0.6F), microTransform(1, 0.5F, 0, 1.2F, 0.5F, 0.3F)}) {
        const SchlickInterface metal{Vec3(0.7F)};
        agree(mean(m, a, b, metal), static_cast<double>(a.z), mean(m, b, a, metal), static_cast<double>(b.z));
        const float eta = 1.5F;
        const DielectricInterface glass{eta};
        agree(mean(m, a, b, glass), static_cast<double>(a.z), mean(m, b, a, glass), static_cast<double>(b.z));
        // Across: energy per solid angle over the squared index of where it goes.
        agree(mean(m, a, -b, glass), static_cast<double>(a.z) / static_cast<double>(eta * eta),
              mean(m, b, -a, DielectricInterface{1 / eta}), static_cast<double>(b.z));
    }
}

TEST_CASE("Dielectric walk: what is reflected and what passes add up to all", "[walk][furnace]") {
    const auto transforms = randomTransforms(12);
    for (const float eta : {1.5F, 1 / 1.5F, 1.2F, 2.4F}) {
        checkLeaving(transforms, 30, DielectricInterface{eta}, 20000);
        checkLeaving(transforms, 80, DielectricInterface{eta}, 20000);
    }
    for (const float eta : {1.5F, 1 / 1.5F}) {
        const RunningMean e =
            integrateEvaluation(microTransformFromAlpha(1.5F, 1, 0.4F), direction(50, 20), DielectricInterface{eta}, 60000, 4);
        INFO(e.mean() << " +- " << std::sqrt(e.variance()));
        CHECK(e.off(1) < 4);
        CHECK(std::sqrt(e.variance()) < 0.03);
    }
}

TEST_CASE("Walks are finite from alpha 1e-3 to 10, to grazing and beyond", "[walk]") {
    walk::Random random(41);
    const auto check = [&](const MicroTransform &m, const Vec3 &wo, const auto &facets) {
        for (int i = 0; i < 40; ++i) {
            const walk::Exit e = sampleWalk(m, wo, facets, random);
            CHECK((isFinite(e.w) && isFinite(e.throughput) && maxComponent(e.throughput) <= 1.0001F));
            const Vec3 wi = i % 2 == 0 ? e.w : squareToSphere({random.uniform(), random.uniform()});
            const Vec3 f = walk::evaluate(m, wo, wi, facets, walk::drawEnds(random), random);
            if (!isFinite(f) || f.x < 0) FAIL(f.x << " at wi.z " << wi.z << ", wo.z " << wo.z << ", det " << m.det);
        }
    };
    for (const float alphaX : {1e-3F, 0.05F, 1.0F, 10.0F})
        for (const float alphaY : {1e-3F, 0.3F, 10.0F})
            for (const float lean : {0.0F, 2.0F})
                for (const double theta : {0.0, 45.0, 89.0, 89.99, 90.0, 100.0}) {
                    const MicroTransform m = microTransform(1 / alphaX, 0.5F / alphaX, 0, 1 / alphaY, lean, -lean);
                    check(m, direction(theta, 77), walk::UniformReflector{});
                    check(m, direction(theta, 77), DielectricInterface{1.5F});
                }
}
