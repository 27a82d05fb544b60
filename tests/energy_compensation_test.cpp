/// Energy compensation: the committed table against quadrature and against its generator, the furnace, the walk; and both treatments of
/// multiple scattering as the BSDF offers them.

#include "catch.h"
#include "running_mean.h"

#include "study/microsurface/energy_fit.h"

#include "taut/base/frame.h"
#include "taut/bsdf/bsdf.h"

#include <random>

using namespace taut;
using taut::test::direction;

namespace {

/// Upright surfaces of the table's range, diagonal and turned, isotropic ones among them, with a direction each.
struct Point {
    MicroTransform m;
    Vec3 w;
};
std::vector<Point> randomPoints(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        const tables::Surface surface = tables::randomSurface(random, 0.02F, 2, 20);
        const Vec3 w = tables::randomDirection(random, surface);
        const float turn = 0.37F * static_cast<float>(i);
        const float c = std::cos(turn);
        const float s = std::sin(turn);
        points.push_back({microTransformFromAlpha(surface.rougher, surface.smoother, turn), {c * w.x - s * w.y, s * w.x + c * w.y, w.z}});
    }
    return points;
}

/// Cosine-weighted mean over the hemisphere.
template <class F> double diffuseMean(const F &f, std::uint32_t samples = 4096) {
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
        const Vec3 w = squareToCosineHemisphere(sobol2(i, 4711));
        if (w.z > 0) sum += static_cast<double>(f(w));
    }
    return sum / samples;
}

Bsdf metal(const MicroTransform &m, Multiscatter multiscatter, const Vec3 &f0 = Vec3(1)) {
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.micro = m;
    bsdf.f0 = f0;
    bsdf.multiscatter = multiscatter;
    return bsdf;
}

/// Mean weight of sampled directions: the albedo.
double sampledAlbedo(const Bsdf &bsdf, const Vec3 &wo, std::uint32_t samples) {
    const ScatteringPoint point(bsdf, wo);
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
        const auto s = point.sample(sobol2(i, 1), sobol1(i, 2), hash(i, 3));
        if (s) sum += static_cast<double>(luminance(s->weight));
    }
    return sum / samples;
}

const std::vector<MicroTransform> &charted() {
    static const std::vector<MicroTransform> transforms{microTransformFromAlpha(0.25F, 0.25F),
                                                        microTransformFromAlpha(1, 1),
                                                        microTransformFromAlpha(2, 2),
                                                        microTransformFromAlpha(1, 0.05F, 0.4F),
                                                        microTransformFromAlpha(2, 0.1F),
                                                        microTransformFromAlpha(0.4F, 0.02F, 1),
                                                        microTransform(1, 2, 0, 1),
                                                        microTransform(5, 6, 0, 1),
                                                        microTransform(10, 20, 0, 10)};
    return transforms;
}

} // namespace

TEST_CASE("The table's albedo is that of quadrature", "[energy]") {
    const auto points = randomPoints(1500, 99);
    double squares = 0;
    for (const auto &[m, w] : points) {
        const double truth = tables::albedo(m, w, 2048);
        const double error = static_cast<double>(energy::singleScatterAlbedo(m, w)) - truth;
        squares += error * error;
        INFO("albedo " << truth);
        CHECK(std::fabs(error) < 0.015);
    }
    CHECK(std::sqrt(squares / static_cast<double>(points.size())) < 0.003);
    // Closed forms and known values at normal incidence.
    const auto atNormal = [](float alpha) { return energy::singleScatterAlbedo(microTransformFromAlpha(alpha, alpha), Vec3(0, 0, 1)); };
    CHECK(atNormal(1) == Approx(1 - std::log(2.0)).margin(6e-3));
    CHECK(atNormal(0.5F) == Approx(0.6878485).margin(6e-3));
    CHECK(atNormal(0.25F) == Approx(0.9158124).margin(6e-3));
    CHECK(atNormal(0.1F) == Approx(0.9883041).margin(8e-3));
}

