/// The transformed GGX against closed forms and double-precision quadrature.

#include "bsdf_checks.h"
#include "catch.h"

#include "taut/base/sobol.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

struct Named {
    const char *name;
    MicroTransform m;
};

std::vector<Named> upright() {
    return {{"alpha 0.3", microTransformFromAlpha(0.3F, 0.3F)},
            {"alpha 1", microTransformFromAlpha(1, 1)},
            {"anisotropic, turned", microTransformFromAlpha(0.15F, 0.6F, 0.7F)},
            {"squashed", microTransformFromAlpha(2, 1.5F)},
            {"sheared", microTransform(1, 2, 0, 1)},
            {"plate two / 5", microTransform(2, 4, 0, 2)},
            {"det < 0", microTransform(1, 2, 1.5F, -0.5F)}};
}

Bsdf conductor(const MicroTransform &m, bool correlated = true) {
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.f0 = Vec3(1);
    bsdf.micro = m;
    bsdf.correlated = correlated;
    return bsdf;
}

} // namespace

TEST_CASE("The talk's plates and other closed values", "[microsurface]") {
    const MicroTransform sheared = microTransform(10, 20, 0, 10);
    CHECK(ggx::distribution(sheared, glm::normalize(Vec3(0.1F, 0, 1))) == Approx(0.9019664).epsilon(2e-6));
    CHECK(ggx::distribution(sheared, glm::normalize(Vec3(0, 0.1F, 1))) == Approx(8.1176979).epsilon(2e-6));
    CHECK(ggx::distribution(sheared, glm::normalize(Vec3(0.1F, -0.1F, 1))) == Approx(3.6796623).epsilon(2e-6));
    CHECK(ggx::distribution(microTransform(10, 0, 0, 30), Vec3(0, 0, 1)) == Approx(95.4930).epsilon(1e-6));
    CHECK(ggx::distribution(sheared, Vec3(0, 0, 1)) == Approx(31.8310).epsilon(1e-6));
    CHECK(ggx::distribution(microTransform(30, 0, 0, 10), Vec3(0, 0, 1)) == Approx(95.4930).epsilon(1e-6));
    CHECK(ggx::masking(sheared, Vec3(0.6F, 0, 0.8F)) == Approx(0.9985977).epsilon(1e-6));
    CHECK(ggx::masking(sheared, Vec3(0, 0.6F, 0.8F)) == Approx(0.9930659).epsilon(1e-6));
}

TEST_CASE("The canonical form keeps M M^T and the equivalent alphas", "[microsurface]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> entry(-3, 3);
    for (int i = 0; i < 1000; ++i) {
        const float a = entry(random);
        const float b = entry(random);
        const float c = entry(random);
        const float d = entry(random);
        const MicroTransform m = microTransform(a, b, c, d);
        const float size = a * a + b * b + c * c + d * d;
        CHECK(m.a * m.a + m.b * m.b == Approx(a * a + b * b).margin(1e-5F * size));
        CHECK(m.b * m.d == Approx(a * c + b * d).margin(1e-5F * size));
        CHECK(m.d * m.d == Approx(c * c + d * d).margin(1e-5F * size));
        CHECK(m.a > 0);
        CHECK(m.d > 0);
        // From (alphaMax, alphaMin, phi) back to the surface.
        if (std::fabs(a * d - b * c) < 0.05F * size) continue;
        const EquivalentAlpha e = equivalentAlpha(m);
        const MicroTransform again = microTransformFromAlpha(e.max, e.min, e.phi);
        CHECK(again.a == Approx(m.a).epsilon(2e-4));
        CHECK(again.b == Approx(m.b).margin(2e-4 * std::sqrt(size)));
        CHECK(again.d == Approx(m.d).epsilon(2e-4));
    }
}

TEST_CASE("Collapsed and extreme transforms are clamped, finite and keep their direction", "[microsurface][collapse]") {
    for (const Vec4 &block : {Vec4(0, 0, 0, 0), Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(1, 1, 1, 1), Vec4(1e20F, 0, 0, 1e-20F),
                              Vec4(1, 1000, 0, 1), Vec4(1e-30F, 0, 0, 1e-30F), Vec4(NAN, 0, 0, 1), Vec4(INFINITY, 0, 0, 1)}) {
        const MicroTransform m = microTransform(block.x, block.y, block.z, block.w);
        const Vec2 sigma = singularValues(m.a, m.b, 0, m.d);
        CHECK(std::isfinite(m.a + m.b + m.d + m.inverseA + m.inverseD + m.det));
        CHECK(sigma.x <= kGreatestSingularValue * 1.01F);
        CHECK(sigma.y >= kLeastSingularValue * 0.9F);
        CHECK(std::isfinite(ggx::distribution(m, Vec3(0.3F, 0.2F, 0.9F))));
    }
    // (1, 1; 1, 1) has its one direction along the diagonal: the rough axis lies across it.
    CHECK(std::fabs(equivalentAlpha(microTransform(1, 1, 1, 1)).phi) == Approx(kPi / 4).epsilon(1e-3));
}

