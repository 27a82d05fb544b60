/// What one hit costs beside a plain GGX, one at a time and in loops over many (batch.h).

#include "study/charts.h"
#include "study/measures/timing.h"
#include "study/microsurface/batch.h"
#include "study/text.h"

#include "taut/base/warp.h"
#include "taut/microsurface/ggx.h"

#include <array>
#include <random>

namespace taut::chart {

namespace {

constexpr std::size_t kHits = 2048; // all of it in the first two caches

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

using Run = std::function<void(Data &)>;
struct Row {
    const char *name;
    Data *data;
    std::array<Run, 3> runs; ///< evaluate, sample, weigh
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
         [i](Data &d) { batch::weight(transforms(d), vectors(d, 5), vectors(d, 8), kHits, true, d.first.data(), i); }}};
}

} // namespace

Chart measureMicrosurface(const ChartOptions &options) {
    constexpr int kRepeats = 8;
    Data diagonal = makeData(false, false);
    Data skewed = makeData(true, false);
    Data leaning = makeData(true, true);
    const std::array<Run, 3> ours{evaluateOurs, sampleOurs, weighOurs};
    std::vector<Row> rows{{"plain (alphaX, alphaY)", &diagonal, {evaluatePlain, samplePlain, weighPlain}},
                          {"M diagonal", &diagonal, ours},
                          {"M skewed", &skewed, ours},
                          {"M leaning", &leaning, ours},
                          batchRow("M leaning, batch SSE2", leaning, Instructions::Sse2)};
    if (has(Instructions::Avx2)) rows.push_back(batchRow("M leaning, batch AVX2", leaning, Instructions::Avx2));
    if (has(Instructions::Avx512)) rows.push_back(batchRow("M leaning, batch AVX-512", leaning, Instructions::Avx512));
    std::vector<std::function<void()>> runs;
    for (const Row &row : rows)
        for (const Run &run : row.runs)
            runs.emplace_back([&run, data = row.data] {
                for (int i = 0; i < kRepeats; ++i) run(*data);
            });
    const std::vector<Measured> seconds = timeInterleaved(runs, options.pick(61, 201), Clock::Thread);
    Table table{"hits",
                "Nanoseconds a hit, medians (+/- half the distance of the quartiles)",
                {"", "eval f cos + pdf", "/ plain", "sample + pdf", "/ plain", "weight", "/ plain"},
                {}};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        table.rows.push_back({rows[i].name});
        for (std::size_t k = 0; k < 3; ++k) {
            const Measured ns = seconds[3 * i + k] * (1e9 / (kRepeats * kHits));
            table.rows.back().push_back(printed("%.2f +/- %.2f", ns.value, ns.spread));
            table.rows.back().push_back(printed("%.2f", seconds[3 * i + k].value / seconds[k].value));
        }
    }
    Chart chart{"microsurface", "One hit, and loops over many",
                "Evaluation, sampling with its density, and the weight of one hit: a plain GGX with (alphaX, alphaY) written the "
                "usual way; the transformed microsurface with diagonal, skewed and leaning M; its loops over many hits for each set "
                "of instructions. Every hit has its own transform and directions; one thread."};
    chart.tables.push_back(std::move(table));
    return chart;
}

} // namespace taut::chart
