/// What must hold for every M, tried on 60 random ones of every kind; and the forms that render against published ones.

#include "catch.h"
#include "direction_bins.h"
#include "random_transforms.h"

#include "study/microsurface/precision.h"
#include "taut/microsurface/packed_transform.h"

using namespace taut;
using namespace taut::test;

namespace {

template <class T> Vector3<T> directionOf(Uniform &uniform, double least, double greatest) {
    const T z = static_cast<T>(least + (greatest - least) * static_cast<double>(uniform.number()));
    const T phi = 2 * std::numbers::pi_v<T> * T(uniform.number());
    const T r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// BRDF from what an estimator multiplies: pdf times weight over the cosine.
template <class Formulation, class V> auto brdf(const Formulation &f, const V &wo, const V &wi) {
    return f.reflectionPdf(wo, wi) * f.weight(wo, wi) / wi.z;
}

} // namespace

TEMPLATE_TEST_CASE("Closed values in float and double", "[microsurface]", float, double) {
    using T = TestType;
    using V = Vector3<T>;
    const double digits = 2e-7; // the values are given to seven
    const auto sheared = microTransform<T>(10, 20, 0, 10);
    CHECK(double(ggx::distribution(sheared, V(T(0.1), 0, 1))) == Approx(0.9019664).epsilon(digits));
    CHECK(double(ggx::distribution(sheared, V(0, T(0.1), 1))) == Approx(8.1176979).epsilon(digits));
    CHECK(double(ggx::distribution(sheared, V(T(0.1), T(-0.1), 1))) == Approx(3.6796623).epsilon(digits));
    const V normal(0, 0, 1);
    CHECK(double(ggx::distribution(microTransform<T>(10, 0, 0, 30), normal)) == Approx(95.4930).epsilon(1e-6));
    CHECK(double(ggx::distribution(sheared, normal)) == Approx(31.8310).epsilon(1e-6));
    CHECK(double(ggx::distribution(microTransform<T>(30, 0, 0, 10), normal)) == Approx(95.4930).epsilon(1e-6));
    CHECK(double(ggx::masking(sheared, V(T(0.6), 0, T(0.8)))) == Approx(0.9985977).epsilon(digits));
    CHECK(double(ggx::masking(sheared, V(0, T(0.6), T(0.8)))) == Approx(0.9930659).epsilon(digits));
    const auto leaning = microTransform<T>(2, 0.5, 0, 1.5, 0.8, -0.4);
    CHECK(0.8 / double(ggx::stretchedLength(leaning, V(T(0.6), 0, T(0.8)))) == Approx(0.9624671).epsilon(digits));
    CHECK(0.8 / double(ggx::stretchedLength(leaning, V(T(-0.6), 0, T(0.8)))) == Approx(0.7496341).epsilon(digits));
}

TEMPLATE_TEST_CASE("Single-scatter albedo at normal incidence by quadrature, in float and double", "[microsurface]", float, double) {
    using T = TestType;
    const Vector3<T> wo(0, 0, 1);
    const auto albedo = [&](double alpha) {
        const reference::Stable<T> stable(microTransformFromAlpha<T>(T(alpha), T(alpha)));
        // Isotropic: rings, with nodes crowded at the pole.
        double sum = 0;
        constexpr int kNodes = 20000;
        for (int i = 0; i < kNodes; ++i) {
            const double s = (i + 0.5) / kNodes;
            const double z = 1 - s * s * s;
            const Vector3<T> wi(T(std::sqrt(1 - z * z)), 0, T(z));
            sum += 2 * kPiD * 3 * s * s / kNodes * double(stable.reflectionPdf(wo, wi) * stable.weight(wo, wi));
        }
        return sum;
    };
    const double digits = std::is_same_v<T, float> ? 1e-6 : 1e-7;
    CHECK(albedo(1) == Approx(1 - std::log(2.0)).epsilon(digits));
    CHECK(albedo(0.5) == Approx(0.6878485).epsilon(digits));
    CHECK(albedo(0.25) == Approx(0.9158124).epsilon(digits));
    CHECK(albedo(0.1) == Approx(0.9883041).epsilon(digits));
}

TEST_CASE("Normalisation: the normals of 60 random transforms add up to the macro-normal", "[microsurface][properties]") {
    Uniform uniform(1);
    for (const auto &m : randomTransforms<double>(60)) {
        INFO("M = [" << m.a << " " << m.b << " " << m.p << "; 0 " << m.d << " " << m.q << "]");
        const DVec3 v = directionOf<double>(uniform, -1, 1);
        const double sum = integrateHemisphere([&](const DVec3 &w) { return ggx::distribution(m, w) * glm::dot(w, v); }, {m.p, m.q, 1});
        CHECK(sum == Approx(v.z).margin(1e-5));
    }
}

TEST_CASE("Visible area of 60 random transforms, from above and below", "[microsurface][properties]") {
    Uniform uniform(2);
    for (const auto &m : randomTransforms<double>(60)) {
        const DVec3 wo = directionOf<double>(uniform, -0.9, 1);
        INFO("M = [" << m.a << " " << m.b << " " << m.p << "; 0 " << m.d << " " << m.q << "], wo.z " << wo.z);
        const double sum =
            integrateHemisphere([&](const DVec3 &w) { return ggx::distribution(m, w) * std::max(0.0, glm::dot(w, wo)); }, {m.p, m.q, 1});
        const double area = ggx::visibleArea(m, wo, ggx::stretchedLength(m, wo));
        CHECK(sum == Approx(area / 2).margin(1e-5));
        // Where wo is above the horizon G1 is the share of it that is seen.
        if (wo.z > 0) CHECK(ggx::masking(m, wo) * sum == Approx(wo.z).margin(1e-5));
    }
}

TEMPLATE_TEST_CASE("Reciprocity of 60 random transforms", "[microsurface][properties]", float, double) {
    using T = TestType;
    const double digits = std::is_same_v<T, float> ? 2e-6 : 1e-13;
    Uniform uniform(3);
    for (const auto &m : randomTransforms<T>(60)) {
        const reference::Stable<T> stable(m);
        for (int i = 0; i < 50; ++i) {
            const auto wo = directionOf<T>(uniform, 1e-3, 1);
            const auto wi = directionOf<T>(uniform, 1e-3, 1);
            CHECK(double(brdf(stable, wo, wi)) == Approx(double(brdf(stable, wi, wo))).epsilon(digits));
        }
    }
}

TEST_CASE("M and M R_z are the same microsurface, for 60 random blocks", "[microsurface][properties]") {
    Uniform uniform(4);
    const auto entry = [&] { return 6 * static_cast<double>(uniform.number()) - 3; };
    for (int i = 0; i < 60; ++i) {
        const double a = entry();
        const double b = entry();
        const double c = entry();
        const double d = entry();
        const double p = i % 3 == 0 ? entry() : 0;
        const double angle = entry();
        const double cosine = std::cos(angle);
        const double sine = std::sin(angle);
        const double mirror = i % 2 == 0 ? 1 : -1; // a mirror image of the standard surface is itself, too
        const auto m = microTransform<double>(a, b, c, d, p);
        const auto turned = microTransform<double>(a * cosine + b * sine, mirror * (b * cosine - a * sine), c * cosine + d * sine,
                                                   mirror * (d * cosine - c * sine), p);
        const reference::Stable<double> one(m);
        const reference::Stable<double> other(turned);
        for (int j = 0; j < 20; ++j) {
            const auto wo = directionOf<double>(uniform, 0.01, 1);
            const auto wi = directionOf<double>(uniform, 0.01, 1);
            CHECK(one.D(wo, wi) == Approx(other.D(wo, wi)).epsilon(1e-10));
            CHECK(one.G1(wo) == Approx(other.G1(wo)).epsilon(1e-10));
            CHECK(one.weight(wo, wi) == Approx(other.weight(wo, wi)).epsilon(1e-10));
        }
    }
}

TEMPLATE_TEST_CASE("Published formulations agree with the stable ones on 60 random transforms", "[microsurface][properties]", double,
                   long double) {
    using T = TestType;
    const double digits = 1e-11;
    Uniform uniform(5);
    for (const auto &m : randomTransforms<T>(60, false)) {
        const reference::Stable<T> stable(m);
        for (int i = 0; i < 20; ++i) {
            const auto wo = directionOf<T>(uniform, 0.02, 1);
            const auto wi = directionOf<T>(uniform, 0.02, 1);
            const auto agree = [&](const auto &other) {
                CHECK(double(other.D(wo, wi)) == Approx(double(stable.D(wo, wi))).epsilon(digits));
                CHECK(double(other.G1(wo)) == Approx(double(stable.G1(wo))).epsilon(digits));
                CHECK(double(other.reflectionPdf(wo, wi)) == Approx(double(stable.reflectionPdf(wo, wi))).epsilon(digits));
                CHECK(double(other.weight(wo, wi)) == Approx(double(stable.weight(wo, wi))).epsilon(digits));
            };
            agree(reference::Walter<T>(equivalentAlpha(m)));
            agree(reference::CosineSquared<T>(equivalentAlpha(m)));
            agree(reference::JacobianChain<T>(m));
            agree(reference::Tensor<T>(m));
            // The chain's density of all normals is D cos.
            const auto wm = glm::normalize(wo + wi);
            CHECK(double(reference::JacobianChain<T>(m).normalPdf(wm)) == Approx(double(wm.z * stable.D(wo, wi))).epsilon(digits));
        }
    }
}

TEST_CASE("The chain of Jacobians is the derivative of its maps, for 60 random transforms", "[microsurface][properties]") {
    Uniform uniform(6);
    const double step = 1e-5;
    // Solid angle that a map spreads two small steps around w over.
    const auto spread = [&](const auto &map, const DVec3 &w) {
        const DVec3 s = glm::normalize(glm::cross(w, std::fabs(w.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
        const DVec3 t = glm::cross(w, s);
        const auto along = [&](const DVec3 &d) {
            return (map(glm::normalize(w + step * d)) - map(glm::normalize(w - step * d))) / (2 * step);
        };
        return glm::length(glm::cross(along(s), along(t)));
    };
    for (const auto &m : randomTransforms<double>(60, false)) {
        const reference::JacobianChain<double> chain(m);
        const DVec3 wo = directionOf<double>(uniform, 0.1, 1);
        const DVec3 wm = glm::normalize(wo + directionOf<double>(uniform, 0.1, 1));
        const auto toStandard = [&](const DVec3 &w) { return glm::normalize(m.transposed(w)); };
        CHECK(chain.stretchJacobian(toStandard(wm), wm) == Approx(spread(toStandard, wm)).epsilon(1e-6));
        const auto reflect = [&](const DVec3 &w) { return 2 * glm::dot(wo, w) * w - wo; };
        CHECK(chain.reflectionJacobian(wm, reflect(wm)) == Approx(1 / spread(reflect, wm)).epsilon(1e-6));
        for (const double eta : {1.5, 1 / 1.5}) {
            const auto refract = [&](const DVec3 &w) {
                const double c = glm::dot(wo, w);
                return w * (c / eta - std::sqrt(1 - (1 - c * c) / (eta * eta))) - wo / eta;
            };
            const double cosine = glm::dot(wo, wm);
            if (1 - (1 - cosine * cosine) / (eta * eta) < 0.01) continue;
            CHECK(chain.refractionJacobian(wo, wm, refract(wm), eta) == Approx(1 / spread(refract, wm)).epsilon(1e-5));
        }
    }
}

TEST_CASE("Float keeps its digits over the whole sweep, where published forms lose theirs", "[microsurface][precision]") {
    const auto all = precision::sweep();
    const auto any = [](const precision::Place &) { return true; };
    const auto from = [](float alpha) { return [alpha](const precision::Place &at) { return at.alpha > 0.99F * alpha; }; };
    for (std::size_t q = 0; q < precision::kQuantities; ++q) {
        INFO(precision::kQuantityNames[q]);
        const auto &stable = all[precision::kStable];
        REQUIRE(stable.samples.size() > 45000);
        CHECK(summarize(stable, q, any).notFinite == 0);
        CHECK(summarize(stable, q, from(1e-2F)).median < 1e-6);
        CHECK(summarize(stable, q, from(1e-3F)).greatest < 1e-3); // the goal
        CHECK(summarize(stable, q, any).greatest < 3e-5);         // what it is
    }
    const std::size_t d = 0;
    CHECK(summarize(all[precision::kWalter], d, any).greatest > 1);
    CHECK(failingRegion(all[precision::kWalter], d, 1e-3).alphaUpTo >= 1e-3F);
    CHECK(summarize(all[precision::kCosineSquared], d, any).notFinite > 0);
    CHECK(failingRegion(all[precision::kCosineSquared], d, 1e-3).alphaUpTo >= 1e-3F);
    CHECK(failingRegion(all[precision::kTensor], d, 1e-3).shearFrom <= 1000);
    CHECK(summarize(all[precision::kChain], 2, any).greatest > 1); // its pdf, near the horizon
}

TEST_CASE("M in storage: floats come back as they were, halves within their bound", "[microsurface][packed]") {
    double most = 0;
    Uniform uniform(8);
    const auto power = [&](float low, float high) { return std::pow(10.0F, low + (high - low) * uniform.number()); };
    for (int i = 0; i < 5000; ++i) {
        const float alpha = power(-4, 1);
        const float shear = (i % 2 == 0 ? 1.0F : -1.0F) * power(-3, 3);
        const MicroTransform m = microTransform(power(-3, 3) / alpha, shear / alpha, 0, 1 / alpha, power(-2, 1), -power(-2, 1));
        INFO("M = [" << m.a << " " << m.b << " " << m.p << "; 0 " << m.d << " " << m.q << "]");
        const MicroTransform stored = loadTransform(storeLeaning(m));
        CHECK((stored.a == m.a && stored.b == m.b && stored.d == m.d && stored.p == m.p && stored.q == m.q));
        CHECK(stored.det == Approx(m.det).epsilon(3e-7));
        CHECK(loadTransform(storeUpright(m)).upright());

        const MicroTransform halves = unpackTransform(packLeaning(m));
        const bool denormal = std::fmin(m.a, m.d) < 1.3e-4F; // out of what alpha and stretch need
        const double bound = 0x1p-11 * (1 + std::fabs(double(m.b)) / double(m.a)) + (denormal ? 0.01 : 1e-5);
        CHECK(roughnessError(halves, m) <= bound);
        CHECK(halves.p == Approx(m.p).epsilon(0x1p-11));
        CHECK(halves.q == Approx(m.q).epsilon(0x1p-11));
        if (std::fabs(m.b) <= m.a) most = std::max(most, roughnessError(halves, m));
    }
    CHECK(most < 1e-3);
    // Any bits are a transform.
    for (std::uint32_t bits = 0; bits < 0x10000; bits += 7) {
        const auto half = static_cast<std::uint16_t>(bits);
        const MicroTransform m = unpackTransform(PackedLeaning{half, half, static_cast<std::uint16_t>(half * 31), half, half});
        if (!std::isfinite(m.a + m.b + m.d + m.p + m.q + m.inverseA + m.inverseD + m.det) || !(m.a > 0) || !(m.d > 0))
            FAIL("bits " << bits);
    }
}

TEST_CASE("How far roughness is off is what a direct search over directions finds", "[microsurface][packed]") {
    Uniform uniform(9);
    for (int i = 0; i < 20; ++i) {
        const auto number = [&] { return 0.5F + uniform.number(); };
        const MicroTransform m = microTransform(number(), number(), 0, number());
        const MicroTransform other = microTransform(m.a * (0.9F + 0.2F * uniform.number()), m.b + 0.1F * uniform.number(), 0, m.d);
        double most = 0;
        for (int j = 0; j < 3600; ++j) {
            const Vec3 w = direction(90, 0.05 * j);
            most =
                std::max(most, std::fabs(double(glm::length(Vec2(other.transposed(w)))) / double(glm::length(Vec2(m.transposed(w)))) - 1));
        }
        CHECK(roughnessError(other, m) == Approx(most).epsilon(1e-3));
    }
}
