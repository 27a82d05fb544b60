/// What is asked of every kind in the table of BSDFs.

#include "bsdf_checks.h"
#include "catch.h"

using namespace taut;
using namespace taut::test;

namespace {

/// White and lossless, but for what its facets lose to each other.
Bsdf whiteOf(BsdfType type) {
    MaterialValues white;
    white.coatEscape = coatEscape(white.ior);
    white.conductorEta = Vec3(0.2F);
    white.conductorK = Vec3(4);
    Bsdf bsdf;
    bsdf.type = type;
    bsdf.eta = white.ior;
    bsdf.micro = microTransform(3, 1, 0, 2);
    onBsdf(type, [&](auto kind) { decltype(kind)::Class::make(white, bsdf); });
    return bsdf;
}

} // namespace

TEST_CASE("Kinds of BSDF stand in the table at their number, and find their class", "[bsdf]") {
    for (std::size_t i = 0; i < kBsdfs.size(); ++i) {
        const auto type = static_cast<BsdfType>(i);
        CHECK(bsdfInfo(type).type == type);
        CHECK(onBsdf(type, [](auto kind) { return decltype(kind)::kInfo.type; }) == type);
        CHECK(!bsdfInfo(type).name.empty());
        CHECK((bsdfInfo(type).transmits || !bsdfInfo(type).refracts));
    }
}

TEST_CASE("Every kind of BSDF: samples have their density and weight, densities integrate to what is sampled, and no light is made",
          "[bsdf]") {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    for (const BsdfInfo &info : kBsdfs) {
        const Bsdf bsdf = whiteOf(info.type);
        for (const double theta : {0.0, 50.0, 80.0}) {
            INFO(info.name << ", theta " << theta);
            const ScatteringPoint point(bsdf, direction(theta, 25));
            constexpr int kSamples = 100000;
            int sampled = 0;
            int wrong = 0;
            double scattered = 0;
            for (int i = 0; i < kSamples; ++i) {
                const auto s = point.sample({uniform(random), uniform(random)}, uniform(random));
                if (!s) continue;
                ++sampled;
                const BsdfEval e = point.evaluate(s->wi);
                const bool agrees = s->pdf == e.pdf && s->pdf > 0 && s->weight == e.fCos * (1 / e.pdf) && s->transmitted == (s->wi.z < 0) &&
                                    (info.transmits || !s->transmitted);
                wrong += agrees ? 0 : 1;
                scattered += static_cast<double>(s->weight.x * s->etaScale);
            }
            CHECK(wrong == 0);
            CHECK(scattered / kSamples < 1.003);
            CHECK(scattered / kSamples > 0.5);
            CHECK(integrateSphere([&](const Vec3 &w) { return point.evaluate(w).pdf; }, 500) ==
                  Approx(static_cast<double>(sampled) / kSamples).margin(6e-3));
            const float eta2 = info.refracts ? bsdf.eta * bsdf.eta : 1;
            CHECK(integrateSphere([&](const Vec3 &w) { return point.evaluate(w).fCos.x * (w.z < 0 ? eta2 : 1); }, 500) ==
                  Approx(scattered / kSamples).margin(6e-3));
        }
    }
}