TEST_CASE("The table's mean albedo is that of quadrature and of its own albedo", "[energy]") {
    for (const auto &[m, w] : randomPoints(60, 5)) {
        const double mean = static_cast<double>(energy::averageAlbedo(m));
        CHECK(mean == Approx(tables::averageAlbedo(m, 16384)).margin(8e-3));
        CHECK(mean == Approx(diffuseMean([&, t = m](const Vec3 &v) { return energy::singleScatterAlbedo(t, v); })).margin(6e-3));
    }
}

TEST_CASE("The committed constants are what their generator makes", "[energy]") {
    // A fit from a fifth of the points: not digit for digit, but the same function.
    const std::vector<double> albedo = tables::fitAlbedo(8000, 1024);
    const std::vector<double> average = tables::fitAverage(albedo, 1000, 1024);
    REQUIRE(albedo.size() == energy::table::kAlbedo.size());
    REQUIRE(average.size() == energy::table::kAverage.size());
    namespace t = energy::table;
    double squares = 0;
    const auto points = randomPoints(1000, 3);
    for (const auto &[m, w] : points) {
        const auto at = energy::coordinates(m, w);
        const auto e = energy::chebyshev<t::kElevation>(at.elevation);
        const auto a = energy::chebyshev<t::kAlong>(at.along);
        const auto b = energy::chebyshev<t::kAcross>(at.across);
        const auto r = energy::chebyshev<2>(at.correlation);
        double sum = 0;
        std::size_t k = 0;
        for (const float x : e)
            for (const float y : a)
                for (const float v : r)
                    for (const float z : b) sum += albedo[k++] * static_cast<double>(x * y * v * z);
        const double error = static_cast<double>(energy::albedoFromFit(static_cast<float>(sum)) - energy::singleScatterAlbedo(m, w));
        squares += error * error;
        CHECK(std::fabs(error) < 0.03);
    }
    CHECK(std::sqrt(squares / static_cast<double>(points.size())) < 0.003);
}

TEST_CASE("White furnace with compensation is 1 within two percent", "[energy][furnace]") {
    for (const auto &[m, w] : randomPoints(120, 21)) {
        const float lossO = 1 - energy::singleScatterAlbedo(m, w);
        const float lossMean = 1 - energy::averageAlbedo(m);
        const double multiple = diffuseMean(
            [&, t = m](const Vec3 &wi) {
                return energy::multipleLobe(lossO, 1 - energy::singleScatterAlbedo(t, wi), lossMean, wi.z) / (wi.z * kInvPi);
            },
            1024);
        CHECK(tables::albedo(m, w, 4096) + multiple == Approx(1).margin(0.02));
    }
}

TEST_CASE("A furnace of the BSDF: off loses, compensation and walk do not", "[energy][furnace]") {
    for (const MicroTransform &m : charted())
        for (const double theta : {0.0, 50.0, 80.0}) {
            const Vec3 wo = direction(theta, 35);
            const double off = sampledAlbedo(metal(m, Multiscatter::Off), wo, 16384);
            CHECK(off == Approx(tables::albedo(m, wo, 4096)).margin(0.01));
            CHECK(sampledAlbedo(metal(m, Multiscatter::Compensation), wo, 16384) == Approx(1).margin(0.02));
            CHECK(sampledAlbedo(metal(m, Multiscatter::Walk), wo, 4096) == Approx(1).margin(1e-5));
        }
}

TEST_CASE("Coloured metals: compensation follows the walk's saturation", "[energy]") {
    for (const MicroTransform &m : charted())
        for (const float f : {0.5F, 0.8F})
            for (const double theta : {0.0, 50.0, 75.0}) {
                const Vec3 wo = direction(theta, 35);
                // Facets of one reflectance at all angles, so that this is about the series alone.
                double walk = 0;
                constexpr int kWalks = 20000;
                walk::Random random(7);
                for (int i = 0; i < kWalks; ++i) {
                    const Vec2 first(random.uniform(), random.uniform());
                    walk += std::pow(f, walk::sample(m, wo, walk::UniformReflector{}, first, random).bounces) / kWalks;
                }
                const double single = tables::albedo(m, wo, 2048);
                const double color = static_cast<double>(energy::multipleColor(Vec3(f), energy::averageAlbedo(m)).x);
                INFO("f " << f << ", theta " << theta << ", Mean " << energy::averageAlbedo(m));
                CHECK(single * static_cast<double>(f) + (1 - single) * color ==
                      Approx(walk).epsilon(energy::averageAlbedo(m) > 0.35F ? 0.08 : 0.2));
            }
}

