#include "taut/deform/polar_batch.h"

#include "catch.h"

#include <cstring>
#include <memory>
#include <random>

using namespace taut;

TEST_CASE("The polar split of a block has the bits of the split one by one, for every set of instructions", "[surface][batch]") {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    auto block = std::make_unique<PolarBlock>();
    std::vector<PolarGradient> expected;
    for (std::size_t i = 0; i < PolarBlock::kSize; ++i) {
        const Vec3 n = glm::normalize(vector());
        Vec3 f1 = vector();
        Vec3 f2 = vector();
        Vec4 k(1, 0.3F, -0.2F, i % 2 == 0 ? 0.9F : -0.9F);
        if (i % 8 == 3) f2 = f1 * 2.0F; // collapsed to a line
        if (i % 8 == 5) f1 = f2 = Vec3(0);
        if (i % 8 == 6) k *= 1e-12F;
        f1 -= n * glm::dot(n, f1);
        f2 -= n * glm::dot(n, f2);
        block->set(i, f1, f2, n, k);
        expected.push_back(polarGradient(f1 * k.x + f2 * k.y, f1 * k.z + f2 * k.w, n));
    }
    for (const Instructions set : {Instructions::Sse2, Instructions::Avx2, Instructions::Avx512}) {
        if (!has(set)) continue;
        splitPolar(*block, set);
        for (std::size_t i = 0; i < PolarBlock::kSize; ++i) {
            const PolarGradient got = block->at(i);
            INFO("set " << static_cast<int>(set) << ", vertex " << i);
            CHECK(got.stretch.diagonal == expected[i].stretch.diagonal);
            CHECK(got.stretch.offDiagonal == expected[i].stretch.offDiagonal);
            CHECK(got.tangent == expected[i].tangent);
            CHECK(glm::length(Vec3(got.tangent)) == Approx(1).epsilon(1e-5));
        }
    }
}
