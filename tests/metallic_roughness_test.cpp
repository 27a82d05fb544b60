/// glTF's material against its own formulas, in double precision, and against the rule that no light is made.

#include "assets.h"
#include "bsdf_checks.h"
#include "catch.h"
#include "render_fixtures.h"

#include "taut/base/sobol.h"
#include "taut/scene/load_scene.h"

#include <deque>
#include <numeric>

using namespace taut;
using namespace taut::test;

namespace {

MaterialValues paint(float base, float metallic) {
    MaterialValues values;
    values.color = Vec3(base);
    values.metallic = metallic;
    return values;
}

Bsdf bsdfWith(const MaterialValues &values, const MicroTransform &m, Multiscatter multiscatter = Multiscatter::Off) {
    Bsdf bsdf;
    bsdf.type = BsdfType::MetallicRoughness;
    bsdf.micro = m;
    bsdf.coatMicro = microTransformFromAlpha(0.04F, 0.04F);
    bsdf.multiscatter = multiscatter;
    bsdf.eta = values.ior;
    MetallicRoughnessBsdf::make(values, bsdf);
    return bsdf;
}

/// Everything that comes back or passes, as energy, in the first channel.
double albedoOf(const Bsdf &bsdf, const Vec3 &wo, int nodes = 400) {
    const ScatteringPoint point(bsdf, wo);
    const double eta2 = bsdf.refracts ? static_cast<double>(bsdf.eta * bsdf.eta) : 1.0;
    const auto light = [&](const Vec3 &w) { return static_cast<double>(point.evaluate(w).fCos.x) * (w.z < 0 ? eta2 : 1.0); };
    return bsdf.tint == Vec3(0) ? integrate(light, false, nodes) : integrateSphere(light, nodes);
}

/// By sampling, for walks.
double sampledAlbedo(const Bsdf &bsdf, const Vec3 &wo, int samples) {
    const ScatteringPoint point(bsdf, wo);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const auto s = point.sample({uniform(random), uniform(random)}, uniform(random), hash(static_cast<std::uint32_t>(i), 3));
        if (s) sum += static_cast<double>(s->weight.x);
    }
    return sum / samples;
}

/// glTF 2.0, appendix B.3, for one channel: GGX with height-correlated masking, written as there.
double appendixB3(double c, double metallic, double alpha, double f0, double f90, const DVec3 &v, const DVec3 &l) {
    const DVec3 h = glm::normalize(v + l);
    const double vh = glm::dot(v, h);
    const double a2 = alpha * alpha;
    const double d = a2 / (3.141592653589793 * std::pow(h.z * h.z * (a2 - 1) + 1, 2));
    const double visibility = 0.5 / (l.z * std::sqrt(v.z * v.z * (1 - a2) + a2) + v.z * std::sqrt(l.z * l.z * (1 - a2) + a2));
    const double schlick = std::pow(1 - vh, 5);
    const double f = f0 + (f90 - f0) * schlick;
    const double dielectric = (1 - f) * c / 3.141592653589793 + f * d * visibility;
    const double metal = (c + (1 - c) * schlick) * d * visibility;
    return glm::mix(dielectric, metal, metallic);
}

const MicroTransform kSurfaces[] = {microTransformFromAlpha(0.04F, 0.04F), microTransformFromAlpha(0.3F, 0.3F),
                                    microTransformFromAlpha(1, 1), microTransform(2, 1, 0, 3)};

