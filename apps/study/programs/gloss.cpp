/// taut_gloss_bench. What the Python module is measured against (apps/python/programs/measure.py): gloss of a sheet of a million points
/// that the caller moves, by glossAtFrame(), and the microsurface a row by batch.h. One JSON object.

#include "study/measures/timing.h"
#include "study/microsurface/batch.h"

#include "taut/export/gloss_export.h"
#include "taut/mesh/shapes.h"

#include <nlohmann/json.hpp>

#include <iostream>
#include <random>

namespace {

using namespace taut;
using namespace taut::chart;

constexpr int kSide = 1000; ///< points a side
constexpr int kRounds = 9;
constexpr std::size_t kRows = 1 << 20;

/// Milliseconds a frame, the least of all rounds: what else runs on a machine only adds to it.
double measureGloss() {
    Scene scene;
    scene.materials.emplace_back().type = BsdfType::Conductor;
    Object &object = scene.objects.emplace_back();
    const auto mesh = std::make_shared<const Mesh>(makeGrid(kSide - 1, kSide - 1, 1));
    object.mesh = mesh;
    object.materials = {0};
    std::vector<Vec3> moved = mesh->positions;
    for (Vec3 &p : moved) p.z += 0.1F * std::sin(6 * p.x);
    object.points = pointFrames({moved});
    GlossObject gloss;
    prepareGlossObject(scene, object, gloss);
    double least = kInfinity;
    for (int round = 0; round <= kRounds; ++round) {
        const double start = secondsOf(Clock::Wall);
        glossAtFrame(scene, 1, {}, gloss);
        if (round > 0) least = std::min(least, secondsOf(Clock::Wall) - start);
    }
    return 1e3 * least;
}

/// Nanoseconds a row on one thread, of its processor time.
nlohmann::json measureRows() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::array<std::vector<float>, 13> columns;
    for (auto &column : columns) column.resize(kRows);
    auto &[a, b, d, p, q, ox, oy, oz, ix, iy, iz, ux, uy] = columns;
    for (std::size_t i = 0; i < kRows; ++i) {
        a[i] = 1 + 9 * uniform(random);
        b[i] = 4 * uniform(random) - 2;
        d[i] = 1 + 9 * uniform(random);
        for (auto [x, y, z] : {std::tie(ox, oy, oz), std::tie(ix, iy, iz)}) {
            const Vec3 w = glm::normalize(Vec3(uniform(random) - 0.5F, uniform(random) - 0.5F, 0.1F + uniform(random)));
            x[i] = w.x;
            y[i] = w.y;
            z[i] = w.z;
        }
        ux[i] = uniform(random);
        uy[i] = uniform(random);
    }
    std::vector<float> value(kRows), pdf(kRows), x(kRows), y(kRows), z(kRows);
    const batch::Transforms m{a.data(), b.data(), d.data(), p.data(), q.data()};
    const batch::Vectors wo{ox.data(), oy.data(), oz.data()};
    const batch::Vectors wi{ix.data(), iy.data(), iz.data()};
    const std::array<std::function<void()>, 3> rows{
        [&] { batch::evaluate(m, wo, wi, kRows, true, value.data(), pdf.data()); },
        [&] { batch::weight(m, wo, wi, kRows, true, value.data()); },
        [&] {
            batch::sample(m, wo, ux.data(), uy.data(), kRows, {x.data(), y.data(), z.data()}, pdf.data());
        }};
    const auto seconds = timeInterleaved(rows, kRounds, Clock::Thread);
    const auto nanoseconds = [&](std::size_t row) { return 1e9 * seconds[row].value / static_cast<double>(kRows); };
    return {{"evaluate", nanoseconds(0)}, {"weight", nanoseconds(1)}, {"sample", nanoseconds(2)}};
}

} // namespace

int main() {
    std::cout << nlohmann::json{{"gloss_ms", measureGloss()}, {"ns_a_row", measureRows()}} << std::endl;
}
