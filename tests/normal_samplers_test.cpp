/// Every published sampler of micro-normals, reflected and refracted, against its density.

#include "catch.h"
#include "direction_bins.h"

#include "study/microsurface/normal_samplers.h"
#include "taut/base/parallel.h"
#include "taut/base/sobol.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

struct Named {
    std::string name;
    MicroTransform m;
};

/// Diagonal, skewed, squashed, leaning, mirrored, and a rest material under random deformations (one of them leaning).
std::vector<Named> transforms() {
    std::vector<Named> all{{"diagonal", microTransformFromAlpha(0.2F, 0.5F)},
                           {"skewed", microTransform(1, 2, 0, 1)},
                           {"squashed", microTransformFromAlpha(2, 1.5F)},
                           {"leaning", microTransform(2, 0.5, 0, 1.5, 0.8, -0.4)},
                           {"det < 0", microTransform(1, 2, 1.5, -0.5)}};
    std::mt19937 random(2023);
    std::uniform_real_distribution<float> entry(-1.5F, 1.5F);
    for (int i = 0; i < 2; ++i) {
        const Block gradient{entry(random), entry(random), entry(random), entry(random)};
        const Vec2 lean = i == 1 ? Vec2(entry(random), entry(random)) : Vec2(0);
        const MicroTransform rest = microTransformFromAlpha(0.5F, 0.3F, entry(random));
        all.push_back({"random deformation " + std::to_string(i), deformedTransform(gradient, rest, 1.1F, lean)});
    }
    return all;
}

const std::vector<double> kThetas{0, 30, 80, 89.9, 130};
constexpr std::uint32_t kSeed = 2018;

struct Result {
    std::string what;
    double p = 0;
};

/// Light that meets a facet from below the horizon is reflected to wi.z > -wo.z where the macro-normal is the lean's.
double lowestCosine(const MicroTransform &m, const Vec3 &wo) {
    return m.upright() ? std::fmax(0.0F, -wo.z) : 0.0F;
}

template <class S>
double chiSquaredOfReflection(const MicroTransform &m, const S &sampler, const Vec3 &wo, std::uint32_t seed, double bend = 1) {
    Uniform uniform(seed);
    return chiSquaredOf([&] { return sampler.sample(uniform.pair()); }, [&](const Vec3 &wi) { return sampler.pdf(wi); },
                        lowestCosine(m, wo), 1, bend);
}
template <class S> double chiSquaredOfRefraction(const S &sampler, std::uint32_t seed, double bend = 1) {
    Uniform uniform(seed);
    return chiSquaredOf([&] { return sampler.sample(uniform.pair()); }, [&](const Vec3 &wi) { return sampler.pdf(wi); }, -1, 0, bend);
}

/// All results of one M and one view.
std::vector<Result> check(const Named &named, double theta, std::uint32_t seed) {
    std::vector<Result> results;
    const Vec3 wo = direction(theta, 25);
    const auto what = [&](const char *sampler, const char *lobe) {
        return named.name + ", theta " + std::to_string(theta) + ", " + sampler + ", " + lobe;
    };
    forEachReflectionSampler([&](const char *name, auto type) {
        const typename decltype(type)::Type sampler(named.m, wo);
        results.push_back({what(name, "reflected"), chiSquaredOfReflection(named.m, sampler, wo, seed++)});
    });
    const float eta = seed % 2 == 0 ? 1.5F : 1 / 1.5F;
    forEachRefractionSampler([&](const char *name, auto type) {
        const typename decltype(type)::Type sampler(named.m, wo, eta);
        results.push_back({what(name, eta > 1 ? "refracted, eta 1.5" : "refracted, eta 1/1.5"), chiSquaredOfRefraction(sampler, seed++)});
    });
    return results;
}

} // namespace

