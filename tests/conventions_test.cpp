/// Other renderers' parameters: there and back, against their own formulas written down again, and what is clipped.

#include "taut/microsurface/conventions.h"

#include "catch.h"

#include <iostream>
#include <random>

using namespace taut;

namespace {

/// Slope tensor of a gloss: what two of them must share to be the same. Entries xx, xy, yy.
DVec3 slopeTensor(const EquivalentAlpha &a) {
    const double c = std::cos(static_cast<double>(a.phi));
    const double s = std::sin(static_cast<double>(a.phi));
    const double x = sqr(static_cast<double>(a.max));
    const double y = sqr(static_cast<double>(a.min));
    return {x * c * c + y * s * s, (x - y) * c * s, x * s * s + y * c * c};
}

/// Without a rotation input the tangent carries phi.
EquivalentAlpha withTangent(Convention convention, EquivalentAlpha back, float phi) {
    if (conventionInfo(convention).rotation.empty()) back.phi = phi;
    return back;
}

} // namespace

TEST_CASE("conventions: every one comes back within 1e-5 inside its limits", "[conventions]") {
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const ConventionInfo &info : kConventions) {
        const double largest = std::min(1.0, static_cast<double>(info.largestAlpha));
        const double leastRatio = std::max(1e-4, static_cast<double>(info.leastRatio));
        double worst = 0;
        double worstTensor = 0;
        for (int i = 0; i < 20000; ++i) {
            const double max = largest * std::pow(1e-4, unit(generator));
            const double min = max * std::pow(leastRatio * (1 + 1e-6), unit(generator));
            const EquivalentAlpha alpha{static_cast<float>(max), static_cast<float>(min),
                                        static_cast<float>(3.14159265 * (unit(generator) - 0.5))};
            const ConventionValues values = toConvention(info.convention, alpha);
            REQUIRE_FALSE(values.clipped);
            const EquivalentAlpha back = withTangent(info.convention, fromConvention(info.convention, values), alpha.phi);
            worst = std::max(
                {worst, std::fabs(static_cast<double>(back.max - alpha.max)), std::fabs(static_cast<double>(back.min - alpha.min))});
            const DVec3 difference = slopeTensor(back) - slopeTensor(alpha);
            worstTensor = std::max({worstTensor, std::fabs(difference.x), std::fabs(difference.y), std::fabs(difference.z)});
        }
        std::cout << "convention " << info.name << ": worst round trip of alpha " << worst << ", of the slope tensor " << worstTensor
                  << std::endl;
        CHECK(worst <= 1e-5);
        CHECK(worstTensor <= 1e-5);
    }
}

TEST_CASE("conventions: phi stays in (-pi/2, pi/2] and Blender's turn in [0, 1/2)", "[conventions]") {
    for (const ConventionInfo &info : kConventions)
        for (int i = -12; i <= 12; ++i) {
            const float phi = 0.1309F * static_cast<float>(i); // up to a little over pi / 2
            const ConventionValues values = toConvention(info.convention, {0.4F, 0.1F, phi});
            const EquivalentAlpha back = fromConvention(info.convention, values);
            CHECK(back.phi > -1.5708F);
            CHECK(back.phi <= 1.5709F);
            if (info.convention != Convention::Blender && info.convention != Convention::BlenderAnisotropic) continue;
            CHECK(values.rotation >= 0);
            CHECK(values.rotation < 0.5F);
        }
}

TEST_CASE("conventions: known values", "[conventions]") {
    // alphaMax 0.4, alphaMin 0.1: q = 1/4, g = 0.2.
    const EquivalentAlpha alpha{0.4F, 0.1F, 0.5F};
    const auto check = [&](Convention convention, float roughness, float anisotropy, float rotation) {
        const ConventionValues v = toConvention(convention, alpha);
        INFO(conventionInfo(convention).name);
        CHECK(v.roughness == Approx(roughness));
        CHECK(v.anisotropy == Approx(anisotropy));
        CHECK(v.rotation == Approx(rotation));
        CHECK_FALSE(v.clipped);
    };
    check(Convention::Alpha, 0.4F, 0.1F, 0);
    check(Convention::Blender, 0.4472136F, 0.8333333F, 0.07957747F);
    check(Convention::BlenderAnisotropic, 0.4472136F, -0.5F, 0.07957747F);
    check(Convention::OpenPbr, 0.5399493F, 0.75F, 0); // (0.085)^(1/4)
    check(Convention::MaterialX, 0.4472136F, 0.75F, 0.5F);
    check(Convention::Khr, 0.3162278F, 0.5773503F, 0.5F);
    for (std::size_t i = 0; i < kConventions.size(); ++i) CHECK(static_cast<std::size_t>(kConventions[i].convention) == i);
    // A positive anisotropy of Blender's Anisotropic BSDF is rougher across the tangent.
    const EquivalentAlpha across = fromConvention(Convention::BlenderAnisotropic, {0.5F, 0.5F, 0, false});
    CHECK(across.max == Approx(0.5F));
    CHECK(across.min == Approx(0.125F));
    CHECK(across.phi == Approx(1.5707963F));
}

TEST_CASE("conventions: what lies outside is clipped and said so", "[conventions]") {
    const auto clipped = [](Convention convention, float max, float min) {
        const ConventionValues v = toConvention(convention, {max, min, 0.3F});
        CHECK(v.clipped);
        return fromConvention(convention, v);
    };
    const EquivalentAlpha thin = clipped(Convention::Blender, 0.5F, 0.01F); // q = 0.02 < 0.1
    CHECK(thin.max == Approx(0.5F));
    CHECK(thin.min == Approx(0.05F));
    const EquivalentAlpha rough = clipped(Convention::Khr, 3.0F, 0.2F);
    CHECK(rough.max == Approx(1.0F));
    CHECK(rough.min == Approx(0.2F));
    CHECK(clipped(Convention::BlenderAnisotropic, 2.0F, 1.5F).min == Approx(1.0F));
    CHECK(clipped(Convention::MaterialX, 0.5F, 0.005F).min == Approx(0.01F));
    const EquivalentAlpha open = clipped(Convention::OpenPbr, 2.0F, 1.0F); // keeps its ratio
    CHECK(open.min / open.max == Approx(0.5F));
    CHECK(sqr(open.max) + sqr(open.min) == Approx(2.0F));
    CHECK_FALSE(toConvention(Convention::Alpha, {30.0F, 1e-4F, 0}).clipped);
    CHECK_FALSE(toConvention(Convention::OpenPbr, {1.2F, 0.3F, 0}).clipped);
    CHECK_FALSE(toConvention(Convention::Khr, {1.0F, 1.0F, 0}).clipped);
    CHECK(toConvention(Convention::Khr, {1.0F, 1.0F, 0}).anisotropy == 0);
    for (const ConventionInfo &info : kConventions) { // an isotropic one whose alphas are a rounding apart
        const ConventionValues v = toConvention(info.convention, {0.2F, std::nextafter(0.2F, 1.0F), 0});
        CHECK(std::isfinite(v.anisotropy));
        CHECK_FALSE(v.clipped);
    }
}
