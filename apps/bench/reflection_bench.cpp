/// taut_reflection_bench: what the reflection sampler wastes, costs and varies beside bounded caps (Eto & Tokuyoshi 2023), in one
/// run. Prints the table of docs/reflection_sampling.md. Per line: share of samples rejected by the full cap, the bounded cap and
/// the cone; cost per valid sample (direction, density and weight) of cone / bounded caps, where every sample has its own wo and
/// prepares anew ("hit") and where one preparation serves many ("many"); variance of one sample's weight, cone / bounded caps,
/// rejected samples counted as zeros.

#include "taut/microsurface/reflection_sampler.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <vector>

namespace {

using namespace taut;

constexpr int kViews = 512;
constexpr int kSamples = 1 << 18;
constexpr int kRounds = 9;

/// A sampler of reflected directions by visible normals, as ReflectionSampler is used; `bounded` shortens the cap.
class CapSampler {
  public:
    CapSampler(const MicroTransform &m, const Vec3 &wo, bool bounded = true) : m_(m), wo_(wo), k_(bounded ? ggx::capBound(m, wo) : 1) {
        const float length = ggx::stretchedLength(m, wo);
        pdfScale_ = 0.5F / (k_ < 1 ? k_ * wo.z + length : ggx::visibleArea(m, wo, length));
    }
    [[nodiscard]] std::optional<Vec3> sample(const Vec2 &u) const {
        const Vec3 wm = ggx::sampleVisibleNormal(m_, wo_, u, k_);
        const Vec3 wi = 2 * glm::dot(wo_, wm) * wm - wo_;
        if (!(wi.z > 0)) return std::nullopt;
        return wi;
    }
    [[nodiscard]] float pdfScale() const { return pdfScale_; }

  private:
    MicroTransform m_;
    Vec3 wo_;
    float k_;
    float pdfScale_ = 0;
};

struct Tally {
    double valid = 0, sum = 0, squares = 0, seconds = 0;
    [[nodiscard]] double rejected() const { return 1 - valid / kSamples; }
    [[nodiscard]] double variance() const { return squares / kSamples - sqr(sum / kSamples); }
    [[nodiscard]] double perValid() const { return 1e9 * seconds / valid; }
};

/// Takes kSamples samples, preparing for each (perHit) or once a view, and sums weights G2 D cos / pdf, correlated, F = 1.
/// The density is evaluated from wi as a renderer would and kept alive through the sums.
template <class Sampler> Tally run(const MicroTransform &m, const std::vector<Vec3> &views, const std::vector<Vec2> &u, bool perHit) {
    Tally t;
    const auto start = std::chrono::steady_clock::now();
    const auto take = [&](const Sampler &sampler, const Vec3 &wo, float length, const Vec2 &number) {
        const auto wi = sampler.sample(number);
        if (!wi) return;
        const float density = ggx::distribution(m, wo, *wi);
        const float pdf = density * sampler.pdfScale();
        const float weight = density * ggx::visibility(wo.z, length, wi->z, ggx::stretchedLength(m, *wi), true) * wi->z / pdf;
        ++t.valid;
        t.sum += static_cast<double>(weight);
        t.squares += static_cast<double>(weight) * static_cast<double>(weight);
    };
    if (perHit) {
        for (std::size_t i = 0; i < kSamples; ++i) {
            const Vec3 &wo = views[i % kViews];
            take(Sampler(m, wo), wo, ggx::stretchedLength(m, wo), u[i]);
        }
    } else {
        constexpr std::size_t kEach = kSamples / kViews;
        for (std::size_t v = 0; v < kViews; ++v) {
            const Sampler sampler(m, views[v]);
            const float length = ggx::stretchedLength(m, views[v]);
            for (std::size_t i = 0; i < kEach; ++i) take(sampler, views[v], length, u[v * kEach + i]);
        }
    }
    t.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return t;
}

/// The rounds of both samplers alternate, so that a busy machine slows both; the quickest of each counts.
struct Pair {
    Tally cone, cap;
};
Pair race(const MicroTransform &m, const std::vector<Vec3> &views, const std::vector<Vec2> &u, bool perHit) {
    Pair best;
    for (int i = 0; i < kRounds; ++i) {
        const Tally cone = run<ReflectionSampler>(m, views, u, perHit);
        const Tally cap = run<CapSampler>(m, views, u, perHit);
        if (i == 0 || cone.seconds < best.cone.seconds) best.cone = cone;
        if (i == 0 || cap.seconds < best.cap.seconds) best.cap = cap;
    }
    return best;
}

struct FullCap : CapSampler {
    FullCap(const MicroTransform &m, const Vec3 &wo) : CapSampler(m, wo, false) {}
};

} // namespace

int main() {
    const struct {
        const char *name;
        MicroTransform m;
    } cases[] = {{"[1 2; 0 1]", microTransform(1, 2, 0, 1)},
                 {"alpha (1, 0.1)", microTransformFromAlpha(1, 0.1F)},
                 {"alpha (2, 2)", microTransformFromAlpha(2, 2)},
                 {"alpha (5, 0.3)", microTransformFromAlpha(5, 0.3F)},
                 {"[1 10; 0 1]", microTransform(1, 10, 0, 1)},
                 {"alpha (1, 1)", microTransformFromAlpha(1, 1)},
                 {"alpha (0.5, 0.5)", microTransformFromAlpha(0.5F, 0.5F)},
                 {"alpha (0.5, 0.1)", microTransformFromAlpha(0.5F, 0.1F)},
                 {"alpha (0.1, 0.1)", microTransformFromAlpha(0.1F, 0.1F)}};
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    std::vector<Vec2> u(kSamples);
    for (Vec2 &x : u) x = {uniform(random), uniform(random)};
    std::printf(
        "| M | theta | full cap rejects | bounded rejects | cone rejects | cost ratio, hit | cost ratio, many | ns bounded / cone, hit "
        "| variance ratio |\n|---|---|---|---|---|---|---|---|---|\n");
    for (const auto &[name, m] : cases)
        for (const float theta : {0.0F, 30.0F, 60.0F, 80.0F, 89.0F}) {
            std::vector<Vec3> views(kViews);
            const float sine = std::sin(theta * kPi / 180);
            for (Vec3 &w : views) {
                const float phi = 2 * kPi * uniform(random);
                w = {sine * std::cos(phi), sine * std::sin(phi), std::cos(theta * kPi / 180)};
            }
            const Tally full = run<FullCap>(m, views, u, false);
            const Pair hit = race(m, views, u, true);
            const Pair many = race(m, views, u, false);
            std::printf("| %s | %.0f | %.1f %% | %.1f %% | %.4f %% | %.2f | %.2f | %.0f / %.0f | %.3f |\n", name,
                        static_cast<double>(theta), 100 * full.rejected(), 100 * hit.cap.rejected(), 100 * hit.cone.rejected(),
                        hit.cone.perValid() / hit.cap.perValid(), many.cone.perValid() / many.cap.perValid(), hit.cap.perValid(),
                        hit.cone.perValid(), hit.cone.variance() / hit.cap.variance());
        }
    return 0;
}
