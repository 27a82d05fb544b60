/// Loops over many hits against the scalar functions, hit by hit, for every set of instructions that this machine has.

#include "catch.h"

#include "study/microsurface/batch.h"
#include "taut/base/sobol.h"
#include "taut/microsurface/ggx.h"

#include <array>
#include <bit>
#include <random>

using namespace taut;

namespace {

using Floats = std::vector<float>;

/// Random transforms (upright, leaning, squashed, sheared to 1000), directions and numbers; not a whole number of vectors long.
struct Hits {
    static constexpr std::size_t kCount = 20011;
    std::vector<MicroTransform> m;
    std::vector<Vec3> wo, wi;
    std::array<Floats, 5> matrix;
    std::array<Floats, 3> outgoing, incoming;
    Floats ux, uy;

    Hits() {
        std::mt19937 random(5);
        std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
        const auto logarithmic = [&](float from, float to) { return from * std::pow(to / from, uniform(random)); };
        for (std::size_t i = 0; i < kCount; ++i) {
            const bool leans = i % 4 == 3;
            const float skew = i % 3 == 0 ? 0.0F : logarithmic(1e-2F, 1e3F);
            m.push_back(microTransform(logarithmic(0.1F, 1e4F), skew, 0, logarithmic(0.1F, 1e4F), leans ? uniform(random) : 0,
                                       leans ? -uniform(random) : 0));
            const auto direction = [&](float lowest) {
                const float z = lowest + (1 - lowest) * uniform(random);
                return Vec3(std::sqrt(std::fmax(0.0F, 1 - z * z)) * unitCircle(uniform(random)), z);
            };
            wo.push_back(i % 7 == 0 ? direction(-0.7F) : i % 11 == 0 ? glm::normalize(Vec3(1, 0.3F, 1e-4F)) : direction(0));
            wi.push_back(i % 5 == 0 ? direction(-1) : direction(0));
            ux.push_back(uniform(random));
            uy.push_back(uniform(random));
            const MicroTransform &t = m.back();
            const float entries[] = {t.a, t.b, t.d, t.p, t.q};
            for (std::size_t k = 0; k < 5; ++k) matrix[k].push_back(entries[k]);
            for (int k = 0; k < 3; ++k) outgoing[static_cast<std::size_t>(k)].push_back(wo.back()[k]);
            for (int k = 0; k < 3; ++k) incoming[static_cast<std::size_t>(k)].push_back(wi.back()[k]);
        }
    }
    [[nodiscard]] batch::Transforms transforms() const {
        return {matrix[0].data(), matrix[1].data(), matrix[2].data(), matrix[3].data(), matrix[4].data()};
    }
    static batch::Vectors vectors(const std::array<Floats, 3> &v) { return {v[0].data(), v[1].data(), v[2].data()}; }
};

std::vector<Instructions> available() {
    std::vector<Instructions> all;
    for (const auto i : {Instructions::Sse2, Instructions::Avx2, Instructions::Avx512})
        if (has(i)) all.push_back(i);
    return all;
}

/// Largest relative difference; infinite where one is not a number.
double worst(const Floats &a, const Floats &b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!std::isfinite(a[i]) || !std::isfinite(b[i])) return INFINITY;
        const double scale = std::max({std::fabs(static_cast<double>(a[i])), std::fabs(static_cast<double>(b[i])), 1e-37});
        most = std::max(most, std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i])) / scale);
    }
    return most;
}
bool sameBits(const Floats &a, const Floats &b) {
    return std::equal(a.begin(), a.end(), b.begin(),
                      [](float x, float y) { return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y); });
}

constexpr double kTwoUlp = 2.4e-7;

} // namespace

