/// Samplers of reflections (normal_samplers.h, reflection_sampler.h): what a valid sample costs, how many are rejected, and what comes of
/// it on a plate under a furnace, a small lamp and a sky.

#include "study/charts.h"
#include "study/measures/timing.h"
#include "study/scenes/sampling_plate.h"
#include "study/text.h"

#include <array>
#include <memory>

namespace taut::chart {

namespace {

struct Surface {
    const char *name, *title;
    MicroTransform m;
    std::vector<float> thetas; ///< of the views, degrees
};

std::vector<Surface> surfaces() {
    const std::vector<float> above{0, 30, 60, 80, 89};
    return {{"diagonal", "diagonal M, alpha (0.5, 0.1)", microTransformFromAlpha(0.5F, 0.1F), above},
            {"skewed", "skewed M = [1 2; 0 1]", microTransform(1, 2, 0, 1), above},
            {"squashed", "squashed M, alpha (5, 0.3)", microTransformFromAlpha(5, 0.3F), above},
            {"leaning", "leaning M, alpha (0.4, 0.2), lean (0.5, 0.3)", microTransform(2.5F, 0, 0, 5, 0.5F, 0.3F), above},
            {"behind", "views from behind, M = [1 2; 0 1]", microTransform(1, 2, 0, 1), {91, 100, 115, 130}}};
}

/// Calls f(name, Sampler<S>(), isDefault) for the samplers that differ at (m, wo). The one that the renderer picks is run as the
/// renderer runs it, the cost of picking included.
template <class F> void forEachSampler(const MicroTransform &m, const Vec3 &wo, const F &f) {
    const bool cone = RenderersChoice(m, wo).samplesCone();
    f("all normals (NDF)", Sampler<Reflected<DiskNormals>>(), false);
    f("visible normals (Heitz 2018)", Sampler<Reflected<HalfDiskNormals>>(), false);
    f("spherical caps", Sampler<Reflected<CapNormals>>(), false);
    // Where the caps have no bound this is the full cap, in the renderer's own code.
    if (cone)
        f("bounded caps", Sampler<BoundedCaps>(), false);
    else
        f("bounded caps", Sampler<RenderersChoice>(), true);
    if (cone)
        f("cone (ours)", Sampler<RenderersChoice>(), true);
    else if (ReflectionSampler(m, wo).samplesCone())
        f("cone (ours)", Sampler<ReflectionSampler>(), false);
}

struct Row {
    std::string sampler;
    bool isDefault;
    std::size_t theta; ///< index
    Tally tally;
};

/// Three panels of a surface: rejected share against time over all angles, and each against the angle.
void addSurface(Chart &chart, const Surface &surface, bool quick) {
    std::mt19937 random(1);
    const std::vector<Vec2> u = uniformPairs(quick ? 8192 : 65536, random);
    std::vector<Row> rows;
    std::vector<std::function<void()>> runs;
    rows.reserve(64);
    for (std::size_t t = 0; t < surface.thetas.size(); ++t) {
        const std::vector<Vec3> views = viewsAt(surface.thetas[t], 512, random);
        forEachSampler(surface.m, views[0], [&](const char *name, auto sampler, bool isDefault) {
            rows.push_back({name, isDefault, t, {}});
            runs.push_back([&surface, &u, views, row = &rows.back()] {
                row->tally = tallyReflections<typename decltype(sampler)::Type>(surface.m, views, u, true);
            });
        });
    }
    const std::vector<Measured> seconds = timeInterleaved(runs, quick ? 61 : 101, Clock::Thread);

    std::string conditions = "One thread; direction, density and weight, prepared anew for every sample; means over views at";
    for (const float &theta : surface.thetas)
        conditions += (&theta == &surface.thetas.front() ? " " : ", ") + digits(static_cast<double>(theta));
    conditions += " degrees, 512 azimuths each, " + std::to_string(u.size()) + " samples.";
    const Axis time{"time per valid sample", "ns"};
    const Axis share{"rejected share", ""};
    const Axis view{"view", "degrees", false};
    const std::string name = surface.name;
    Panel all{name, std::string("Rejected against time, ") + surface.title, conditions, time, share, {}};
    Panel times = lines({name + "_time", std::string("Time against angle, ") + surface.title, conditions, view, time, {}});
    Panel shares = lines({name + "_rejected", std::string("Rejected against angle, ") + surface.title, conditions, view, share, {}});
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row &row = rows[i];
        const Measured perValid = seconds[i] * (1e9 / row.tally.valid);
        const double lost = row.tally.rejected();
        const Measured rejected{lost, std::sqrt(lost * (1 - lost) / row.tally.samples), static_cast<int>(u.size())};
        const Measured theta{static_cast<double>(surface.thetas[row.theta])};
        const std::string angle = digits(theta.value);
        const auto named = [&](const Point &p) { return p.series == row.sampler; };
        auto mean = std::find_if(all.points.begin(), all.points.end(), named);
        if (mean == all.points.end())
            mean = all.points.insert(mean, {row.sampler, "", {0, 0, perValid.repetitions}, {0, 0, rejected.repetitions}, row.isDefault});
        const auto part = 1 / static_cast<double>(surface.thetas.size());
        mean->x.value += part * perValid.value;
        mean->x.spread += part * perValid.spread;
        mean->y.value += part * rejected.value;
        mean->y.spread = std::hypot(mean->y.spread, part * rejected.spread);
        times.points.push_back({row.sampler, angle, theta, perValid, row.isDefault});
        shares.points.push_back({row.sampler, angle, theta, rejected, row.isDefault});
    }
    for (Panel *panel : {&all, &times, &shares}) chart.panels.push_back(std::move(*panel));
}

/// The table of docs/reflection_sampling.md: what the cone wastes, costs and varies beside bounded caps, prepared anew for every sample
/// ("hit") or once for all of a view ("many").
Table reflectionTable(int rounds, std::size_t samples) {
    const std::pair<const char *, MicroTransform> cases[] = {{"[1 2; 0 1]", microTransform(1, 2, 0, 1)},
                                                             {"alpha (1, 0.1)", microTransformFromAlpha(1, 0.1F)},
                                                             {"alpha (2, 2)", microTransformFromAlpha(2, 2)},
                                                             {"alpha (5, 0.3)", microTransformFromAlpha(5, 0.3F)},
                                                             {"[1 10; 0 1]", microTransform(1, 10, 0, 1)},
                                                             {"alpha (1, 1)", microTransformFromAlpha(1, 1)},
                                                             {"alpha (0.5, 0.5)", microTransformFromAlpha(0.5F, 0.5F)},
                                                             {"alpha (0.5, 0.1)", microTransformFromAlpha(0.5F, 0.1F)},
                                                             {"alpha (0.1, 0.1)", microTransformFromAlpha(0.1F, 0.1F)}};
    std::mt19937 random(1);
    const std::vector<Vec2> u = uniformPairs(samples, random);
    Table table{"reflection",
                "The reflection sampler beside bounded caps",
                {"M", "theta", "full cap rejects", "bounded rejects", "cone rejects", "cost ratio, hit", "cost ratio, many",
                 "ns bounded / cone, hit", "variance ratio"},
                {}};
    for (const auto &[name, m] : cases)
        for (const float theta : {0.0F, 30.0F, 60.0F, 80.0F, 89.0F}) {
            const std::vector<Vec3> views = viewsAt(theta, 512, random);
            const Tally full = tallyReflections<Reflected<CapNormals>>(m, views, u, false);
            std::array<Tally, 4> tallies; // cap and cone, a hit; cap and cone, many
            const auto run = [&]<class S>(Sampler<S>, std::size_t i) {
                return std::function<void()>([&, &m = m, i] { tallies[i] = tallyReflections<S>(m, views, u, i < 2); });
            };
            const std::vector<std::function<void()>> runs{run(Sampler<BoundedCaps>(), 0), run(Sampler<ReflectionSampler>(), 1),
                                                          run(Sampler<BoundedCaps>(), 2), run(Sampler<ReflectionSampler>(), 3)};
            const std::vector<Measured> seconds = timeInterleaved(runs, rounds, Clock::Thread);
            const auto ns = [&](std::size_t i) { return 1e9 * seconds[i].value / tallies[i].valid; };
            table.rows.push_back({name, digits(static_cast<double>(theta)), printed("%.1f %%", 100 * full.rejected()),
                                  printed("%.1f %%", 100 * tallies[0].rejected()), printed("%.4f %%", 100 * tallies[1].rejected()),
                                  printed("%.2f", ns(1) / ns(0)), printed("%.2f", ns(3) / ns(2)), printed("%.0f / %.0f", ns(0), ns(1)),
                                  printed("%.3f", tallies[1].variance() / tallies[0].variance())});
        }
    return table;
}

/// Variance of pictures under three lights, of each sampler that differs on a surface.
class Plates {
  public:
    Plates(const Surface &surface, const SkyLight &sky) : surface_(surface) {
        addLight("furnace", "Furnace", std::vector<FurnaceLight>(1));
        addLight("lamp", "Small lamp", std::vector<LampLight>(1));
        addLight("sky", "Studio environment", std::vector<SkyLight>(kSkies, sky));
    }

