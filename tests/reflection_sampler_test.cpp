/// The reflection sampler against closed forms, quadrature in double that knows nothing of the cone, and chi-squared.

#include "catch.h"
#include "direction_bins.h"

#include "taut/bsdf/bsdf.h"
#include "taut/microsurface/reflection_sampler.h"

using namespace taut;
using namespace taut::test;

namespace {

struct Named {
    const char *name;
    MicroTransform m;
};

/// The cases in which caps waste most, and kinds of M that differ: skewed, anisotropic and turned, squashed, det < 0.
std::vector<Named> rough() {
    return {{"[1 2; 0 1]", microTransform(1, 2, 0, 1)},
            {"alpha (1, 0.1), turned", microTransformFromAlpha(1, 0.1F, 0.8F)},
            {"alpha (2, 2)", microTransformFromAlpha(2, 2)},
            {"alpha (5, 0.3)", microTransformFromAlpha(5, 0.3F)},
            {"a deformation", microTransform(0.7F, -1.3F, 0.4F, 2.1F)},
            {"det < 0", microTransform(1, 2, 1.5F, -0.5F)}};
}

std::vector<Named> extreme() {
    return {{"alpha 1e-4", microTransformFromAlpha(1e-4F, 1e-4F)},
            {"alpha (1e-4, 0.3)", microTransformFromAlpha(1e-4F, 0.3F, 0.3F)},
            {"alpha (10, 1e-4)", microTransformFromAlpha(10, 1e-4F, 0.4F)},
            {"alpha 0.1", microTransformFromAlpha(0.1F, 0.1F)},
            {"alpha 10", microTransformFromAlpha(10, 10)},
            {"[1 10; 0 1]", microTransform(1, 10, 0, 1)},
            {"[1 1000; 0 1]", microTransform(1, 1000, 0, 1)},
            {"[0.01 10; 0 3]", microTransform(0.01F, 10, 0, 3)}};
}

/// The share of visible normals that reflect above the horizon, in double, by standard slopes s in polar coordinates around 0:
/// |M^-T s - tan(wo)| < 1/wo.z bounds the radius by a quadratic, the radial integral of (1 + t.s) / (1 + |s|^2)^2 is closed.
double reflectedShareBySlopes(const MicroTransform &m, const Vec3 &wo, int n = 200000) {
    const double z = wo.z;
    const double ia = 1.0 / m.a;
    const double id = 1.0 / m.d;
    const double skew = -m.b * ia * id;
    const double x = (wo.x * ia + wo.y * skew) / z;
    const double y = wo.y * id / z;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double psi = 2 * kPiD * (i + 0.5) / n;
        const double c = std::cos(psi);
        const double s = std::sin(psi);
        const double u = ia * c;
        const double v = skew * c + id * s;
        const double normal = u * u + v * v; // e^T N e
        const double t = x * c + y * s;
        const double root = std::sqrt(t * t + normal);
        const double radius = t > 0 ? (t + root) / normal : 1 / (root - t);
        const double square = radius * radius;
        sum += 0.5 * square / (1 + square) + 0.5 * t * (std::atan(radius) - radius / (1 + square));
    }
    const double oz = 1 / std::sqrt(1 + x * x + y * y);
    return sum * 2 * kPiD / n * 2 * oz / (kPiD * (1 + oz));
}

/// G2 D cos / pdf for F = 1, height-correlated.
float weight(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, const ReflectionSampler &sampler) {
    return ggx::visibility(wo.z, ggx::stretchedLength(m, wo), wi.z, ggx::stretchedLength(m, wi), true) * wi.z / sampler.pdfScale();
}

struct Bend {
    double azimuth = 1;     ///< exponent on the azimuth of every sample
    bool neverFlip = false; ///< leaves the mirror image out
};

double chiSquaredOf(const MicroTransform &m, const Vec3 &wo, Uniform &uniform, Bend bend = {}) {
    const ReflectionSampler sampler(m, wo);
    const auto draw = [&] {
        const Vec2 u = uniform.pair();
        return bend.neverFlip ? sampler.sample(u, 1) : sampler.sample(u);
    };
    return test::chiSquaredOf(
        draw, [&](const Vec3 &w) { return sampler.pdf(w); }, std::fmax(0.0F, -wo.z), 1, bend.azimuth);
}

} // namespace

