/// Formulations of the microsurface (reference.h): nanoseconds against digits, in float and in double, and maps of where float fails.

#include "study/charts.h"
#include "study/measures/timing.h"
#include "study/microsurface/precision.h"
#include "study/text.h"

#include "taut/base/parallel.h"

#include <map>

namespace taut::chart {

namespace {

using precision::Formulation;
using precision::Place;

/// What is timed, by its place in a sweep.
constexpr std::size_t kTimed[] = {precision::kStable,        precision::kTextbook, precision::kWalter,
                                  precision::kCosineSquared, precision::kChain,    precision::kTensor};
constexpr const char *kQuantityTitles[precision::kQuantities] = {"D, normal distribution", "G1, masking",
                                                                 "pdf of reflected visible normals", "weight G2/G1"};

/// Hits with transforms of their own, all of it in the first two caches. A renderer's directions are floats and so is what it makes of
/// the values: an evaluation in double widens them and rounds its result.
struct Hits {
    static constexpr std::size_t kCount = 1024;
    std::vector<MicroTransform> m;
    std::vector<Vec3> wo, wi;
    std::vector<float> out = std::vector<float>(kCount);
    Hits() {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
        const auto direction = [&] {
            const float z = 0.05F + 0.95F * uniform(random);
            return Vec3(std::sqrt(1 - z * z) * unitCircle(uniform(random)), z);
        };
        for (std::size_t i = 0; i < kCount; ++i) {
            const float x = 1 / (0.05F + 0.95F * uniform(random));
            m.push_back(microTransform(x, (2 * uniform(random) - 1) * x, 0, 1 / (0.05F + 0.95F * uniform(random))));
            wo.push_back(direction());
            wi.push_back(direction());
        }
    }
};

struct Row {
    std::size_t formulation;
    bool isDouble;
    std::size_t quantity;
};

constexpr int kRepeats = 64;

/// Share by which times of these short loops are off in either direction: so much they differ with where a compiler puts the same code
/// (five alignments of loops and functions tried), which rounds of one binary do not show.
constexpr double kPlacement = 0.01;
Measured withPlacement(Measured time) {
    time.spread = std::hypot(time.spread, kPlacement * time.value);
    return time;
}

/// The rows of one formulation, prepared from transforms in T: a loop a quantity.
template <class T, class Make>
void addRows(Hits &hits, std::size_t formulation, const Make &make, std::vector<Row> &rows, std::vector<std::function<void()>> &runs) {
    using F = decltype(make(BasicMicroTransform<T>(), BasicEquivalentAlpha<T>()));
    std::vector<F> prepared;
    for (const MicroTransform &hit : hits.m) {
        const auto m = canonicalTransform<T>(hit.a, hit.b, hit.d);
        prepared.push_back(make(m, equivalentAlpha(m)));
    }
    const auto add = [&](std::size_t quantity, auto evaluate) {
        rows.push_back({formulation, std::is_same_v<T, double>, quantity});
        runs.push_back([&hits, prepared, evaluate] {
            for (int repeat = 0; repeat < kRepeats; ++repeat)
                for (std::size_t i = 0; i < hits.kCount; ++i)
                    hits.out[i] = static_cast<float>(evaluate(prepared[i], Vector3<T>(hits.wo[i]), Vector3<T>(hits.wi[i])));
        });
    };
    using V = Vector3<T>;
    add(0, [](const F &f, const V &wo, const V &wi) { return f.D(wo, wi); });
    add(1, [](const F &f, const V &wo, const V &) { return f.G1(wo); });
    add(2, [](const F &f, const V &wo, const V &wi) { return f.reflectionPdf(wo, wi); });
    add(3, [](const F &f, const V &wo, const V &wi) { return f.weight(wo, wi); });
}

/// Rendering evaluates the stable forms in the type of MicroTransform.
bool rendersWith(std::size_t formulation, bool isDouble) {
    return formulation == precision::kStable && isDouble == std::is_same_v<MicroTransform, BasicMicroTransform<double>>;
}

void addPanels(Chart &chart, const ChartOptions &options) {
    Hits hits;
    std::vector<Row> rows;
    std::vector<std::function<void()>> runs;
    precision::forEachForm<float>([&](std::size_t i, const auto &make) { addRows<float>(hits, i, make, rows, runs); });
    precision::forEachForm<double>([&](std::size_t i, const auto &make) { addRows<double>(hits, i, make, rows, runs); });
    const std::vector<Measured> seconds = timeInterleaved(runs, options.pick(61, 401), Clock::Thread);
    const int perPlace = options.pick(6, 32);
    std::vector<Formulation> errors[2];
    parallelFor(2, 1, [&](std::size_t i) { errors[i] = i == 0 ? precision::sweep<float>(perPlace) : precision::sweep<double>(perPlace); });
    const std::size_t samples = errors[0][0].samples.size();
    for (std::size_t quantity = 0; quantity < precision::kQuantities; ++quantity)
        for (const bool greatest : {false, true}) {
            const std::string name = precision::kQuantityNames[quantity];
            Panel panel{name + (greatest ? "_greatest" : "_median"),
                        std::string(kQuantityTitles[quantity]) + (greatest ? ": greatest error" : ": median error"),
                        "One thread, one hit at a time, prepared from M beforehand; directions and results are floats. Errors over " +
                            std::to_string(samples) +
                            " samples: alpha 1e-4 to 10, stretch 1e-3 to 1e3, shear 0 to 1e3, views to 89.999 degrees; against long double "
                            "at the same inputs. Spreads of times hold 1 % for the placement of code.",
                        {"time per evaluation", "ns"},
                        {greatest ? "greatest relative error" : "median relative error", ""},
                        {}};
            for (std::size_t i = 0; i < rows.size(); ++i) {
                if (rows[i].quantity != quantity) continue;
                const Formulation &formulation = errors[rows[i].isDouble ? 1 : 0][rows[i].formulation];
                const precision::Summary s = summarize(formulation, quantity, [](const Place &) { return true; });
                panel.points.push_back({formulation.name,
                                        rows[i].isDouble ? "double" : "float",
                                        withPlacement(seconds[i] * (1e9 / (kRepeats * Hits::kCount))),
                                        {greatest ? s.greatest : s.median, 0, static_cast<int>(s.count)},
                                        rendersWith(rows[i].formulation, rows[i].isDouble)});
            }
            chart.panels.push_back(std::move(panel));
        }
}

/// The greatest error of D, G1, pdf and weight in float at a place; infinite where one is not finite.
std::array<double, precision::kFormulations> worstAt(const Place &place, int samples) {
    precision::Sweep<float> sweep;
    for (int i = 0; i < samples; ++i) sweep.visit(place);
    std::array<double, precision::kFormulations> worst{};
    for (std::size_t f = 0; f < precision::kFormulations; ++f)
        for (const precision::Sample &sample : sweep.formulations()[f].samples)
            for (const double error : sample.error) worst[f] = std::max(worst[f], error);
    return worst;
}

/// A map for every formulation, over places made from (x, y).
template <class PlaceAt> void addMaps(Chart &chart, const Map &frame, int samples, const PlaceAt &placeAt) {
    const std::size_t cells = frame.xs.size() * frame.ys.size();
    std::vector<std::array<double, precision::kFormulations>> worst(cells);
    parallelFor(cells, 8, [&](std::size_t i) {
        worst[i] =
            worstAt(placeAt(static_cast<float>(frame.xs[i % frame.xs.size()]), static_cast<float>(frame.ys[i / frame.xs.size()])), samples);
    });
    const precision::Sweep<float> names;
    for (const std::size_t f : kTimed) {
        Map map = frame;
        map.name += "_" + std::to_string(f);
        map.title = std::string(names.formulations()[f].name) + ", " + frame.title;
        for (const auto &cell : worst) map.values.push_back(cell[f]);
        chart.maps.push_back(std::move(map));
    }
}

/// 10^(i/3) from first to last.
std::vector<double> thirdsOfDecades(int first, int last) {
    std::vector<double> values;
    for (int i = first; i <= last; ++i) values.push_back(std::pow(10.0, i / 3.0));
    return values;
}

void addAllMaps(Chart &chart, int samples) {
    const std::string value = "greatest relative error";
    addMaps(chart,
            {"alpha_stretch",
             "alpha and stretch",
             "Float; shear 0, view at 30 degrees. Hatched: not finite.",
             {"alpha", ""},
             {"stretch", ""},
             thirdsOfDecades(-12, 3),
             thirdsOfDecades(-9, 9),
             {},
             value,
             1e-8,
             1},
            samples, [](float alpha, float stretch) {
                return Place{alpha, stretch, 0, 30, false};
            });
    Map sheared{"shear_angle",
                "shear and angle",
                "Float; alpha 1, stretch 1. Hatched: not finite.",
                {"shear", ""},
                {"view above the horizon", "degrees"},
                thirdsOfDecades(-3, 9),
                thirdsOfDecades(-9, 5),
                {},
                value,
                1e-8,
                1};
    sheared.ys.push_back(90);
    addMaps(chart, sheared, samples, [](float shear, float above) { return Place{1, 1, shear, 90 - above, false}; });
}

/// What the panels support: errors and times of the others in float beside ours.
std::string choiceOf(const Chart &chart) {
    std::map<std::string, double> worst; // by form, over all quantities
    double least = INFINITY;             // time over ours
    double most = 0;
    for (const Panel &panel : chart.panels) {
        const Point *ours = nullptr;
        for (const Point &p : panel.points)
            if (p.isDefault) ours = &p;
        for (const Point &p : panel.points) {
            if (p.label != ours->label) continue;
            worst[p.series] = std::max(worst[p.series], p.y.value);
            if (&p == ours) continue;
            least = std::min(least, p.x.value / ours->x.value);
            most = std::max(most, p.x.value / ours->x.value);
        }
    }
    const std::string stable = precision::Sweep<float>().formulations()[precision::kStable].name;
    double others = INFINITY;
    for (const auto &[form, error] : worst)
        if (form != stable) others = std::min(others, error);
    return "Stable forms in float. The others take " + digits(least, 2) + " to " + digits(most, 2) +
           " times as long. Over all quantities and places the greatest relative error of the best of them is " + digits(others, 2) +
           ", of ours " + digits(worst[stable], 2) +
           ": in the maps it is dark throughout. Double would buy digits that the float inputs do not have.";
}

} // namespace

Chart measurePrecision(const ChartOptions &options) {
    Chart chart{"precision", "Digits: formulations of the microsurface",
                "The same distribution D, masking G1, density and weight by the forms in print (the textbook's sum, Walter's tan^2, "
                "the cos^2 of real-time shaders, the talk's chain of Jacobians, the tensor M M^T) and by the forms that render "
                "(stable). The truth is long double at the same rounded inputs, so an error is the formula's own.",
                "Left is faster, down is more accurate; each form stands twice, in float and in double. In the maps dark is "
                "accurate, yellow is wrong by the value itself, hatched is not a number."};
    addPanels(chart, options);
    addAllMaps(chart, options.pick(24, 256));
    chart.choice = choiceOf(chart);
    chart.tables = precisionTables();
    return chart;
}

} // namespace taut::chart
