/// taut_microsurface_bench: nanoseconds per evaluation, sample + density and weight of one hit, in one run: a plain GGX with
/// (alphaX, alphaY) written the usual way, the transformed microsurface with diagonal, skewed and leaning M, and its loops over many
/// hits for each set of instructions. Every hit has its own transform and directions. Rounds of all rows alternate, so that a busy
/// machine slows all; printed are the median over the rounds and its distance to the lower and upper quartile.

#include "taut/base/sobol.h"
#include "study/batch.h"
#include "taut/microsurface/ggx.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace taut;

constexpr std::size_t kHits = 2048; // all of it in the first two caches
constexpr int kRounds = 201;
constexpr int kRepeats = 8;

/// GGX with (alphaX, alphaY), the usual way: Heitz 2014 and 2018, unit half vectors, no common factors shared with the transformed one.
namespace plain {

struct Ggx {
    float alphaX, alphaY;
};

float distribution(const Ggx &g, const Vec3 &wm) {
    const float x = wm.x / g.alphaX;
    const float y = wm.y / g.alphaY;
    const float e = x * x + y * y + wm.z * wm.z;
    return 1 / (kPi * g.alphaX * g.alphaY * e * e);
}
float stretched(const Ggx &g, const Vec3 &w) {
    return std::sqrt(sqr(g.alphaX * w.x) + sqr(g.alphaY * w.y) + w.z * w.z);
}
/// f cos and the density of visible-normal reflection.
void evaluate(const Ggx &g, const Vec3 &wo, const Vec3 &wi, float &fCos, float &pdf) {
    const float d = distribution(g, glm::normalize(wo + wi));
    const float lengthO = stretched(g, wo);
    fCos = d / (2 * (wo.z * stretched(g, wi) + wi.z * lengthO)) * wi.z;
    pdf = d / (2 * (wo.z + lengthO));
}
float weight(const Ggx &g, const Vec3 &wo, const Vec3 &wi) {
    const float lengthO = stretched(g, wo);
    return wi.z * (wo.z + lengthO) / (wo.z * stretched(g, wi) + wi.z * lengthO);
}
/// Heitz 2018: the view stretched, a disk warped, and back.
Vec3 sample(const Ggx &g, const Vec3 &wo, const Vec2 &u, float &pdf) {
    const Vec3 v = glm::normalize(Vec3(g.alphaX * wo.x, g.alphaY * wo.y, wo.z));
    const float across = v.x * v.x + v.y * v.y;
    const Vec3 t1 = across > 0 ? Vec3(-v.y, v.x, 0) / std::sqrt(across) : Vec3(1, 0, 0);
    const Vec3 t2 = glm::cross(v, t1);
    const float r = std::sqrt(u.x);
    const float phi = 2 * kPi * u.y;
    const float p1 = r * std::cos(phi);
    const float s = 0.5F * (1 + v.z);
    const float p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * std::sin(phi);
    const Vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0F, 1 - p1 * p1 - p2 * p2)) * v;
    const Vec3 wm = glm::normalize(Vec3(g.alphaX * n.x, g.alphaY * n.y, std::max(0.0F, n.z)));
    const Vec3 wi = 2 * glm::dot(wo, wm) * wm - wo;
    pdf = wi.z > 0 ? distribution(g, wm) / (2 * (wo.z + stretched(g, wo))) : 0.0F;
    return wi;
}

} // namespace plain

/// Inputs, one a hit, and where results go.
struct Data {
    std::vector<plain::Ggx> plain;
    std::vector<MicroTransform> m;
    std::vector<Vec3> wo, wi, out;
    std::vector<Vec2> u;
    std::vector<float> first, second;
    std::vector<float> columns[16]; ///< the same as arrays: a b d p q, wo, wi, u, out
};

/// `skewed` and `leaning` say what the transforms have beside their diagonal; alpha from 0.05 to 1.
Data makeData(bool skewed, bool leaning) {
    Data data;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    const auto direction = [&] {
        const float z = 0.05F + 0.95F * uniform(random);
        return Vec3(std::sqrt(1 - z * z) * unitCircle(uniform(random)), z);
    };
    for (std::size_t i = 0; i < kHits; ++i) {
        const float alphaX = 0.05F + 0.95F * uniform(random);
        const float alphaY = 0.05F + 0.95F * uniform(random);
        const float b = (2 * uniform(random) - 1) / alphaX;
        const float p = uniform(random) - 0.5F;
        const float q = uniform(random) - 0.5F;
        data.plain.push_back({alphaX, alphaY});
        data.m.push_back(microTransform(1 / alphaX, skewed ? b : 0, 0, 1 / alphaY, leaning ? p : 0, leaning ? q : 0));
        data.wo.push_back(direction());
        data.wi.push_back(direction());
        data.u.emplace_back(uniform(random), uniform(random));
        const MicroTransform &m = data.m.back();
        const float entries[] = {
            m.a,         m.b,         m.d, m.p, m.q, data.wo[i].x, data.wo[i].y, data.wo[i].z, data.wi[i].x, data.wi[i].y, data.wi[i].z,
            data.u[i].x, data.u[i].y, 0,   0,   0};
        for (std::size_t k = 0; k < 16; ++k) data.columns[k].push_back(entries[k]);
    }
    data.out.resize(kHits);
    data.first.resize(kHits);
    data.second.resize(kHits);
    return data;
}