    /// A panel a light, and one of all: mean time, geometric mean of variances.
    void addTo(Chart &chart, int rounds) const {
        const std::vector<Point> points = timeChoices(choices_, rounds, Threads::One, 1e-9 * plateSamples(kSpp));
        Panel mean = panelOf("lights", "Mean of furnace, lamp and environment");
        mean.conditions =
            "A sampler does not know the light: the default is held to the front of this mean (of times; geometric of variances). " +
            mean.conditions;
        for (const auto &[name, title] : lights_) {
            Panel panel = panelOf(name, title);
            panel.hasFront = false;
            for (std::size_t i = 0; i < points.size(); ++i)
                if (lightOf_[i] == name) panel.points.push_back(points[i]);
            if (mean.points.empty()) {
                mean.points = panel.points;
                for (Point &p : mean.points) p.x.value = p.x.spread = p.y.spread = 0, p.y.value = 1;
            }
            const double part = 1 / static_cast<double>(lights_.size());
            for (std::size_t i = 0; i < mean.points.size(); ++i) {
                Point &sum = mean.points[i];
                const Point &p = panel.points[i];
                sum.x.value += part * p.x.value;
                sum.x.spread += part * p.x.spread;
                sum.y.value *= std::pow(p.y.value, part);
                sum.y.spread += part * p.y.spread / p.y.value; // relative, until all lights are in
            }
            addNotes(panel);
            chart.panels.push_back(std::move(panel));
        }
        for (Point &p : mean.points) p.y.spread *= p.y.value;
        addNotes(mean);
        chart.panels.push_back(std::move(mean));
    }