// 350 tests of a million samples. It is what an image's correctness rests on.
TEST_CASE("Samplers of normals follow their densities, reflected and refracted", "[samplers][chi2]") {
    const auto all = transforms();
    std::vector<std::vector<Result>> results(all.size() * kThetas.size());
    parallelFor(results.size(), 1, [&](std::size_t i) {
        results[i] = check(all[i / kThetas.size()], kThetas[i % kThetas.size()], kSeed + 31 * static_cast<std::uint32_t>(i));
    });
    int tests = 0;
    for (const auto &group : results) tests += static_cast<int>(group.size());
    CHECK(tests == 350);
    const double level = sidak(0.01, tests);
    double least = 1;
    for (const auto &group : results)
        for (const Result &result : group) {
            INFO(result.what << ": p = " << result.p);
            CHECK(result.p > level);
            least = std::min(least, result.p);
        }
    INFO(tests << " tests, least p " << least << ", level " << level);
    SUCCEED();
}

TEST_CASE("Warps of the unit square follow their densities", "[samplers][chi2]") {
    Uniform uniform(kSeed);
    const double level = sidak(0.01, 3);
    const auto follows = [&](const auto &warp, const auto &pdf, double least) {
        return chiSquaredOf([&] { return std::optional<Vec3>(warp(uniform.pair())); }, pdf, least, 1) > level;
    };
    CHECK(follows(
        squareToSphere, [](const Vec3 &) { return squareToSpherePdf(); }, -1));
    CHECK(follows(
        squareToCosineHemisphere, [](const Vec3 &w) { return squareToCosineHemispherePdf(w.z); }, 0));
    const auto raised = [](const Vec2 &u) { // onto the hemisphere above the disk
        const Vec2 d = squareToDisk(u);
        return Vec3(d, std::sqrt(std::fmax(0.0F, 1 - glm::dot(d, d))));
    };
    CHECK(follows(
        raised, [](const Vec3 &w) { return squareToDiskPdf() * w.z; }, 0));
}

TEST_CASE("The chi-squared harness notices samplers that are wrong by two per cent", "[samplers][chi2]") {
    const Vec3 wo = direction(30, 25);
    const auto all = transforms();
    for (const std::size_t i : {0U, 1U, 3U}) {
        INFO(all[i].name);
        const MicroTransform &m = all[i].m;
        // An azimuth bent by two per cent.
        CHECK(chiSquaredOfReflection(m, Reflected<HalfDiskNormals>(m, wo), wo, kSeed, 1.02) < 1e-6);
        CHECK(chiSquaredOfRefraction(Refracted<CapNormals>(m, wo, 1.5F), kSeed, 1.02) < 1e-6);
        // A surface sampled two per cent rougher than its density says.
        const MicroTransform rougher = deformedTransform(Block{1 / 1.02F, 0, 0, 1 / 1.02F}, m);
        const Reflected<DiskNormals> sampled(rougher, wo);
        const Reflected<DiskNormals> claimed(m, wo);
        Uniform uniform(kSeed);
        CHECK(chiSquaredOf([&] { return sampled.sample(uniform.pair()); }, [&](const Vec3 &wi) { return claimed.pdf(wi); }, 0, 1) < 1e-6);
    }
}

TEST_CASE("Caps, half disks and bounded caps share one density up to a constant", "[samplers]") {
    for (const auto &[name, m] : transforms())
        for (const double theta : kThetas) {
            const Vec3 wo = direction(theta, 25);
            const Reflected<CapNormals> caps(m, wo);
            const Reflected<HalfDiskNormals> disk(m, wo);
            const Reflected<BoundedCapNormals> bounded(m, wo);
            Uniform uniform(7);
            float ratio = 0;
            for (int i = 0; i < 500; ++i) {
                const auto wi = bounded.sample(uniform.pair());
                if (!wi || !(caps.pdf(*wi) > 0)) continue;
                INFO(name << ", theta " << theta);
                CHECK(disk.pdf(*wi) == caps.pdf(*wi));
                const float here = bounded.pdf(*wi) / caps.pdf(*wi);
                if (ratio == 0) ratio = here;
                CHECK(here == Approx(ratio).epsilon(1e-5));
                CHECK(ratio >= 0.99999F);
            }
        }
}