void evaluatePlain(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) plain::evaluate(d.plain[i], d.wo[i], d.wi[i], d.first[i], d.second[i]);
}
void samplePlain(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) d.out[i] = plain::sample(d.plain[i], d.wo[i], d.u[i], d.first[i]);
}
void weighPlain(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) d.first[i] = plain::weight(d.plain[i], d.wo[i], d.wi[i]);
}

void evaluateOurs(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) {
        const MicroTransform &m = d.m[i];
        const Vec3 &wo = d.wo[i];
        const Vec3 &wi = d.wi[i];
        const float density = ggx::distribution(m, wo, wi);
        const float length = ggx::stretchedLength(m, wo);
        d.first[i] = density * ggx::visibility(wo.z, length, wi.z, ggx::stretchedLength(m, wi), true) * wi.z;
        d.second[i] = density * 0.5F / ggx::visibleArea(m, wo, length);
    }
}
void sampleOurs(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) {
        const auto r = ggx::sampleReflection(d.m[i], d.wo[i], d.u[i]);
        d.out[i] = r.wi;
        d.first[i] = r.pdf;
    }
}
void weighOurs(Data &d) {
    for (std::size_t i = 0; i < kHits; ++i) d.first[i] = ggx::reflectionWeight(d.m[i], d.wo[i], d.wi[i], true);
}

batch::Transforms transforms(Data &d) {
    return {d.columns[0].data(), d.columns[1].data(), d.columns[2].data(), d.columns[3].data(), d.columns[4].data()};
}
batch::Vectors vectors(Data &d, std::size_t k) {
    return {d.columns[k].data(), d.columns[k + 1].data(), d.columns[k + 2].data()};
}

struct Row {
    std::string name;
    Data *data;
    std::function<void(Data &)> calls[3]; ///< evaluate, sample, weigh
    std::vector<double> times[3];
};

Row batchRow(const char *name, Data &data, Instructions i) {
    return {
        name,
        &data,
        {[i](Data &d) { batch::evaluate(transforms(d), vectors(d, 5), vectors(d, 8), kHits, true, d.first.data(), d.second.data(), i); },
         [i](Data &d) {
             batch::sample(transforms(d), vectors(d, 5), d.columns[11].data(), d.columns[12].data(), kHits,
                           {d.columns[13].data(), d.columns[14].data(), d.columns[15].data()}, d.first.data(), i);
         },
         [i](Data &d) { batch::weight(transforms(d), vectors(d, 5), vectors(d, 8), kHits, true, d.first.data(), i); }},
        {}};
}

double quantile(std::vector<double> &sorted, double q) {
    return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

} // namespace

int main() {
    Data diagonal = makeData(false, false);
    Data skewed = makeData(true, false);
    Data leaning = makeData(true, true);
    std::vector<Row> rows{{"plain (alphaX, alphaY)", &diagonal, {evaluatePlain, samplePlain, weighPlain}, {}},
                          {"M diagonal", &diagonal, {evaluateOurs, sampleOurs, weighOurs}, {}},
                          {"M skewed", &skewed, {evaluateOurs, sampleOurs, weighOurs}, {}},
                          {"M leaning", &leaning, {evaluateOurs, sampleOurs, weighOurs}, {}},
                          batchRow("M leaning, batch SSE2", leaning, Instructions::Sse2)};
    if (has(Instructions::Avx2)) rows.push_back(batchRow("M leaning, batch AVX2", leaning, Instructions::Avx2));
    if (has(Instructions::Avx512)) rows.push_back(batchRow("M leaning, batch AVX-512", leaning, Instructions::Avx512));
    for (int round = 0; round < kRounds; ++round)
        for (Row &row : rows)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto start = std::chrono::steady_clock::now();
                for (int i = 0; i < kRepeats; ++i) row.calls[k](*row.data);
                const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
                row.times[k].push_back(1e9 * seconds / (kRepeats * kHits));
            }
    std::printf("| ns per hit, median (-/+ to the quartiles) | eval f cos + pdf | / plain | sample + pdf | / plain | weight | / plain |\n"
                "|---|---|---|---|---|---|---|\n");
    double reference[3] = {};
    for (Row &row : rows) {
        std::printf("| %s", row.name.c_str());
        for (std::size_t k = 0; k < 3; ++k) {
            std::sort(row.times[k].begin(), row.times[k].end());
            const double median = quantile(row.times[k], 0.5);
            if (&row == rows.data()) reference[k] = median;
            std::printf(" | %.2f (-%.2f +%.2f) | %.2f", median, median - quantile(row.times[k], 0.25),
                        quantile(row.times[k], 0.75) - median, median / reference[k]);
        }
        std::printf(" |\n");
    }
    return 0;
}