TEST_CASE("Compensation is reciprocal, its samples follow its pdf", "[energy]") {
    walk::Random random(3);
    for (const MicroTransform &m : charted()) {
        const Bsdf bsdf = metal(m, Multiscatter::Compensation, Vec3(0.9F, 0.6F, 0.3F));
        for (int i = 0; i < 30; ++i) {
            const Vec3 a = squareToCosineHemisphere({random.uniform(), random.uniform()});
            const Vec3 b = squareToCosineHemisphere({random.uniform(), random.uniform()});
            const Vec3 ab = ScatteringPoint(bsdf, a).evaluate(b).fCos / b.z;
            const Vec3 ba = ScatteringPoint(bsdf, b).evaluate(a).fCos / a.z;
            for (int c = 0; c < 3; ++c) CHECK(ab[c] == Approx(ba[c]).epsilon(2e-3));
        }
    }
    // The mean of g / pdf over samples is the integral of g over all directions that sampling reaches: the hemisphere.
    for (const MicroTransform &m : {microTransformFromAlpha(1, 1), microTransform(1, 2, 0, 1)}) {
        const Bsdf bsdf = metal(m, Multiscatter::Compensation);
        const ScatteringPoint point(bsdf, direction(40, 10));
        double sum = 0;
        constexpr std::uint32_t kSamples = 1U << 16;
        for (std::uint32_t i = 0; i < kSamples; ++i)
            if (const auto s = point.sample(sobol2(i, 1), sobol1(i, 2))) sum += static_cast<double>(s->wi.z / s->pdf) / kSamples;
        CHECK(sum == Approx(3.14159265).epsilon(0.01));
    }
}

TEST_CASE("A walk's sample has the density of its part, and walks of one facet have one that integrates to their share", "[energy][walk]") {
    for (const float eta : {0.0F, 1.5F, 1 / 1.5F}) // 0: a metal
        for (const MicroTransform &m : charted())
            for (const double theta : {0.0, 60.0, 89.0, 95.0}) {
                Bsdf bsdf = metal(m, Multiscatter::Walk);
                if (eta > 0) {
                    bsdf.type = BsdfType::Dielectric;
                    bsdf.eta = eta;
                }
                const ScatteringPoint point(bsdf, direction(theta, 15));
                int missed = 0;
                for (std::uint32_t i = 0; i < 300; ++i) {
                    const auto s = point.sample(sobol2(i, 1), sobol1(i, 2), hash(i));
                    if (!s) {
                        ++missed;
                        continue;
                    }
                    const auto [single, multiple] = point.evaluateParts(s->wi, walk::numbersOf(hash(i, 7)));
                    const bool known = s->pdf == single.pdf || s->pdf == multiple.pdf;
                    if (!(multiple.pdf > 0) || !known || !isFinite(single.fCos + multiple.fCos)) FAIL("eta " << eta << ", theta " << theta);
                }
                CHECK(missed == 0);
            }
    for (const MicroTransform &m : {microTransformFromAlpha(1, 1), microTransform(0.7F, 0.5F, 0, 0.6F)}) {
        const Bsdf bsdf = metal(m, Multiscatter::Walk);
        const Vec3 wo = direction(50, 15);
        const ScatteringPoint point(bsdf, wo);
        const double share = diffuseMean([&](const Vec3 &wi) { return point.evaluateParts(wi).single.pdf / (wi.z * kInvPi); }, 1U << 14);
        CHECK(share == Approx(energy::singleScatterAlbedo(m, wo)).margin(0.01));
    }
}