TEST_CASE("Batches evaluate and weigh as the scalar functions do", "[batch]") {
    const Hits hits;
    const std::size_t n = Hits::kCount;
    for (const bool correlated : {true, false}) {
        Floats fCos(n);
        Floats pdf(n);
        Floats weights(n);
        for (std::size_t i = 0; i < n; ++i) {
            const MicroTransform &m = hits.m[i];
            const Vec3 &wo = hits.wo[i];
            const Vec3 &wi = hits.wi[i];
            if (!(wi.z > 0)) continue;
            const float density = ggx::distribution(m, wo, wi);
            const float lengthO = ggx::stretchedLength(m, wo);
            const float lengthI = ggx::stretchedLength(m, wi);
            const float area = ggx::visibleArea(m, wo, lengthO);
            const float shape = wo.z > 0 ? ggx::visibility(wo.z, lengthO, wi.z, lengthI, correlated) : 1 / (area * (wi.z + lengthI));
            fCos[i] = density * shape * wi.z;
            pdf[i] = density * (0.5F / area);
            weights[i] = ggx::reflectionWeight(m, wo, wi, correlated);
        }
        std::vector<Floats> first;
        for (const auto instructions : available()) {
            INFO("instructions " << static_cast<int>(instructions) << ", correlated " << correlated);
            std::vector<Floats> out(3, Floats(n, -1));
            const auto wo = Hits::vectors(hits.outgoing);
            const auto wi = Hits::vectors(hits.incoming);
            batch::evaluate(hits.transforms(), wo, wi, n, correlated, out[0].data(), out[1].data(), instructions);
            batch::weight(hits.transforms(), wo, wi, n, correlated, out[2].data(), instructions);
            CHECK(worst(out[0], fCos) <= 2 * kTwoUlp); // the same factors in another order
            CHECK(worst(out[1], pdf) <= kTwoUlp);
            CHECK(worst(out[2], weights) <= kTwoUlp);
            if (first.empty()) first = out;
            for (std::size_t k = 0; k < 3; ++k) CHECK(sameBits(out[k], first[k]));
        }
        CHECK(*std::max_element(weights.begin(), weights.end()) <= 1.0001F);
    }
}

TEST_CASE("Batches sample as the scalar functions do", "[batch]") {
    const Hits hits;
    const std::size_t n = Hits::kCount;
    std::array<Floats, 4> expected;
    for (std::size_t i = 0; i < n; ++i) {
        const MicroTransform &m = hits.m[i];
        const Vec3 &wo = hits.wo[i];
        const auto [wi, pdf] = ggx::sampleReflection(m, wo, {hits.ux[i], hits.uy[i]});
        for (int c = 0; c < 3; ++c) expected[static_cast<std::size_t>(c)].push_back(wi[c]);
        expected[3].push_back(pdf);
    }
    std::vector<Floats> first;
    for (const auto instructions : available()) {
        INFO("instructions " << static_cast<int>(instructions));
        std::vector<Floats> out(4, Floats(n, -1));
        batch::sample(hits.transforms(), Hits::vectors(hits.outgoing), hits.ux.data(), hits.uy.data(), n,
                      {out[0].data(), out[1].data(), out[2].data()}, out[3].data(), instructions);
        for (std::size_t k = 0; k < 4; ++k) CHECK(worst(out[k], expected[k]) <= kTwoUlp);
        if (first.empty()) first = out;
        for (std::size_t k = 0; k < 4; ++k) CHECK(sameBits(out[k], first[k]));
    }
}

TEST_CASE("A sampled reflection is that of the visible normal, with the density of evaluation", "[batch][microsurface]") {
    const Hits hits;
    for (std::size_t i = 0; i < Hits::kCount; ++i) {
        const MicroTransform &m = hits.m[i];
        const Vec3 &wo = hits.wo[i];
        const Vec2 u(hits.ux[i], hits.uy[i]);
        const float k = ggx::capBound(m, wo);
        const auto [wi, pdf] = ggx::sampleReflection(m, wo, u);
        const Vec3 wm = ggx::sampleVisibleNormal(m, wo, u, k);
        if (glm::length(wi - (2 * glm::dot(wo, wm) * wm - wo)) > 2e-6F) FAIL_CHECK("hit " << i);
        // Where a float tells the micro-normal's tilt: D of a direction is as exact as the direction.
        const float smoothest = 1 / singularValues(m.a, m.b, 0, m.d).x;
        if (pdf == 0 || smoothest < 0.05F) continue;
        const float length = ggx::stretchedLength(m, wo);
        const float base = k < 1 ? k * wo.z + length : ggx::visibleArea(m, wo, length);
        if (std::fabs(pdf / (ggx::distribution(m, wo, wi) / (2 * base)) - 1) > 2e-4F) FAIL_CHECK("hit " << i << ", density " << pdf);
    }
}

TEST_CASE("Batches of any length write what they should and no more", "[batch]") {
    const Hits hits;
    Floats whole(70);
    Floats ignored(70);
    const auto call = [&](std::size_t n, float *fCos, Instructions instructions) {
        batch::evaluate(hits.transforms(), Hits::vectors(hits.outgoing), Hits::vectors(hits.incoming), n, true, fCos, ignored.data(),
                        instructions);
    };
    call(70, whole.data(), Instructions::Sse2);
    for (const auto instructions : available())
        for (std::size_t n = 0; n <= 69; ++n) {
            Floats part(70, -1);
            call(n, part.data(), instructions);
            CHECK(std::equal(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(n), whole.begin()));
            CHECK(std::all_of(part.begin() + static_cast<std::ptrdiff_t>(n), part.end(), [](float x) { return x == -1; }));
        }
    CHECK(has(widest()));
}
