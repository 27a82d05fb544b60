/// taut_precision: how many digits float leaves to each formulation of the microsurface. Prints the tables of docs/precision.md: relative
/// errors per quantity and band of alpha, where the published forms fail, and the error of M packed in halves; then the table of
/// docs/stability.md.

#include "study/stability.h"

#include "taut/microsurface/packed_transform.h"
#include "study/precision.h"

#include <cstdio>

namespace {

using namespace taut;
using precision::Formulation;
using precision::Place;
using precision::Summary;

struct Band {
    const char *name;
    float low, high;
};
constexpr Band kBands[] = {{"1e-2 .. 10", 0.009F, 11}, {"1e-3 .. 1e-2", 0.0009F, 0.009F}, {"1e-4 .. 1e-3", 0.00009F, 0.0009F}};

void printErrors(const std::vector<Formulation> &all) {
    std::printf("| formulation | quantity | alpha | median | median in the lobe | 99 %% | greatest | not finite | worst at alpha, stretch, "
                "shear, theta |\n"
                "|---|---|---|---|---|---|---|---|---|\n");
    for (const Formulation &formulation : all)
        for (std::size_t q = 0; q < precision::kQuantities; ++q)
            for (const Band &band : kBands) {
                const auto inBand = [&](const Place &at) { return at.alpha > band.low && at.alpha <= band.high; };
                const Summary s = summarize(formulation, q, inBand);
                const Summary lobe = summarize(formulation, q, [&](const Place &at) { return inBand(at) && at.inLobe; });
                std::printf("| %s | %s | %s | %.1e | %.1e | %.1e | %.1e | %zu of %zu | %.0e, %.0e, %.0f, %.3f |\n", formulation.name,
                            precision::kQuantityNames[q], band.name, s.median, lobe.median, s.most, s.greatest, s.notFinite, s.count,
                            static_cast<double>(s.worst.alpha), static_cast<double>(s.worst.stretch), static_cast<double>(s.worst.shear),
                            static_cast<double>(s.worst.theta));
            }
}

void printFailing(const std::vector<Formulation> &all) {
    std::printf("\nOff by more than 1e-3 (one parameter at a time, the others at alpha 1, stretch 1, shear 0, theta below 85; theta at any "
                "alpha):\n\n"
                "| formulation | quantity | alpha up to | shear from | stretch ratio from | theta from |\n|---|---|---|---|---|---|\n");
    for (const Formulation &formulation : all)
        for (std::size_t q = 0; q < precision::kQuantities; ++q) {
            const precision::FailingRegion r = failingRegion(formulation, q, 1e-3);
            const auto cell = [](float x, bool nowhere) {
                char text[32];
                std::snprintf(text, sizeof(text), nowhere ? "-" : "%.3g", static_cast<double>(x));
                return std::string(text);
            };
            std::printf("| %s | %s | %s | %s | %s | %s |\n", formulation.name, precision::kQuantityNames[q],
                        cell(r.alphaUpTo, r.alphaUpTo == 0).c_str(), cell(r.shearFrom, r.shearFrom == kInfinity).c_str(),
                        cell(r.stretchRatioFrom, r.stretchRatioFrom == kInfinity).c_str(),
                        cell(r.thetaFrom, r.thetaFrom == kInfinity).c_str());
        }
}

/// Ways to hold (a, b, d) in three halves.
struct Packing {
    const char *name;
    MicroTransform (*throughHalves)(const MicroTransform &);
};

float throughHalf(float x) {
    return glm::unpackHalf1x16(packHalf(x));
}
MicroTransform asIs(const MicroTransform &m) {
    return canonicalTransform(throughHalf(m.a), throughHalf(m.b), throughHalf(m.d));
}
MicroTransform shear(const MicroTransform &m) {
    const float d = 2 * throughHalf(m.d / 2);
    return canonicalTransform(2 * throughHalf(m.a / 2), d * throughHalf(m.b * m.inverseD), d);
}
MicroTransform logarithms(const MicroTransform &m) {
    const float d = std::exp2(throughHalf(std::log2(m.d)));
    return canonicalTransform(std::exp2(throughHalf(std::log2(m.a))), d * throughHalf(m.b * m.inverseD), d);
}
MicroTransform roots(const MicroTransform &m) {
    const float d = sqr(throughHalf(std::sqrt(m.d)));
    return canonicalTransform(sqr(throughHalf(std::sqrt(m.a))), d * throughHalf(m.b * m.inverseD), d);
}
MicroTransform alphas(const MicroTransform &m) {
    const EquivalentAlpha e = equivalentAlpha(m);
    return microTransformFromAlpha(throughHalf(e.max), throughHalf(e.min), throughHalf(e.phi));
}
MicroTransform chosen(const MicroTransform &m) {
    return unpackTransform(packUpright(m));
}
constexpr Packing kPackings[] = {{"a/2, b/2, d/2 (chosen)", chosen}, {"a, b, d", asIs},
                                 {"a/2, b/d, d/2", shear},           {"log a, b/d, log d", logarithms},
                                 {"sqrt a, b/d, sqrt d", roots},     {"alphaMax, alphaMin, phi", alphas}};

void printPacking() {
    std::printf("\nM in three halves: relative error of the roughness in the worst direction, alpha 1e-4 .. 10, stretch 1e-3 .. 1e3:\n\n"
                "| stored | shear | median | greatest |\n|---|---|---|---|\n");
    for (const Packing &packing : kPackings)
        for (const float shear : {0.0F, 1.0F, 10.0F, 100.0F, 1000.0F}) {
            std::vector<double> errors;
            std::mt19937 random(1);
            std::uniform_real_distribution<float> unit(0, 1);
            for (int i = 0; i < 20000; ++i) {
                const float alpha = std::pow(10.0F, -4 + 5 * unit(random));
                const float stretch = std::pow(10.0F, -3 + 6 * unit(random));
                // shear = |b| / a, what the direction of the long axis hangs on
                const float a = stretch / alpha;
                const MicroTransform m = microTransform(a, (i % 2 == 0 ? shear : -shear) * a, 0, 1 / alpha);
                errors.push_back(roughnessError(packing.throughHalves(m), m));
            }
            std::sort(errors.begin(), errors.end());
            std::printf("| %s | %.0f | %.5f | %.5f |\n", packing.name, static_cast<double>(shear), errors[errors.size() / 2],
                        errors.back());
        }
}

} // namespace

int main() {
    const std::vector<Formulation> all = precision::sweep();
    printErrors(all);
    printFailing(all);
    printPacking();
    std::printf("\n%s", chart::stabilityHeading().c_str());
    for (const chart::StabilityRow &row : chart::stabilityRows(all)) std::printf("%s", lineOf(row).c_str());
    return 0;
}
