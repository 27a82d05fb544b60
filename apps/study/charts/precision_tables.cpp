/// Tables of docs/precision.md and docs/stability.md: relative errors per quantity and band of alpha, where the published forms fail, and
/// the error of M packed in halves.

#include "study/charts.h"
#include "study/measures/timing.h"
#include "study/microsurface/stability.h"
#include "study/text.h"

#include "taut/microsurface/packed_transform.h"

namespace taut::chart {

namespace {

using precision::Formulation;
using precision::Place;
using precision::Summary;

struct Band {
    const char *name;
    float low, high;
};
constexpr Band kBands[] = {{"1e-2 .. 10", 0.009F, 11}, {"1e-3 .. 1e-2", 0.0009F, 0.009F}, {"1e-4 .. 1e-3", 0.00009F, 0.0009F}};

Table errorTable(const std::vector<Formulation> &all) {
    Table table{"errors",
                "Relative errors by quantity and alpha",
                {"formulation", "quantity", "alpha", "median", "median in the lobe", "99 %", "greatest", "not finite",
                 "worst at alpha, stretch, shear, theta"},
                {}};
    for (const Formulation &formulation : all)
        for (std::size_t q = 0; q < precision::kQuantities; ++q)
            for (const Band &band : kBands) {
                const auto inBand = [&](const Place &at) { return at.alpha > band.low && at.alpha <= band.high; };
                const Summary s = summarize(formulation, q, inBand);
                const Summary lobe = summarize(formulation, q, [&](const Place &at) { return inBand(at) && at.inLobe; });
                table.rows.push_back(
                    {formulation.name, precision::kQuantityNames[q], band.name, printed("%.1e", s.median), printed("%.1e", lobe.median),
                     printed("%.1e", s.most), printed("%.1e", s.greatest), printed("%zu of %zu", s.notFinite, s.count),
                     printed("%.0e, %.0e, %.0f, %.3f", static_cast<double>(s.worst.alpha), static_cast<double>(s.worst.stretch),
                             static_cast<double>(s.worst.shear), static_cast<double>(s.worst.theta))});
            }
    return table;
}

Table failingTable(const std::vector<Formulation> &all) {
    Table table{
        "failing",
        "Off by more than 1e-3 (one parameter at a time, the others at alpha 1, stretch 1, shear 0, theta below 85; theta at any alpha)",
        {"formulation", "quantity", "alpha up to", "shear from", "stretch ratio from", "theta from"},
        {}};
    const auto cell = [](float x, float nowhere) { return x == nowhere ? std::string("-") : digits(static_cast<double>(x)); };
    for (const Formulation &formulation : all)
        for (std::size_t q = 0; q < precision::kQuantities; ++q) {
            const precision::FailingRegion r = failingRegion(formulation, q, kFails);
            table.rows.push_back({formulation.name, precision::kQuantityNames[q], cell(r.alphaUpTo, 0), cell(r.shearFrom, kInfinity),
                                  cell(r.stretchRatioFrom, kInfinity), cell(r.thetaFrom, kInfinity)});
        }
    return table;
}

float throughHalf(float x) {
    return glm::unpackHalf1x16(packHalf(x));
}

/// Ways to hold (a, b, d) in three halves.
constexpr std::pair<const char *, MicroTransform (*)(const MicroTransform &)> kPackings[] = {
    {"a/2, b/2, d/2 (chosen)", [](const MicroTransform &m) { return unpackTransform(packUpright(m)); }},
    {"a, b, d", [](const MicroTransform &m) { return canonicalTransform(throughHalf(m.a), throughHalf(m.b), throughHalf(m.d)); }},
    {"a/2, b/d, d/2",
     [](const MicroTransform &m) {
         const float d = 2 * throughHalf(m.d / 2);
         return canonicalTransform(2 * throughHalf(m.a / 2), d * throughHalf(m.b * m.inverseD), d);
     }},
    {"log a, b/d, log d",
     [](const MicroTransform &m) {
         const float d = std::exp2(throughHalf(std::log2(m.d)));
         return canonicalTransform(std::exp2(throughHalf(std::log2(m.a))), d * throughHalf(m.b * m.inverseD), d);
     }},
    {"sqrt a, b/d, sqrt d",
     [](const MicroTransform &m) {
         const float d = sqr(throughHalf(std::sqrt(m.d)));
         return canonicalTransform(sqr(throughHalf(std::sqrt(m.a))), d * throughHalf(m.b * m.inverseD), d);
     }},
    {"alphaMax, alphaMin, phi", [](const MicroTransform &m) {
         const EquivalentAlpha e = equivalentAlpha(m);
         return microTransformFromAlpha(throughHalf(e.max), throughHalf(e.min), throughHalf(e.phi));
     }}};

Table packingTable() {
    Table table{"packing",
                "M in three halves: relative error of the roughness in the worst direction, alpha 1e-4 .. 10, stretch 1e-3 .. 1e3",
                {"stored", "shear", "median", "greatest"},
                {}};
    for (const auto &[name, throughHalves] : kPackings)
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
                errors.push_back(roughnessError(throughHalves(m), m));
            }
            table.rows.push_back({name, printed("%.0f", static_cast<double>(shear)), printed("%.5f", quartilesOf(errors).median),
                                  printed("%.5f", *std::max_element(errors.begin(), errors.end()))});
        }
    return table;
}

} // namespace

std::vector<Table> precisionTables() {
    const std::vector<Formulation> all = precision::sweep();
    return {errorTable(all), failingTable(all), packingTable(), stabilityTable(all)};
}

} // namespace taut::chart
