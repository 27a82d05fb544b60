/// Treatments of light that meets more than one facet: what a hit costs against the energy that is lost and the light that goes astray.

#include "study/charts.h"
#include "study/measures/timing.h"
#include "study/microsurface/albedo_quadrature.h"
#include "study/scenes/scenes.h"

#include "taut/base/parallel.h"
#include "taut/bsdf/bsdf.h"
#include "taut/plan/plan.h"

namespace taut::chart {

namespace {

struct Surface {
    const char *name, *title;
    MicroTransform m;
};

std::vector<Surface> surfaces() {
    return {{"smooth", "alpha 0.1", microTransformFromAlpha(0.1F, 0.1F)},
            {"isotropic", "alpha 0.5", microTransformFromAlpha(0.5F, 0.5F)},
            {"rough", "alpha 1", microTransformFromAlpha(1, 1)},
            {"diagonal", "alpha (1, 0.1)", microTransformFromAlpha(1, 0.1F)},
            {"skewed", "M = [1 2; 0 1]", microTransform(1, 2, 0, 1)},
            {"leaning", "alpha (0.8, 0.4), lean (0.5, 0.3)", microTransform(1.25F, 0, 0, 2.5F, 0.5F, 0.3F)}};
}

/// Single scattering divided by its albedo from a table over the cosine and one roughness, the geometric mean of both alphas: what
/// renderers do that tabulate isotropic surfaces (Turquin 2019, with F = 1; Cycles, Principled and others).
class IsotropicTable {
  public:
    IsotropicTable() : albedo_(std::size_t{kSize} * kSize) {
        parallelFor(albedo_.size(), 16, [&](std::size_t i) {
            const float root = coordinate(i / kSize);
            const float alpha = std::fmax(root * root, 1e-3F);
            const float z = std::fmax(coordinate(i % kSize), 1e-3F);
            albedo_[i] = static_cast<float>(tables::albedo(microTransformFromAlpha(alpha, alpha), {std::sqrt(1 - z * z), 0, z}, 1024));
        });
    }
    [[nodiscard]] float albedo(const MicroTransform &m, const Vec3 &w) const {
        const float x = glm::clamp(w.z, 0.0F, 1.0F) * (kSize - 1);
        const float y = std::fmin(std::sqrt(std::sqrt(1 / m.det)), 1.0F) * (kSize - 1); // root of the mean alpha
        const auto column = std::min(static_cast<std::size_t>(x), std::size_t{kSize - 2});
        const auto row = std::min(static_cast<std::size_t>(y), std::size_t{kSize - 2});
        const float u = x - static_cast<float>(column);
        const float v = y - static_cast<float>(row);
        const float *at = &albedo_[row * kSize + column];
        return glm::mix(glm::mix(at[0], at[1], u), glm::mix(at[kSize], at[kSize + 1], u), v);
    }