TEST_CASE("Normal incidence has the closed form", "[reflection_sampler]") {
    // z uniform in [(l-1)/(l+1), 1] at every azimuth integrates to a share of 1 / sqrt((1 + ax^2) (1 + ay^2)).
    for (const Vec2 alpha : {Vec2(1, 1), Vec2(1, 0.1F), Vec2(5, 0.3F), Vec2(0.01F, 0.02F)}) {
        const ReflectionSampler sampler(microTransformFromAlpha(alpha.x, alpha.y, 0.6F), Vec3(0, 0, 1));
        CHECK(sampler.samplesCone());
        CHECK(sampler.reflectedShare() == Approx(1 / std::sqrt((1 + alpha.x * alpha.x) * (1 + alpha.y * alpha.y))).epsilon(3e-6));
    }
    // The trace of M^-1 M^-T is 6, its determinant 1: 1 / sqrt(8), 64.64 % of visible normals lost.
    const MicroTransform sheared = microTransform(1, 2, 0, 1);
    CHECK(ReflectionSampler(sheared, Vec3(0, 0, 1)).reflectedShare() == Approx(0.35355339).epsilon(3e-6));

    // The azimuth about the principal axes in standard space is atan(sqrt((1 + ax^2) / (1 + ay^2)) tan(2 pi u)), in local space its
    // tangent is ay / ax times that: the share of samples within 45 degrees of the x axis.
    const ReflectionSampler sampler(microTransformFromAlpha(2, 0.5F), Vec3(0, 0, 1));
    Uniform uniform(1);
    int inside = 0;
    constexpr int kSamples = 1000000;
    for (int i = 0; i < kSamples; ++i) {
        const auto wi = sampler.sample(uniform.pair());
        inside += wi && std::fabs(wi->y) < std::fabs(wi->x) ? 1 : 0;
    }
    CHECK(inside / static_cast<double>(kSamples) == Approx(2 / kPiD * std::atan(2 / 0.5 * std::sqrt(1.25 / 5))).margin(2e-3));
}

TEST_CASE("The density is normalised: the share of visible normals in closed form equals the quadrature over slopes",
          "[reflection_sampler]") {
    std::vector<Named> all = rough();
    const auto more = extreme();
    all.insert(all.end(), more.begin(), more.end());
    for (const auto &[name, m] : all)
        for (const double theta : {0.0, 10.0, 30.0, 60.0, 80.0, 89.0, 89.99})
            for (const double phi : {0.0, 25.0, 90.0, 200.0}) {
                INFO(name << ", theta " << theta << ", phi " << phi);
                const Vec3 wo = direction(theta, phi);
                const ReflectionSampler sampler(m, wo);
                REQUIRE(sampler.samplesCone());
                // From above by construction: a cone too small would lose directions. Below 1 by the rejected share.
                const double normal = reflectedShareBySlopes(m, wo, 20000) / static_cast<double>(sampler.reflectedShare());
                CHECK(normal <= 1 + 3e-5);
                CHECK(normal >= 1 - 2e-3);
            }
}

TEST_CASE("Reflections above the horizon are all that is sampled", "[reflection_sampler]") {
    Uniform uniform(2);
    constexpr int kSamples = 100000;
    for (const auto &[name, m] : rough())
        for (const double theta : {0.0, 30.0, 60.0, 80.0, 89.9}) {
            INFO(name << ", theta " << theta);
            const Vec3 wo = direction(theta, 25);
            const ReflectionSampler sampler(m, wo);
            int lost = 0;
            int lostByCap = 0;
            for (int i = 0; i < kSamples; ++i) {
                const Vec2 u = uniform.pair();
                lost += sampler.sample(u) ? 0 : 1;
                const Vec3 wm = ggx::sampleVisibleNormal(m, wo, u);
                lostByCap += 2 * glm::dot(wo, wm) * wm.z - wo.z > 0 ? 0 : 1;
            }
            CHECK(lost <= 0.002 * kSamples); // aim of the design: 2 %
            const double share = static_cast<double>(sampler.reflectedShare());
            const double deviation = std::sqrt(share * (1 - share) / kSamples);
            CHECK(1 - lostByCap / static_cast<double>(kSamples) == Approx(share).margin(5 * deviation + 1e-3 * share));
        }
}

TEST_CASE("Samples follow the density", "[reflection_sampler][chi2]") {
    auto cases = rough();
    cases.push_back({"alpha 0.1", microTransformFromAlpha(0.1F, 0.1F)});
    const std::vector<double> thetas{0, 30, 80, 89.9};
    const double level = test::sidak(0.01, static_cast<int>(cases.size() * thetas.size()) + 2);
    Uniform uniform(3);
    for (const auto &[name, m] : cases)
        for (const double theta : thetas) {
            INFO(name << ", theta " << theta);
            CHECK(chiSquaredOf(m, direction(theta, 25), uniform) > level);
        }
    for (const std::size_t i : {0U, 1U}) { // caps, from below
        INFO(cases[i].name << ", theta 130");
        CHECK(chiSquaredOf(cases[i].m, direction(130, 25), uniform) > level);
    }
    // The harness notices an azimuth that is wrong by two per cent, and a sampler that leaves the mirror image out.
    CHECK(chiSquaredOf(cases[0].m, direction(30, 25), uniform, {.azimuth = 1.02}) < 1e-6);
    CHECK(chiSquaredOf(cases[0].m, direction(30, 25), uniform, {.neverFlip = true}) < 1e-6);
}

TEST_CASE("The density integrates to one over directions", "[reflection_sampler]") {
    for (const auto &[name, m] : rough())
        for (const double theta : {0.0, 30.0, 80.0, 110.0}) {
            INFO(name << ", theta " << theta);
            const ReflectionSampler sampler(m, direction(theta, 25));
            const auto pdf = [&](const Vec3 &w) { return sampler.pdf(w); };
            const double low = std::max(0.0, -std::cos(radians(theta)));
            CHECK(integrate(pdf, low, 1, 0, 2 * kPiD, 400) == Approx(1).epsilon(2e-3));
        }
}