/// One of every kind of layer. No vector: GCC 14 takes its growth, written in line, for an overflow.
std::deque<std::pair<const char *, MaterialValues>> layered(float base) {
    std::deque<std::pair<const char *, MaterialValues>> all;
    const auto add = [&](const char *name, auto change) {
        MaterialValues values = paint(base, 0);
        change(values);
        all.emplace_back(name, values);
    };
    add("plain", [](MaterialValues &) {});
    add("half metal", [](MaterialValues &v) { v.metallic = 0.5F; });
    add("specular", [](MaterialValues &v) {
        v.specular = 0.7F;
        v.specularColor = Vec3(40, 20, 1);
    });
    add("mirror ior", [](MaterialValues &v) { v.ior = 0; });
    add("thin", [](MaterialValues &v) { v.transmission = 1; });
    add("half thin", [](MaterialValues &v) { v.transmission = 0.5F; });
    add("volume", [](MaterialValues &v) {
        v.transmission = 0.8F;
        v.thinWalled = false;
    });
    add("coat", [](MaterialValues &v) { v.clearcoat = 1; });
    add("sheen", [](MaterialValues &v) {
        v.sheenColor = Vec3(1, 0.5F, 0);
        v.sheenAlpha = 0.25F;
    });
    add("film", [](MaterialValues &v) { v.film = {1, 1.8F, 300}; });
    add("metal film", [](MaterialValues &v) {
        v.metallic = 1;
        v.film = {0.8F, 1.3F, 550};
    });
    add("everything", [](MaterialValues &v) {
        v.metallic = 0.3F;
        v.transmission = 0.5F;
        v.clearcoat = 0.6F;
        v.sheenColor = Vec3(0.3F);
        v.sheenAlpha = 0.5F;
        v.film = {0.5F, 1.4F, 420};
    });
    return all;
}

} // namespace

TEST_CASE("Metallic-roughness is the formula of glTF's appendix B.3, F0 and F90 by KHR_materials_ior and _specular", "[bsdf][gltf]") {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    for (const float metallic : {0.0F, 0.4F, 1.0F})
        for (const float alpha : {0.09F, 0.25F, 1.0F})
            for (const float specular : {1.0F, 0.3F}) {
                MaterialValues values = paint(0.5F, metallic);
                values.ior = 1.33F;
                values.specular = specular;
                values.specularColor = Vec3(0.8F);
                const Bsdf bsdf = bsdfWith(values, microTransformFromAlpha(alpha, alpha));
                const double f0 = 0.8 * std::pow(0.33 / 2.33, 2) * static_cast<double>(specular);
                for (int i = 0; i < 100; ++i) {
                    const Vec3 wo = squareToCosineHemisphere({uniform(random), uniform(random)});
                    const Vec3 wi = squareToCosineHemisphere({uniform(random), uniform(random)});
                    if (wo.z < 0.3F || wi.z < 0.05F) continue; // further down the diffuse part gives way
                    INFO("metallic " << metallic << ", alpha " << alpha << ", wo.z " << wo.z << ", wi.z " << wi.z);
                    CHECK(ScatteringPoint(bsdf, wo).evaluate(wi).fCos.x / wi.z ==
                          Approx(appendixB3(0.5, metallic, alpha, f0, specular, DVec3(wo), DVec3(wi))).epsilon(1e-3));
                }
            }
}

TEST_CASE("No roughness, mix or layer of metallic-roughness makes light", "[bsdf][gltf]") {
    for (std::size_t i = 0; i < std::size(kSurfaces); ++i)
        for (const auto &[name, values] : layered(1))
            for (const double theta : {0.0, 45.0, 70.0, 85.0}) {
                INFO(name << ", surface " << i << ", theta " << theta);
                const Vec3 wo = direction(theta, 25);
                const int nodes = i == 0 ? 500 : 160;
                CHECK(albedoOf(bsdfWith(values, kSurfaces[i]), wo, nodes) < 1.004);
                if (values.metallic == 0) continue;
                CHECK(albedoOf(bsdfWith(values, kSurfaces[i], Multiscatter::Compensation), wo, nodes) < 1.016); // the energy table's error
            }
}

TEST_CASE("White metal of any roughness sends back all the light, by compensation and by the walk", "[bsdf][gltf]") {
    for (const float alpha : {0.25F, 0.5F, 1.0F})
        for (const double theta : {0.0, 40.0, 70.0}) {
            INFO("alpha " << alpha << ", theta " << theta);
            const Vec3 wo = direction(theta, 10);
            const MicroTransform m = microTransformFromAlpha(alpha, alpha);
            CHECK(albedoOf(bsdfWith(paint(1, 1), m, Multiscatter::Compensation), wo) == Approx(1).margin(0.01));
            CHECK(sampledAlbedo(bsdfWith(paint(1, 1), m, Multiscatter::Walk), wo, 20000) == Approx(1).margin(1e-4));
        }
}