TEST_CASE("Normalisation and visible area", "[microsurface]") {
    for (const auto &[name, m] : upright()) {
        INFO(name);
        CHECK(integrate([&, t = m](const Vec3 &w) { return ggx::distribution(t, w) * w.z; }, false) == Approx(1).epsilon(2e-3));
        for (const double theta : {0.0, 30.0, 80.0, 130.0}) {
            const Vec3 wo = direction(theta, 40);
            INFO("theta " << theta);
            CHECK(integrate([&, t = m](const Vec3 &w) { return ggx::visibleNormalPdf(t, wo, w); }, false) == Approx(1).epsilon(5e-3));
        }
    }
    MicroTransform leaning = microTransform(2, 0.5F, 0, 1.5F, 0.8F, -0.4F);
    CHECK(integrate([&](const Vec3 &w) { return ggx::distribution(leaning, w) * w.z; }, true) == Approx(1).epsilon(2e-3));
    // The cosine in standard space, w.z / L(w).
    CHECK(0.8F / ggx::stretchedLength(leaning, Vec3(0.6F, 0, 0.8F)) == Approx(0.9624671).epsilon(1e-6));
    CHECK(0.8F / ggx::stretchedLength(leaning, Vec3(-0.6F, 0, 0.8F)) == Approx(0.7496341).epsilon(1e-6));
}

TEST_CASE("Single-scatter albedo", "[microsurface]") {
    // Closed value at alpha 1: 1 - ln 2. Others by quadrature in double elsewhere (the table).
    const auto albedo = [](float alpha) {
        const Bsdf bsdf = conductor(microTransformFromAlpha(alpha, alpha));
        const ScatteringPoint point(bsdf, Vec3(0, 0, 1));
        return integrate([&](const Vec3 &w) { return point.evaluate(w).fCos.x; }, false, 1200);
    };
    CHECK(albedo(1) == Approx(1 - std::log(2.0)).epsilon(1e-4));
    CHECK(albedo(0.5F) == Approx(0.6878485).epsilon(1e-4));
    CHECK(albedo(0.25F) == Approx(0.9158124).epsilon(1e-4));
    CHECK(albedo(0.1F) == Approx(0.9883041).epsilon(1e-3));
}

TEST_CASE("BSDF samplers follow their densities", "[microsurface][chi2]") {
    std::vector<std::pair<std::string, Bsdf>> bsdfs;
    for (const auto &[name, m] : upright()) bsdfs.emplace_back(name, conductor(m));
    Bsdf glass;
    glass.type = BsdfType::Dielectric;
    glass.micro = microTransform(2, 1, 0, 3);
    bsdfs.emplace_back("glass from outside", glass);
    glass.eta = 1 / 1.5F;
    bsdfs.emplace_back("glass from inside", glass);
    Bsdf coated;
    coated.type = BsdfType::Coated;
    coated.albedo = Vec3(0.5F, 0.6F, 0.7F);
    coated.micro = microTransform(3, 1, 0, 2);
    coated.diffuseEscape = coatEscape(1.5F);
    bsdfs.emplace_back("coated", coated);
    coated.micro = microTransform(1, 2, 0, 1); // rough enough for the rejection-free sampler, with what is left of `lobe` as its coin
    bsdfs.emplace_back("coated, rough and skewed", coated);
    Bsdf compensated = conductor(microTransform(1, 2, 0, 1));
    compensated.multiscatter = Multiscatter::Compensation;
    bsdfs.emplace_back("compensated", compensated);
    Bsdf diffuse;
    diffuse.albedo = Vec3(0.5F);
    bsdfs.emplace_back("diffuse", diffuse);
    const std::vector<double> thetas{0, 30, 60, 80, 95};
    const double level = test::sidak(0.01, static_cast<int>(bsdfs.size() * thetas.size()));
    std::uint32_t seed = 1;
    for (const auto &[name, bsdf] : bsdfs)
        for (const double theta : thetas) {
            INFO(name << ", theta " << theta);
            CHECK(chiSquaredOf(bsdf, direction(theta, 25), seed++) > level);
        }
    // The harness notices an azimuth that is wrong by two per cent.
    CHECK(chiSquaredOf(bsdfs[0].second, direction(30, 25), 99, 1000000, 1.02F) < 1e-6);
}