TEST_CASE("Bounded caps waste less than whole ones, and no reflection is beyond the bound", "[samplers]") {
    const auto rejected = [](const auto &sampler) {
        Uniform uniform(9);
        constexpr int kSamples = 200000;
        int lost = 0;
        for (int i = 0; i < kSamples; ++i) lost += sampler.sample(uniform.pair()) ? 0 : 1;
        return lost / static_cast<double>(kSamples);
    };
    const Vec3 normal(0, 0, 1);
    const MicroTransform sheared = microTransform(1, 2, 0, 1);
    CHECK(rejected(Reflected<CapNormals>(sheared, normal)) == Approx(0.645).margin(3e-3));
    CHECK(rejected(Reflected<HalfDiskNormals>(sheared, normal)) == Approx(0.645).margin(3e-3));
    CHECK(rejected(Reflected<BoundedCapNormals>(sheared, normal)) == Approx(0.586).margin(3e-3));
    const MicroTransform brushed = microTransformFromAlpha(1, 0.1F);
    CHECK(rejected(Reflected<CapNormals>(brushed, normal)) == Approx(0.297).margin(3e-3));
    CHECK(rejected(Reflected<BoundedCapNormals>(brushed, normal)) == Approx(0.288).margin(3e-3));
    CHECK(rejected(ReflectionSampler(brushed, normal)) < 1e-4);
}

TEST_CASE("Samplers of normals stay unit and finite from alpha 1e-4 to 10, from above and below", "[samplers]") {
    Uniform uniform(3);
    for (const float alphaX : {1e-4F, 1e-2F, 1.0F, 10.0F})
        for (const float shear : {0.0F, 1.0F, 1000.0F})
            for (const double theta : {0.0, 45.0, 89.999, 90.0, 91.0, 130.0, 179.99}) {
                const MicroTransform m = microTransform(1 / alphaX, shear, 0, 1);
                const Vec3 wo = direction(theta, 360 * static_cast<double>(uniform.number()));
                const auto sound = [&](const auto &sampler) {
                    for (int i = 0; i < 200; ++i) {
                        const Vec2 u = i < 4 ? Vec2(i % 2 == 0 ? 0 : kOneMinusEpsilon, i < 2 ? 0 : kOneMinusEpsilon) : uniform.pair();
                        const Vec3 wm = sampler.sample(u);
                        const float pdf = sampler.pdf(wm);
                        if (!isFinite(wm) || std::fabs(glm::length(wm) - 1) > 1e-5F || !std::isfinite(pdf) || pdf < 0) return false;
                    }
                    return true;
                };
                INFO("alpha " << alphaX << ", shear " << shear << ", theta " << theta);
                CHECK(sound(DiskNormals(m, wo)));
                CHECK(sound(HalfDiskNormals(m, wo)));
                CHECK(sound(CapNormals(m, wo)));
                CHECK(sound(BoundedCapNormals(m, wo)));
            }
}

TEST_CASE("Visible normals of a smooth surface seen from below are as spread as they should be", "[samplers]") {
    // The cap is 5e-9 high at alpha 1e-4: 1 + woStd.z has no digits left of it in float, and all samples would fall together.
    const MicroTransform m = microTransformFromAlpha(1e-4F, 1e-4F);
    const Vec3 wo = direction(135, 0);
    Uniform uniform(5);
    const auto meanDepth = [&](const auto &sampler) {
        double sum = 0;
        constexpr int kSamples = 20000;
        for (int i = 0; i < kSamples; ++i) sum += static_cast<double>(sampler.sample(uniform.pair()).z);
        return sum / kSamples;
    };
    // By quadrature over slopes: visible normals lie at standard slopes s with t s > 1, t = alpha, density 2 (t s - 1)^+ / (1 + s^2)^2 per
    // area of slopes over the visible area. wm's slope is alpha s, at least 1 here.
    const double truth = [&] {
        double sum = 0;
        double norm = 0;
        constexpr int kSteps = 2000;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j) {
                // slope x = 1 / v in (1, inf), y = x tan(psi)
                const double v = (i + 0.5) / kSteps;
                const double x = 1 / v;
                const double y = x * std::tan(kPiD * ((j + 0.5) / kSteps - 0.5));
                const double jacobian = x * x * (x + y * y / x);
                const double weight = (x - 1) / sqr(1e-8 + x * x + y * y) * jacobian;
                norm += weight;
                sum += weight / std::sqrt(1 + x * x + y * y);
            }
        return sum / norm;
    }();
    CHECK(meanDepth(CapNormals(m, wo)) == Approx(truth).epsilon(0.01));
    CHECK(meanDepth(HalfDiskNormals(m, wo)) == Approx(truth).epsilon(0.01));
}