TEST_CASE("Metallic-roughness with a walk: samples and evaluation agree in the lobes beside it", "[bsdf][gltf]") {
    MaterialValues values = paint(0.8F, 0.5F);
    values.transmission = 0.5F;
    values.clearcoat = 0.5F;
    const Bsdf walk = bsdfWith(values, microTransformFromAlpha(0.7F, 0.7F), Multiscatter::Walk);
    const Vec3 wo = direction(50, 10);
    const ScatteringPoint point(walk, wo);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    double estimated = 0;
    constexpr int kSamples = 400000;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
        const Vec3 up = squareToCosineHemisphere({uniform(random), uniform(random)});
        for (const Vec3 &wi : {up, Vec3(up.x, up.y, -up.z)})
            estimated += static_cast<double>(point.evaluate(wi, walk::numbersOf(hash(i, 7))).fCos.x / (kInvPi * std::fabs(wi.z)));
    }
    CHECK(sampledAlbedo(walk, wo, kSamples) == Approx(estimated / kSamples).margin(6e-3));
}

TEST_CASE("Metallic-roughness: the sampler follows its density in every layer", "[bsdf][chi2][gltf]") {
    const auto all = layered(0.7F);
    const double level = sidak(0.01, static_cast<int>(2 * 2 * all.size()));
    std::uint32_t seed = 900;
    for (const MicroTransform &m : {microTransformFromAlpha(0.3F, 0.3F), microTransform(2, 1, 0, 3)})
        for (const auto &[name, values] : all)
            for (const double theta : {20.0, 75.0}) {
                INFO(name << ", a " << m.a << ", theta " << theta);
                CHECK(chiSquaredOf(bsdfWith(values, m), direction(theta, 25), seed++) > level);
            }
}

TEST_CASE("Transmission takes the place of the diffuse part, and goes straight on where the wall is thin", "[bsdf][gltf]") {
    MaterialValues values = paint(0.6F, 0);
    values.transmission = 0.25F;
    const MicroTransform m = microTransformFromAlpha(0.2F, 0.2F);
    const Vec3 wo = direction(30, 0);
    const Bsdf quarter = bsdfWith(values, m);
    const Bsdf opaque = bsdfWith(paint(0.6F, 0), m);
    values.transmission = 1;
    const Bsdf clear = bsdfWith(values, m);
    const ScatteringPoint part(quarter, wo);
    const ScatteringPoint none(opaque, wo);
    const ScatteringPoint all(clear, wo);
    // The lobe beyond is that of reflection, mirrored: (1 - F) c / F of it.
    const Vec3 wi = direction(35, 170);
    const Vec3 beyond(wi.x, wi.y, -wi.z);
    const double vh = std::sqrt((1 + static_cast<double>(glm::dot(wo, wi))) / 2);
    const double f = 0.04 + 0.96 * std::pow(1 - vh, 5);
    CHECK(all.evaluate(beyond).fCos.x / all.evaluate(wi).fCos.x == Approx(0.6 * (1 - f) / f).epsilon(1e-3));
    CHECK(part.evaluate(beyond).fCos.x == Approx(0.25F * all.evaluate(beyond).fCos.x).epsilon(1e-4));
    CHECK(part.evaluate(wi).fCos.x == Approx(glm::mix(none.evaluate(wi).fCos.x, all.evaluate(wi).fCos.x, 0.25F)).epsilon(1e-4));
    // A volume bends: the lobe beyond is about the refracted ray.
    values.thinWalled = false;
    const Bsdf glass = bsdfWith(values, microTransformFromAlpha(0.01F, 0.01F));
    const auto s = ScatteringPoint(glass, wo).sample({0.4F, 1e-3F}, 0.9F);
    REQUIRE(s);
    CHECK(s->transmitted);
    CHECK(glm::length(Vec2(s->wi)) == Approx(0.5 / 1.5).margin(2e-3));
    CHECK(s->etaScale == Approx(2.25));
}

TEST_CASE("Case base-colour: a facing plate of base colour 0.5 shows 0.517 in a furnace", "[bsdf][gltf][cases]") {
    const auto path = caseFile("base-colour/plate.toml");
    if (!path) return;
    Warnings warnings;
    const std::vector<float> image = renderImage(loadScene(*path, {}, warnings), 1, 64);
    CHECK(std::accumulate(image.begin(), image.end(), 0.0) / static_cast<double>(image.size()) > 0.1);
    CHECK(image[4 * (16 * 32 + 16)] == Approx(0.517).margin(0.005));
}