  private:
    static constexpr int kSize = 32;
    static float coordinate(std::size_t i) { return static_cast<float>(i) / (kSize - 1); }
    std::vector<float> albedo_;
};

/// A row of the chart. `table`: single scattering over the isotropic table's albedo.
struct Treatment {
    const char *name;
    Multiscatter multiscatter;
    bool table;
};
constexpr Treatment kTreatments[] = {{"off", Multiscatter::Off, false},
                                     {"isotropic table", Multiscatter::Off, true},
                                     {"compensation (ours)", Multiscatter::Compensation, false},
                                     {"walk", Multiscatter::Walk, false}};

Bsdf mirrorOf(const MicroTransform &m, Multiscatter multiscatter) {
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.micro = m;
    bsdf.f0 = Vec3(1);
    bsdf.multiscatter = multiscatter;
    return bsdf;
}

/// Energy by the direction that it leaves to, in cells of equal cos^2 and azimuth, for wo seen from one direction; F = 1.
using Lobe = std::vector<double>;
constexpr int kRows = 8;
constexpr int kColumns = 16;
void add(Lobe &lobe, const Vec3 &wi, double energy) {
    const int row = std::min(static_cast<int>(wi.z * wi.z * kRows), kRows - 1);
    const float turn = std::atan2(wi.y, wi.x) / (2 * kPi);
    const int column = std::min(static_cast<int>((turn - std::floor(turn)) * kColumns), kColumns - 1);
    lobe[static_cast<std::size_t>(row * kColumns + column)] += energy;
}

/// Half the sum of differences: the share of the light that is missing, invented or sent to another cell.
double distance(const Lobe &a, const Lobe &b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::fabs(a[i] - b[i]) / 2;
    return sum;
}

/// The truth: walks, counted where they leave.
Lobe walkedLobe(const MicroTransform &m, const Vec3 &wo, std::uint32_t samples, std::uint32_t seed) {
    Lobe lobe(kRows * kColumns);
    for (std::uint32_t i = 0; i < samples; ++i) {
        walk::Random random((std::uint64_t{seed} << 32U) | i);
        const walk::Exit exit = walk::sample(m, wo, walk::UniformReflector{}, sobol2(i, seed), random);
        if (exit.throughput.x > 0) add(lobe, exit.w, static_cast<double>(exit.throughput.x) / samples);
    }
    return lobe;
}

/// What a treatment evaluates to: its f cos over the hemisphere, by directions drawn from the compensated lobe (half of them from the
/// cosine, so that no direction is rare). The walk is evaluated here, where the truth counts its samples.
Lobe evaluatedLobe(const MicroTransform &m, const Treatment &treatment, const IsotropicTable &table, const Vec3 &wo,
                   std::uint32_t samples) {
    const Bsdf bsdf = mirrorOf(m, treatment.multiscatter);
    const Bsdf single = mirrorOf(m, Multiscatter::Off);
    const ScatteringPoint point(bsdf, wo);
    const ScatteringPoint guide(single, wo);
    const double scale = treatment.table ? 1 / static_cast<double>(table.albedo(m, wo)) : 1.0;
    Lobe lobe(kRows * kColumns);
    for (std::uint32_t i = 0; i < samples; ++i) {
        const Vec2 u = sobol2(i, 1);
        const float choice = sobol1(i, 2);
        Vec3 wi = squareToCosineHemisphere(u);
        if (choice < 0.5F) {
            const auto s = guide.sample(u, 2 * choice, i);
            if (!s) continue;
            wi = s->wi;
        }
        if (!(wi.z > 0)) continue;
        const double pdf = 0.5 * static_cast<double>(guide.evaluate(wi).pdf) + 0.5 * static_cast<double>(kInvPi * wi.z);
        add(lobe, wi, scale * static_cast<double>(point.evaluate(wi, walk::numbersOf(i)).fCos.x) / pdf / samples);
    }
    return lobe;
}

/// The share of light that samples of a treatment return in a white furnace.
double furnace(const MicroTransform &m, const Treatment &treatment, const IsotropicTable &table, const Vec3 &wo, std::uint32_t samples) {
    const Bsdf bsdf = mirrorOf(m, treatment.multiscatter);
    const ScatteringPoint point(bsdf, wo);
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i)
        if (const auto s = point.sample(sobol2(i, 3), sobol1(i, 4), hash(i, 5))) sum += static_cast<double>(s->weight.x);
    return sum / samples / (treatment.table ? static_cast<double>(table.albedo(m, wo)) : 1.0);
}

struct Errors {
    double furnace = 0, lobe = 0, noise = 0; ///< means over views; noise of the truth
};

/// Views at four angles, in azimuths that hit no axis.
std::vector<Vec3> views() {
    std::vector<Vec3> all;
    for (const float theta : {0.0F, 45.0F, 75.0F, 85.0F})
        all.push_back(Vec3(std::sin(theta * kPi / 180) * unitCircle(0.07F + theta / 200), std::cos(theta * kPi / 180)));
    return all;
}

std::vector<Errors> errorsOf(const MicroTransform &m, const IsotropicTable &table, std::uint32_t samples) {
    const std::vector<Vec3> wos = views();
    std::vector<std::vector<Errors>> found(wos.size(), std::vector<Errors>(std::size(kTreatments)));
    parallelFor(wos.size(), 1, [&](std::size_t v) {
        const Lobe first = walkedLobe(m, wos[v], samples, 11);
        const Lobe second = walkedLobe(m, wos[v], samples, 12);
        Lobe truth = first;
        for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = (first[i] + second[i]) / 2;
        for (std::size_t t = 0; t < std::size(kTreatments); ++t) {
            const Lobe lobe = evaluatedLobe(m, kTreatments[t], table, wos[v], samples / 4);
            found[v][t] = {std::fabs(1 - furnace(m, kTreatments[t], table, wos[v], samples / 4)), distance(lobe, truth),
                           distance(first, second) / 2};
        }
    });
    std::vector<Errors> mean(std::size(kTreatments));
    const double part = 1 / static_cast<double>(wos.size());
    for (const auto &view : found)
        for (std::size_t t = 0; t < mean.size(); ++t) {
            mean[t].furnace += part * view[t].furnace;
            mean[t].lobe += part * view[t].lobe;
            mean[t].noise += part * view[t].noise;
        }
    return mean;
}

/// What the plan takes for a metal of this gloss in the light of this chart, a white furnace.
Multiscatter defaultTreatment(const MicroTransform &m) {
    const EquivalentAlpha alpha = equivalentAlpha(m);
    Scene scene;
    scene.render.frames = {1};
    scene.materials = {brushedMetal(alpha.max, alpha.min)};
    scene.materials[0].rotation.value = alpha.phi;
    scene.objects = {objectOf(makeGrid(1, 1, 1))};
    scene.environment = constantEnvironment(Vec3(1));
    const MultiscatterPlan plan = makePlan(scene).materials[0];
    return plan.model == Multiscatter::Auto ? chooseMultiscatter(m, false, plan.negligibleLoss) : plan.model;
}

/// Hits of one surface: preparing, an evaluation and a sample each.
std::function<void()> timedRun(const MicroTransform &m, const Treatment &treatment, const IsotropicTable &table,
                               const std::vector<Vec3> &wos, const std::vector<Vec3> &wis) {
    return [bsdf = mirrorOf(m, treatment.multiscatter), isTable = treatment.table, &table, &wos, &wis] {
        volatile float sink = 0;
        float sum = 0;
        for (std::uint32_t i = 0; i < wos.size(); ++i) {
            const ScatteringPoint point(bsdf, wos[i]);
            const float scale = isTable ? 1 / table.albedo(bsdf.micro, wos[i]) : 1.0F;
            sum += scale * point.evaluate(wis[i], walk::numbersOf(i)).fCos.x;
            const std::uint32_t bits = hash(i);
            if (const auto s = point.sample({toUnitFloat(bits), toUnitFloat(hash(bits))}, toUnitFloat(hash(bits + 1)), bits))
                sum += scale * s->weight.x;
        }
        sink = sum;
        (void)sink;
    };
}

} // namespace

