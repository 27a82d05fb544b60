/// taut_reflection_bench: what the reflection sampler wastes, costs and varies beside bounded caps (Eto & Tokuyoshi 2023), in one
/// run. Prints the table of docs/reflection_sampling.md. Per line: share of samples rejected by the full cap, the bounded cap and
/// the cone; cost per valid sample (direction, density and weight) of cone / bounded caps, where every sample has its own wo and
/// prepares anew ("hit") and where one preparation serves many ("many"); variance of one sample's weight, cone / bounded caps,
/// rejected samples counted as zeros.

#include "study/reflection_tally.h"

#include <cstdio>

namespace {

using namespace taut;
using namespace taut::chart;

constexpr int kViews = 512;
constexpr int kSamples = 1 << 18;
constexpr int kRounds = 9;

/// The rounds of both samplers alternate, so that a busy machine slows both; the quickest of each counts.
struct Pair {
    Tally cone, cap;
};
Pair race(const MicroTransform &m, const std::vector<Vec3> &views, const std::vector<Vec2> &u, bool perHit) {
    Pair best;
    for (int i = 0; i < kRounds; ++i) {
        const Tally cone = tallyReflections<ReflectionSampler>(m, views, u, perHit);
        const Tally cap = tallyReflections<BoundedCaps>(m, views, u, perHit);
        if (i == 0 || cone.seconds < best.cone.seconds) best.cone = cone;
        if (i == 0 || cap.seconds < best.cap.seconds) best.cap = cap;
    }
    return best;
}

using FullCaps = Reflected<CapNormals>;

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
    const std::vector<Vec2> u = uniformPairs(kSamples, random);
    std::printf(
        "| M | theta | full cap rejects | bounded rejects | cone rejects | cost ratio, hit | cost ratio, many | ns bounded / cone, hit "
        "| variance ratio |\n|---|---|---|---|---|---|---|---|---|\n");
    for (const auto &[name, m] : cases)
        for (const float theta : {0.0F, 30.0F, 60.0F, 80.0F, 89.0F}) {
            const std::vector<Vec3> views = viewsAt(theta, kViews, random);
            const Tally full = tallyReflections<FullCaps>(m, views, u, false);
            const Pair hit = race(m, views, u, true);
            const Pair many = race(m, views, u, false);
            std::printf("| %s | %.0f | %.1f %% | %.1f %% | %.4f %% | %.2f | %.2f | %.0f / %.0f | %.3f |\n", name,
                        static_cast<double>(theta), 100 * full.rejected(), 100 * hit.cap.rejected(), 100 * hit.cone.rejected(),
                        hit.cone.perValid() / hit.cap.perValid(), many.cone.perValid() / many.cap.perValid(), hit.cap.perValid(),
                        hit.cone.perValid(), hit.cone.variance() / hit.cap.variance());
        }
    return 0;
}