TEST_CASE("Chords cut the disk into the shares that are asked for", "[samplers]") {
    double worst = 0;
    for (int i = 0; i <= 100000; ++i) {
        const float u = std::min(static_cast<float>(i) / 100000, kOneMinusEpsilon);
        const auto [x, half] = diskQuantile(u);
        // The truth: the area of the disk left of x, in double, on the side where it does not cancel.
        const double phi = std::atan2(static_cast<double>(half), std::fabs(static_cast<double>(x)));
        const double left = (phi - std::sin(phi) * std::cos(phi)) / kPiD;
        worst = std::max(worst, std::fabs((u < 0.5F ? left : 1 - left) - u));
        CHECK(x * x + half * half == Approx(1).margin(2e-6));
        if (i % 1000 != 0) continue;
        const auto exact = diskQuantile(static_cast<double>(u));
        CHECK(x == Approx(exact.x).margin(1e-6));
        CHECK(half == Approx(exact.half).margin(1e-6));
    }
    INFO("share of the disk: worst error " << worst);
    CHECK(worst < 5e-7);
    CHECK(diskQuantile(0.0F).x == Approx(-1).margin(1e-6));
}

// What the renderer chooses between (ggx::prefersChords): light that a rough surface sends through half a space, as another surface
// would leave it open, estimated with 64 stratified samples.
TEST_CASE("Chords spread the samples of brushed metal better than caps, caps those of round gloss", "[samplers][spread]") {
    const auto squaredErrors = [](float alphaX, float alphaY) {
        const MicroTransform m = microTransformFromAlpha(alphaX, alphaY);
        Uniform uniform(3);
        double caps = 0, chords = 0;
        for (int scene = 0; scene < 96; ++scene) {
            const Vec2 at = uniform.pair();
            const Vec3 wo = direction(80 * at.x, 360 * at.y);
            const Vec3 open = squareToSphere(uniform.pair());
            const float offset = 0.5F * uniform.pair().x;
            const auto mean = [&](const auto &normals, int first, int count, std::uint32_t seed) {
                double sum = 0;
                for (int i = first; i < first + count; ++i) {
                    const Vec3 wm = normals.sample(sobol2(static_cast<std::uint32_t>(i), seed));
                    const Vec3 wi = 2 * glm::dot(wo, wm) * wm - wo;
                    if (wi.z > 0 && glm::dot(wi, open) > -offset) sum += ggx::reflectionWeight(m, wo, wi, false);
                }
                return sum / count;
            };
            const double truth = mean(CapNormals(m, wo), 0, 1 << 15, 1);
            for (std::uint32_t seed = 2; seed < 34; ++seed) {
                caps += sqr(mean(CapNormals(m, wo), 0, 64, seed) - truth);
                chords += sqr(mean(ChordNormals(m, wo), 0, 64, seed) - truth);
            }
        }
        return chords / caps;
    };
    std::string table;
    const auto ratio = [&](float alphaX, float alphaY) {
        const double r = squaredErrors(alphaX, alphaY);
        table += "alpha (" + std::to_string(alphaX) + ", " + std::to_string(alphaY) + "): " + std::to_string(r) + "\n";
        return r;
    };
    const double round = ratio(0.3F, 0.3F);
    ratio(0.2F, 0.4F);
    const double fiveTimes = ratio(0.08F, 0.4F);
    const double tenTimes = ratio(0.05F, 0.5F);
    INFO("squared error, chords over caps\n" << table);
    CHECK(round > 1.2);
    CHECK(fiveTimes < 0.95);
    CHECK(tenTimes < 0.9);
}