TEST_CASE("A lamp lights a walk alike with and without multiple importance sampling", "[energy][walk]") {
    // A lamp as a cap of directions. By light samples of the whole alone; and by light and sampled directions, each part weighed.
    constexpr std::uint32_t kSamples = 1U << 17;
    const auto heuristic = [](double a, double b) { return a * a / (a * a + b * b); };
    for (const float alpha : {0.08F, 0.5F})
        for (const double halfAngle : {5.0, 30.0})
            for (const bool glass : {false, true}) {
                Bsdf bsdf = metal(microTransformFromAlpha(alpha, 2 * alpha), Multiscatter::Walk);
                if (glass) {
                    bsdf.type = BsdfType::Dielectric;
                    bsdf.eta = 1.5F;
                }
                const ScatteringPoint point(bsdf, direction(50, 20));
                const Vec3 centre = direction(35, 200); // beside the mirrored direction
                const double cosine = std::cos(radians(halfAngle));
                const double lightPdf = 1 / (2 * 3.14159265358979 * (1 - cosine));
                const Frame frame = smoothFrameFromNormal(centre);
                double sums[2] = {0, 0};
                double squares[2] = {0, 0};
                for (std::uint32_t i = 0; i < kSamples; ++i) {
                    const Vec2 u = sobol2(i, 5);
                    const float z = 1 - u.x * static_cast<float>(1 - cosine);
                    const Vec3 wi = frame.fromLocal(Vec3(std::sqrt(std::max(0.0F, 1 - z * z)) * unitCircle(u.y), z));
                    const auto [single, multiple] = point.evaluateParts(wi, walk::numbersOf(hash(i, 11)));
                    const double lightAlone = static_cast<double>(single.fCos.x + multiple.fCos.x) / lightPdf;
                    double both = 0;
                    for (const BsdfEval &part : {single, multiple})
                        both += static_cast<double>(part.fCos.x) / lightPdf * heuristic(lightPdf, static_cast<double>(part.pdf));
                    const auto s = point.sample(sobol2(i, 6), sobol1(i, 7), hash(i, 13));
                    if (s && static_cast<double>(glm::dot(s->wi, centre)) > cosine)
                        both += static_cast<double>(s->weight.x) * heuristic(static_cast<double>(s->pdf), lightPdf);
                    for (const auto &[k, x] : {std::pair(0, lightAlone), std::pair(1, both)}) {
                        sums[k] += x / kSamples;
                        squares[k] += x * x / kSamples;
                    }
                }
                const double error = std::sqrt((squares[0] - sums[0] * sums[0] + squares[1] - sums[1] * sums[1]) / kSamples);
                INFO("alpha " << alpha << ", lamp " << halfAngle << (glass ? ", glass" : "") << ": " << sums[0] << " and " << sums[1]);
                CHECK(std::fabs(sums[0] - sums[1]) < 4 * error);
                CHECK(squares[1] - sums[1] * sums[1] < squares[0] - sums[0] * sums[0]);
            }
}

TEST_CASE("What is done about multiple scattering where a material leaves it open", "[energy]") {
    CHECK(chooseMultiscatter(microTransformFromAlpha(0.05F, 0.05F), false) == Multiscatter::Off);
    CHECK(chooseMultiscatter(microTransformFromAlpha(0.059F, 0.059F), true) == Multiscatter::Off);
    CHECK(chooseMultiscatter(microTransformFromAlpha(0.5F, 0.02F, 1), false) == Multiscatter::Compensation);
    CHECK(chooseMultiscatter(microTransformFromAlpha(0.5F, 0.5F), true) == Multiscatter::Walk);
    CHECK(chooseMultiscatter(microTransform(10, 0, 0, 10, 0.3F, 0), false) == Multiscatter::Walk);
    // Off never costs more than it may.
    for (const auto &[m, w] : randomPoints(200, 17))
        if (chooseMultiscatter(m, false) == Multiscatter::Off) CHECK(tables::averageAlbedo(m, 8192) > 1 - kNegligibleLoss - 5e-3);
}

TEST_CASE("Mean reflectance of metals", "[fresnel]") {
    const Vec3 eta(0.15557F, 1.0152F, 2.9114F);
    const Vec3 k(3.6024F, 6.6273F, 3.0893F);
    Vec3 truth(0);
    constexpr int kNodes = 4000;
    for (int i = 0; i < kNodes; ++i) {
        const float c = (static_cast<float>(i) + 0.5F) / kNodes;
        truth += 2 * c / kNodes * fresnel::conductor(c, eta, k);
    }
    const Vec3 found = fresnel::diffuseMean([&](float c) { return fresnel::conductor(c, eta, k); });
    for (int c = 0; c < 3; ++c) CHECK(found[c] == Approx(truth[c]).margin(4e-3));
}