TEST_CASE("Unit circle: the polynomials are cosine and sine", "[microsurface]") {
    double worst = 0;
    for (int i = -1000; i <= 8000; ++i) {
        const float turns = static_cast<float>(i) / 8000;
        const Vec2 p = unitCircle(turns);
        const double angle = 2 * 3.14159265358979323846 * static_cast<double>(turns);
        worst =
            std::max({worst, std::fabs(static_cast<double>(p.x) - std::cos(angle)), std::fabs(static_cast<double>(p.y) - std::sin(angle))});
    }
    CHECK(worst < 1.5e-7);
    CHECK(unitCircle(0.25F) == Vec2(0, 1));
    CHECK(unitCircle(1) == Vec2(1, 0));
    CHECK(isFinite(Vec3(unitCircle(kOneMinusEpsilon), 0)));
}

TEST_CASE("A BSDF rejects no reflection where caps reject many", "[bsdf]") {
    const auto rejected = [](const MicroTransform &m, double theta) {
        const Bsdf bsdf = conductor(m);
        const ScatteringPoint point(bsdf, direction(theta, 25));
        int count = 0;
        for (std::uint32_t i = 0; i < 4096; ++i) count += point.sample(sobol2(i, 1), sobol1(i, 2)) ? 0 : 1;
        return count / 4096.0;
    };
    for (const double theta : {0.0, 60.0, 85.0}) {
        CHECK(rejected(microTransform(1, 2, 0, 1), theta) == 0);
        CHECK(rejected(microTransformFromAlpha(2, 2), theta) == 0);
        // Caps are kept where they lose little.
        CHECK(rejected(microTransformFromAlpha(0.3F, 0.3F), theta) < 0.1);
    }
    CHECK(ReflectionSampler::capsWaste(microTransform(1, 2, 0, 1), 0.585F));
    CHECK(!ReflectionSampler::capsWaste(microTransform(1, 2, 0, 1), 0.587F)); // 58.6 %, closed form
    CHECK(!ReflectionSampler::capsWaste(microTransformFromAlpha(1, 1), 1e-3F));
}

TEST_CASE("Reciprocity and weights", "[microsurface]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    for (const auto &[name, m] : upright()) {
        INFO(name);
        for (const bool correlated : {true, false}) {
            const Bsdf bsdf = conductor(m, correlated);
            for (int i = 0; i < 200; ++i) {
                const Vec3 wo = squareToCosineHemisphere({uniform(random), uniform(random)});
                const Vec3 wi = squareToCosineHemisphere({uniform(random), uniform(random)});
                if (wo.z < 1e-2F || wi.z < 1e-2F) continue;
                const float forward = ScatteringPoint(bsdf, wo).evaluate(wi).fCos.x / wi.z;
                const float backward = ScatteringPoint(bsdf, wi).evaluate(wo).fCos.x / wo.z;
                CHECK(forward == Approx(backward).epsilon(1e-4).margin(1e-12));
                if (const auto s = ScatteringPoint(bsdf, wo).sample({uniform(random), uniform(random)}, 0)) {
                    CHECK(s->weight.x <= 1.001F);
                    CHECK(s->pdf > 0);
                }
            }
        }
    }
}

TEST_CASE("A lossless coat over a white base and lossless glass lose nothing but masking", "[bsdf]") {
    // Smooth surfaces: what single scattering loses to masking vanishes.
    const MicroTransform smooth = microTransformFromAlpha(0.01F, 0.01F);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    const auto albedo = [&](const Bsdf &bsdf, const Vec3 &wo) {
        double sum = 0;
        constexpr int kSamples = 200000;
        const ScatteringPoint point(bsdf, wo);
        for (int i = 0; i < kSamples; ++i)
            if (const auto s = point.sample({uniform(random), uniform(random)}, uniform(random)))
                sum += static_cast<double>(s->weight.x * (s->transmitted ? s->etaScale : 1.0F));
        return sum / kSamples;
    };
    Bsdf coated;
    coated.type = BsdfType::Coated;
    coated.albedo = Vec3(1);
    coated.micro = smooth;
    coated.diffuseEscape = coatEscape(1.5F);
    Bsdf glass;
    glass.type = BsdfType::Dielectric;
    glass.micro = smooth;
    for (const double theta : {0.0, 40.0, 70.0}) {
        INFO("theta " << theta);
        CHECK(albedo(coated, direction(theta, 10)) == Approx(1).epsilon(6e-3));
        CHECK(albedo(glass, direction(theta, 10)) == Approx(1).epsilon(4e-3));
        glass.eta = 1 / 1.5F;
        CHECK(albedo(glass, direction(theta, 10)) == Approx(1).epsilon(4e-3));
        glass.eta = 1.5F;
    }
}