TEST_CASE("The estimated albedo agrees with quadrature, weights are bounded by the reflected share", "[reflection_sampler]") {
    Uniform uniform(4);
    constexpr int kSamples = 200000;
    for (const auto &[name, m] : rough())
        for (const double theta : {0.0, 60.0, 80.0}) {
            INFO(name << ", theta " << theta);
            const Vec3 wo = direction(theta, 25);
            const ReflectionSampler sampler(m, wo);
            Bsdf bsdf;
            bsdf.type = BsdfType::Conductor;
            bsdf.f0 = Vec3(1);
            bsdf.micro = m;
            const ScatteringPoint point(bsdf, wo);
            const double truth = integrate([&](const Vec3 &w) { return point.evaluate(w).fCos.x; }, 0, 1, 0, 2 * kPiD, 300);
            double sum = 0;
            double squares = 0;
            float greatest = 0;
            for (int i = 0; i < kSamples; ++i)
                if (const auto wi = sampler.sample(uniform.pair())) {
                    const float w = weight(m, wo, *wi, sampler);
                    greatest = std::fmax(greatest, w);
                    sum += static_cast<double>(w);
                    squares += static_cast<double>(w) * static_cast<double>(w);
                }
            const double mean = sum / kSamples;
            CHECK(mean == Approx(truth).margin(4.5 * std::sqrt((squares / kSamples - mean * mean) / kSamples) + 5e-4 * truth));
            CHECK(greatest <= sampler.reflectedShare() * 1.00001F);
        }
}

TEST_CASE("Extreme surfaces and grazing views stay finite, unit and above the horizon", "[reflection_sampler]") {
    Uniform uniform(5);
    std::vector<Named> all = extreme();
    for (int i = 0; i < 200; ++i) {
        const auto power = [&](float low, float high) { return std::pow(10.0F, low + (high - low) * uniform.number()); };
        const float a = power(-1, 4);
        const float d = power(-1, 4);
        all.push_back({"random", microTransform(a, (2 * uniform.number() - 1) * power(-1, 3), 0, d)});
    }
    constexpr int kSamples = 1000;
    int lost = 0;
    int total = 0;
    for (const auto &[name, m] : all)
        for (const double theta : {0.0, 1e-3, 45.0, 89.0, 89.99, 89.99999, 90.0, 179.0}) {
            INFO(name << " [" << m.a << " " << m.b << "; 0 " << m.d << "], theta " << theta);
            const Vec3 wo = direction(theta, static_cast<double>(uniform.number()) * 360);
            const ReflectionSampler sampler(m, wo);
            CHECK(std::isfinite(sampler.pdfScale()));
            CHECK(sampler.pdfScale() > 0);
            bool sound = true;
            for (int i = 0; i < kSamples; ++i) {
                // The ends of the unit square among them.
                const Vec2 u = i < 4 ? Vec2(i % 2 == 0 ? 0 : kOneMinusEpsilon, i < 2 ? 0 : kOneMinusEpsilon) : uniform.pair();
                const auto wi = sampler.sample(u);
                if (wo.z > 1e-4F) {
                    ++total;
                    lost += wi ? 0 : 1;
                }
                if (!wi) continue;
                sound = sound && isFinite(*wi) && std::fabs(glm::length(*wi) - 1) < 1e-5F && wi->z > 0;
                const float pdf = sampler.pdf(*wi);
                sound = sound && std::isfinite(pdf) && pdf >= 0;
                if (wo.z > 0) {
                    const float w = weight(m, wo, *wi, sampler);
                    sound = sound && std::isfinite(w) && w >= 0 && w <= 1.001F;
                }
            }
            CHECK(sound);
        }
    CHECK(lost <= 1e-3 * total);
}

TEST_CASE("A leaning M and views from below fall back to caps with their density", "[reflection_sampler]") {
    Uniform uniform(6);
    const MicroTransform leaning = microTransform(2, 0.5F, 0, 1.5F, 0.8F, -0.4F);
    const MicroTransform sheared = microTransform(1, 2, 0, 1);
    for (const auto &[m, theta] : {std::pair(leaning, 0.0), {leaning, 50.0}, {sheared, 95.0}, {sheared, 130.0}}) {
        INFO("theta " << theta);
        const Vec3 wo = direction(theta, 25);
        const ReflectionSampler sampler(m, wo);
        CHECK_FALSE(sampler.samplesCone());
        constexpr int kSamples = 200000;
        int kept = 0;
        for (int i = 0; i < kSamples; ++i) kept += sampler.sample(uniform.pair()) ? 1 : 0;
        const double share = integrate([&, s = &sampler](const Vec3 &w) { return s->pdf(w); }, std::fmax(0.0F, -wo.z), 1, 0, 2 * kPiD, 300);
        CHECK(kept / static_cast<double>(kSamples) == Approx(share).margin(5e-3));
    }
}
