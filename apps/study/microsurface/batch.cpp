#include "study/microsurface/batch.h"

#include "taut/microsurface/ggx.h"

namespace taut::batch {

namespace {

// What a loop over hits works on.
struct Evaluation {
    Transforms m;
    Vectors wo, wi;
    std::size_t count;
    bool correlated;
    float *fCos, *pdf, *weights;
};
struct Sampling {
    Transforms m;
    Vectors wo;
    const float *ux, *uy;
    std::size_t count;
    VectorsOut wi;
    float *pdf;
};

#define TAUT_INLINE [[gnu::always_inline]] inline

TAUT_INLINE MicroTransform at(const Transforms &m, std::size_t i) {
    const float a = m.a[i];
    const float d = m.d[i];
    return {a, m.b[i], d, m.p[i], m.q[i], 1 / a, 1 / d, a * d};
}
TAUT_INLINE Vec3 at(const Vectors &v, std::size_t i) {
    return {v.x[i], v.y[i], v.z[i]};
}

// ivdep: what a call writes is not what it reads.
template <bool kCorrelated> TAUT_INLINE void evaluateLoop(const Evaluation &e) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < e.count; ++i) {
        const MicroTransform m = at(e.m, i);
        const Vec3 wo = at(e.wo, i);
        const Vec3 wi = at(e.wi, i);
        const float lengthO = ggx::stretchedLength(m, wo);
        const float area = ggx::visibleArea(m, wo, lengthO);
        const float density = ggx::distribution(m, wo, wi);
        const float pdf = density * (0.5F / area);
        const float fCos = pdf * ggx::reflectionWeight(m, wo, wi, kCorrelated);
        e.fCos[i] = wi.z > 0 ? fCos : 0.0F;
        e.pdf[i] = wi.z > 0 ? pdf : 0.0F;
    }
}

template <bool kCorrelated> TAUT_INLINE void weightLoop(const Evaluation &e) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < e.count; ++i) {
        const MicroTransform m = at(e.m, i);
        const Vec3 wo = at(e.wo, i);
        const Vec3 wi = at(e.wi, i);
        const float weight = ggx::reflectionWeight(m, wo, wi, kCorrelated);
        e.weights[i] = wi.z > 0 ? weight : 0.0F;
    }
}

TAUT_INLINE void sampleLoop(const Sampling &s) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < s.count; ++i) {
        const MicroTransform m = at(s.m, i);
        const auto [wi, pdf] = ggx::sampleReflection(m, at(s.wo, i), {s.ux[i], s.uy[i]});
        s.wi.x[i] = wi.x;
        s.wi.y[i] = wi.y;
        s.wi.z[i] = wi.z;
        s.pdf[i] = pdf;
    }
}

// The loops for one set of instructions; flatten: with everything they call inlined into them.
#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void evaluate(const Evaluation &e) {                                                           \
            e.correlated ? evaluateLoop<true>(e) : evaluateLoop<false>(e);                                                                 \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void weight(const Evaluation &e) {                                                             \
            e.correlated ? weightLoop<true>(e) : weightLoop<false>(e);                                                                     \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void sample(const Sampling &s) { sampleLoop(s); }                                              \
    };

TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

void evaluate(const Transforms &m, const Vectors &wo, const Vectors &wi, std::size_t count, bool correlated, float *fCos, float *pdf,
              Instructions instructions) {
    const Evaluation e{m, wo, wi, count, correlated, fCos, pdf, nullptr};
    onInstructions(instructions, [&](auto loops) { decltype(loops)::evaluate(e); });
}

void weight(const Transforms &m, const Vectors &wo, const Vectors &wi, std::size_t count, bool correlated, float *weights,
            Instructions instructions) {
    const Evaluation e{m, wo, wi, count, correlated, nullptr, nullptr, weights};
    onInstructions(instructions, [&](auto loops) { decltype(loops)::weight(e); });
}

void sample(const Transforms &m, const Vectors &wo, const float *ux, const float *uy, std::size_t count, const VectorsOut &wi, float *pdf,
            Instructions instructions) {
    const Sampling s{m, wo, ux, uy, count, wi, pdf};
    onInstructions(instructions, [&](auto loops) { decltype(loops)::sample(s); });
}

} // namespace taut::batch
