/// Samplers of reflections (normal_samplers.h, reflection_sampler.h): what a valid sample costs, how many are rejected, and what comes of
/// it on a plate under a furnace, a small lamp and a sky.

#include "study/charts.h"
#include "study/sampling_plate.h"
#include "study/timing.h"

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

/// A type as a value.
template <class S> struct Sampler { using Type = S; };

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

    Panel all;
    all.name = surface.name;
    all.title = std::string("Rejected against time, ") + surface.title;
    all.conditions = "One thread; direction, density and weight, prepared anew for every sample; means over views at";
    for (const float &theta : surface.thetas)
        all.conditions += (&theta == &surface.thetas.front() ? " " : ", ") + std::to_string(static_cast<int>(theta));
    all.conditions += " degrees, 512 azimuths each, " + std::to_string(u.size()) + " samples.";
    all.x = {"time per valid sample", "ns"};
    all.y = {"rejected share", ""};
    Panel times = all;
    times.name += "_time";
    times.title = std::string("Time against angle, ") + surface.title;
    times.hasFront = false;
    times.joined = true;
    times.labelled = false; // the axis says the same
    times.x = {"view", "degrees", false};
    times.y = all.x;
    Panel shares = times;
    shares.name = surface.name + std::string("_rejected");
    shares.title = std::string("Rejected against angle, ") + surface.title;
    shares.y = all.y;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row &row = rows[i];
        const Measured perValid = seconds[i] * (1e9 / row.tally.valid);
        const double share = row.tally.rejected();
        const Measured rejected{share, std::sqrt(share * (1 - share) / row.tally.samples), static_cast<int>(u.size())};
        const Measured theta{static_cast<double>(surface.thetas[row.theta])};
        const std::string angle = std::to_string(static_cast<int>(surface.thetas[row.theta]));
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

/// Variance of pictures under three lights, of each sampler that differs on a surface.
class Plates {
  public:
    Plates(const Surface &surface, const SkyLight &sky) : surface_(surface) {
        addLight("furnace", "Furnace", std::vector<FurnaceLight>(1));
        addLight("lamp", "Small lamp", std::vector<LampLight>(1));
        addLight("sky", "Studio environment", std::vector<SkyLight>(kSkies, sky));
    }

    void measure(int rounds) {
        const std::vector<Measured> seconds = timeInterleaved(runs_, rounds, Clock::Thread);
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            rows_[i].point.x = seconds[i] * (1e9 / plateSamples(kSpp));
            rows_[i].point.y = medianOf(*rows_[i].variances);
        }
    }

    /// A panel a light, and one of all: mean time, geometric mean of variances.
    void addTo(Chart &chart) const {
        Panel mean = panelOf("lights", "Mean of furnace, lamp and environment");
        mean.conditions =
            "A sampler does not know the light: the default is held to the front of this mean (of times; geometric of variances). " +
            mean.conditions;
        for (const auto &[name, title] : lights_) {
            Panel panel = panelOf(name, title);
            panel.hasFront = false;
            for (const Row &row : rows_)
                if (row.light == name) panel.points.push_back(row.point);
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
    struct Row {
        std::string light;
        Point point;
        std::shared_ptr<std::vector<double>> variances;
    };

    template <class L> void addLight(const std::string &name, const std::string &title, std::vector<L> lights) {
        lights_.emplace_back(name, title);
        const auto shared = std::make_shared<const std::vector<L>>(std::move(lights));
        forEachSampler(surface_.m, Vec3(0, 0, 1), [&](const char *sampler, auto type, bool isDefault) {
            auto variances = std::make_shared<std::vector<double>>();
            rows_.push_back({name, {sampler, "", {}, {}, isDefault}, variances});
            runs_.push_back([this, shared, variances] {
                const auto seed = static_cast<std::uint32_t>(variances->size());
                const L &light = (*shared)[seed % shared->size()];
                variances->push_back(renderPlate<typename decltype(type)::Type>(surface_.m, light, kSpp, seed).variance);
            });
        });
    }

    [[nodiscard]] Panel panelOf(const std::string &name, const std::string &title) const {
        Panel panel;
        panel.name = name + "_" + surface_.name;
        panel.title = title + ", " + surface_.title;
        panel.conditions =
            "A plate of 32 x 18 pixels, a hit and a preparation of its own for every sample, no rays; light and surface are both "
            "sampled where the light can be (power heuristic). Beside the marks: variance x time over that of the default.";
        panel.x = {"time per sample", "ns"};
        panel.y = {"variance of a sample over the squared mean", ""};
        return panel;
    }

    static void addNotes(Panel &panel) {
        double unit = 1;
        for (const Point &p : panel.points)
            if (p.isDefault) unit = p.x.value * p.y.value;
        for (Point &p : panel.points) {
            char text[32];
            std::snprintf(text, sizeof text, "%.2f", p.x.value * p.y.value / unit);
            p.note = text;
        }
    }

    const Surface &surface_;
    std::vector<std::pair<std::string, std::string>> lights_;
    std::vector<Row> rows_;
    std::vector<std::function<void()>> runs_;
};

} // namespace

Chart measureSampling(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    Chart chart;
    chart.name = "sampling";
    chart.title = "Samplers of reflections";
    chart.compared = "Ways to draw a reflected direction: from all normals (the talk's disk), from visible normals by Heitz's disk, by "
                     "spherical caps, by "
                     "bounded caps, and by the cone of normals that reflect above the horizon. A sample below the horizon is rejected. All "
                     "are unbiased; "
                     "what differs is their variance. Views from behind are those of interpolated normals that lean away (Tokuyoshi 2021).";
    chart.howToRead = "Down is fewer rejected samples, or less variance; left is faster. What counts in a picture is variance x time: it "
                      "is written beside "
                      "the marks of the plates, over that of the default.";
    chart.choice =
        "The cone where bounded caps would reject more than a tenth at normal incidence, bounded caps elsewhere: rejected samples cost "
        "variance, and where few are rejected caps are cheaper to prepare. Leaning M and views from behind use caps. Under a small lamp "
        "alone, "
        "which light sampling finds, the sampler hardly matters and the cheapest would do; a surface does not know that.";
    const std::vector<Surface> all = surfaces();
    for (const Surface &surface : all) addSurface(chart, surface, quick);
    const SkyLight sky;
    for (std::size_t i = 0; i < 2; ++i) {
        Plates plates(all[i], sky);
        plates.measure(quick ? 51 : 201);
        plates.addTo(chart);
    }
    return chart;
}

} // namespace taut::chart