  private:
    static constexpr int kSpp = 32;
    /// Copies of the sky that rounds take in turn: how a map lies in the caches differs from one allocation to the next, and decides
    /// the order of samplers that cost about the same.
    static constexpr std::size_t kSkies = 8;
    template <class L> void addLight(const std::string &name, const std::string &title, std::vector<L> lights) {
        lights_.emplace_back(name, title);
        const auto shared = std::make_shared<const std::vector<L>>(std::move(lights));
        forEachSampler(surface_.m, Vec3(0, 0, 1), [&](const char *sampler, auto type, bool isDefault) {
            lightOf_.push_back(name);
            choices_.push_back({sampler, "", isDefault, [this, shared](std::uint32_t seed) {
                                    const L &light = (*shared)[seed % shared->size()];
                                    return renderPlate<typename decltype(type)::Type>(surface_.m, light, kSpp, seed - 1).variance;
                                }});
        });
    }

    [[nodiscard]] Panel panelOf(const std::string &name, const std::string &title) const {
        return {name + "_" + surface_.name,
                title + ", " + surface_.title,
                "A plate of 32 x 18 pixels, a hit and a preparation of its own for every sample, no rays; light and surface are both "
                "sampled where the light can be (power heuristic). Beside the marks: variance x time over that of the default.",
                {"time per sample", "ns"},
                {"variance of a sample over the squared mean", ""},
                {}};
    }

    static void addNotes(Panel &panel) {
        double unit = 1;
        for (const Point &p : panel.points)
            if (p.isDefault) unit = p.x.value * p.y.value;
        for (Point &p : panel.points) p.note = printed("%.2f", p.x.value * p.y.value / unit);
    }

    const Surface &surface_;
    std::vector<std::pair<std::string, std::string>> lights_;
    std::vector<Choice> choices_;
    std::vector<std::string> lightOf_; ///< [choices]
};

} // namespace

Chart measureSampling(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    Chart chart{
        "sampling", "Samplers of reflections",
        "Ways to draw a reflected direction: from all normals (the talk's disk), from visible normals by Heitz's disk, by spherical caps, "
        "by bounded caps, and by the cone of normals that reflect above the horizon. A sample below the horizon is rejected. All are "
        "unbiased; what differs is their variance. Views from behind are those of interpolated normals that lean away (Tokuyoshi 2021).",
        "Down is fewer rejected samples, or less variance; left is faster. What counts in a picture is variance x time: it "
        "is written beside the marks of the plates, over that of the default.",
        "The cone where bounded caps would reject more than a tenth at normal incidence, bounded caps elsewhere: rejected samples cost "
        "variance, and where few are rejected caps are cheaper to prepare. Leaning M and views from behind use caps. Under a small lamp "
        "alone, which light sampling finds, the sampler hardly matters and the cheapest would do; a surface does not know that."};
    const std::vector<Surface> all = surfaces();
    for (const Surface &surface : all) addSurface(chart, surface, quick);
    const SkyLight sky;
    for (std::size_t i = 0; i < 2; ++i) {
        const Plates plates(all[i], sky);
        plates.addTo(chart, quick ? 51 : 201);
    }
    chart.tables.push_back(reflectionTable(options.pick(3, 9), std::size_t{1} << options.pick(14, 18)));
    return chart;
}

} // namespace taut::chart