TEST_CASE("Sobol: the fast second dimension is Sobol's, and scrambled points stratify", "[sampler]") {
    for (std::uint32_t i : {1U, 2U, 3U, 77U, 12345U, 0xdeadbeefU, 0xffffffffU}) {
        std::uint32_t expected = 0;
        std::uint32_t column = 1U << 31;
        for (std::uint32_t bits = i; bits != 0; bits >>= 1, column ^= column >> 1)
            if ((bits & 1U) != 0) expected ^= column;
        CHECK(reverseBits(sobolSecondReversed(i)) == expected);
    }
    // A (0, m, 2)-net: 256 points, one in each elementary interval of every shape.
    for (std::uint32_t seed = 1; seed < 6; ++seed)
        for (int k = 0; k <= 8; ++k) {
            std::vector<int> cells(256);
            for (std::uint32_t i = 0; i < 256; ++i) {
                const Vec2 p = sobol2(i, seed);
                const int x = static_cast<int>(p.x * static_cast<float>(1 << k));
                const int y = static_cast<int>(p.y * static_cast<float>(1 << (8 - k)));
                ++cells[static_cast<std::size_t>(x * (1 << (8 - k)) + y)];
            }
            CHECK(std::all_of(cells.begin(), cells.end(), [](int n) { return n == 1; }));
        }
}

TEST_CASE("Sobol: sets of three and of five numbers stratify each other", "[sampler]") {
    // A (t, m, s)-net in base 2 has 2^t points in every elementary interval of 2^(t - m); t is at most the sum of the degrees of the
    // dimensions' polynomials less one each: 1 for three dimensions, 5 for five (Sobol 1967).
    const auto isNet = [&](int t, int m, std::uint32_t dimensions, const auto &point) {
        const int bits = m - t;
        std::vector<int> shape(dimensions, 0);
        bool all = true;
        const std::function<void(std::size_t, int)> forEachShape = [&](std::size_t d, int left) {
            if (d + 1 < shape.size()) {
                for (shape[d] = 0; shape[d] <= left; ++shape[d]) forEachShape(d + 1, left - shape[d]);
                return;
            }
            shape[d] = left;
            std::vector<int> cells(std::size_t{1} << bits);
            for (std::uint32_t i = 0; i < 1U << m; ++i) {
                const std::array<float, 5> p = point(i);
                std::size_t cell = 0;
                for (std::size_t k = 0; k < shape.size(); ++k)
                    cell = (cell << shape[k]) + static_cast<std::size_t>(p[k] * static_cast<float>(1 << shape[k]));
                ++cells[cell];
            }
            all = all && std::all_of(cells.begin(), cells.end(), [&](int n) { return n == 1 << t; });
        };
        forEachShape(0, bits);
        return all;
    };
    for (std::uint32_t seed = 1; seed < 6; ++seed) {
        const auto set = [&](std::uint32_t i) {
            const Vec3 u = sobol3(i, seed);
            const Vec2 v = sobolFourthFifth(i, seed, 17 * seed);
            return std::array<float, 5>{u.x, u.y, u.z, v.x, v.y};
        };
        CHECK(isNet(1, 8, 3, set));
        CHECK(isNet(5, 8, 5, set));
        // The place in the pixel by itself: a (0, m, 2)-net of 4, 8, 32 and 64 points, all five a (1, m, 5)-net of 16.
        const auto place = [&](std::uint32_t i) { return std::array<float, 5>{set(i)[3], set(i)[4]}; };
        for (const int m : {2, 3, 5, 6}) CHECK(isNet(0, m, 2, place));
        CHECK(isNet(1, 4, 5, set));
        // Numbers of sets that know nothing of each other are no net.
        CHECK_FALSE(isNet(1, 8, 3, [&](std::uint32_t i) { return std::array<float, 5>{set(i)[0], set(i)[1], sobol1(i, seed + 99)}; }));
    }
}