Chart measureMultiscatter(const ChartOptions &options) {
    Chart chart{
        "multiscatter", "Light that meets more than one facet",
        "Nothing done (off); single scattering divided by its albedo from a table of isotropic surfaces, as renderers do that "
        "have one (alpha = the geometric mean); our compensating lobe, with the albedo of the transformed surface in it; the "
        "random walk. The truth: a white furnace returns all light, and its directions are those of walks counted where they "
        "leave. The walk's own point is its evaluation, which is another computation.",
        "Left is faster; down is less energy lost or gained, or less light sent elsewhere (half the sum over 128 cells of "
        "the hemisphere). The walk is exact: it returns every ray, and what its lobe shows is the noise of this measurement.",
        "What the plan takes for a metal of this gloss in even light: the walk wherever the light lost would show. A table of isotropic "
        "surfaces is cheaper and right for isotropic ones; on a stretched or sheared one it is off by tens of percent, and which of the "
        "two a surface is changes as it deforms. The compensation has the right energy for every M, in directions that are not."};
    const IsotropicTable table;
    std::vector<Vec3> wos;
    std::vector<Vec3> wis;
    for (std::uint32_t i = 0; i < 512; ++i) {
        wos.push_back(squareToCosineHemisphere(sobol2(i, 5)));
        wis.push_back(squareToCosineHemisphere(sobol2(i, 6)));
    }
    const std::vector<Surface> all = surfaces();
    std::vector<std::function<void()>> runs;
    for (const Surface &surface : all)
        for (const Treatment &treatment : kTreatments) runs.push_back(timedRun(surface.m, treatment, table, wos, wis));
    const std::vector<Measured> seconds = timeInterleaved(runs, options.pick(61, 401), Clock::Thread);
    const std::uint32_t samples = 1U << static_cast<unsigned>(options.pick(18, 22));
    for (std::size_t s = 0; s < all.size(); ++s) {
        const std::vector<Errors> errors = errorsOf(all[s].m, table, samples);
        const Axis hitTime{"time per hit", "ns"};
        Panel furnace{
            std::string("furnace_") + all[s].name,
            std::string("White furnace, ") + all[s].title,
            "F = 1; views at 0, 45, 75 and 85 degrees, mean of |1 - albedo|. Time of preparing, one evaluation and one sample, one thread.",
            hitTime,
            {"energy lost or gained", ""},
            {}};
        Panel lobe{std::string("lobe_") + all[s].name,
                   std::string("Directions, ") + all[s].title,
                   "F = 1; the same views; share of the light that is missing, invented or in another of 128 cells.",
                   hitTime,
                   {"light astray", ""},
                   {}};
        const Multiscatter chosen = defaultTreatment(all[s].m);
        for (std::size_t t = 0; t < std::size(kTreatments); ++t) {
            const Measured time = seconds[s * std::size(kTreatments) + t] * (1e9 / static_cast<double>(wos.size()));
            const bool isDefault = !kTreatments[t].table && kTreatments[t].multiscatter == chosen;
            const auto count = static_cast<int>(samples);
            furnace.points.push_back({kTreatments[t].name, "", time, {errors[t].furnace, 0, count}, isDefault});
            lobe.points.push_back({kTreatments[t].name, "", time, {errors[t].lobe, errors[t].noise, count}, isDefault});
        }
        chart.panels.push_back(std::move(furnace));
        chart.panels.push_back(std::move(lobe));
    }
    return chart;
}

} // namespace taut::chart
