#include "taut/deform/skinning.h"

#include "catch.h"

#include <tbb/global_control.h>

#include <cstring>
#include <random>

using namespace taut;

namespace {

/// 20000 vertices with 0 to 6 influences of 12 joints, and 3 morphs.
struct Fixture {
    std::vector<Vec3> positions;
    SkinWeights skin;
    std::vector<Affine> joints;
    Affine fallback{2, 0, 0, 0, 2, 0, 0, 0, 2, 1, 2, 3};
    std::vector<MorphTarget> morphs;

    Fixture() {
        const std::size_t count = 20000;
        for (int j = 0; j < 12; ++j) joints.emplace_back(vector(), vector(), vector(), vector());
        morphs.resize(3);
        skin.offsets.push_back(0);
        for (std::size_t v = 0; v < count; ++v) {
            positions.push_back(vector());
            for (MorphTarget &morph : morphs) morph.positionDeltas.push_back(vector());
            const int influences = static_cast<int>(v % 7);
            float left = 1;
            for (int k = 0; k < influences; ++k) {
                const float weight = k + 1 == influences ? left : left * (0.5F + 0.5F * uniform());
                left -= weight;
                skin.joints.push_back(static_cast<Index>(engine() % joints.size()));
                skin.weights.push_back(weight);
            }
            skin.offsets.push_back(static_cast<Index>(skin.joints.size()));
        }
    }

  private:
    std::mt19937 engine{7};
    float uniform() { return std::uniform_real_distribution<float>(-1, 1)(engine); }
    Vec3 vector() { return {uniform(), uniform(), uniform()}; }
};

const Fixture &fixture() {
    static const Fixture instance;
    return instance;
}

/// Row by row in double, straight from the definition.
DVec3 skinnedInDouble(const Fixture &f, std::size_t v) {
    DVec3 sum(0);
    const auto apply = [&](const Affine &m, double weight) {
        for (int row = 0; row < 3; ++row) {
            double value = m[3][row];
            for (int column = 0; column < 3; ++column) value += double(m[column][row]) * f.positions[v][column];
            sum[row] += weight * value;
        }
    };
    for (Index k = f.skin.offsets[v]; k < f.skin.offsets[v + 1]; ++k) apply(f.joints[f.skin.joints[k]], f.skin.weights[k]);
    if (f.skin.offsets[v] == f.skin.offsets[v + 1]) apply(f.fallback, 1);
    return sum;
}

bool sameBits(const std::vector<Vec3> &a, const std::vector<Vec3> &b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

/// What f() returns when it may use so many threads.
template <class F> auto withThreads(std::size_t threads, const F &f) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return f();
}

} // namespace

TEST_CASE("Skinned positions are those of the definition in double", "[skinning]") {
    const Fixture &f = fixture();
    std::vector<Vec3> out;
    skinPositions(f.skin, f.joints, f.fallback, f.positions, out);
    REQUIRE(out.size() == f.positions.size());
    double worst = 0;
    for (std::size_t v = 0; v < out.size(); ++v) worst = std::fmax(worst, glm::length(DVec3(out[v]) - skinnedInDouble(f, v)));
    CHECK(worst < 3e-6);
    // A joint by hand: a quarter turn about z, then up by 5.
    SkinWeights one;
    one.offsets = {0, 1, 1};
    one.joints = {0};
    one.weights = {1};
    const std::vector<Affine> quarter{Affine(0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 5)};
    const std::vector<Vec3> two{Vec3(1, 2, 3), Vec3(1, 1, 1)};
    skinPositions(one, quarter, f.fallback, two, out);
    CHECK(out == std::vector<Vec3>{Vec3(-2, 1, 8), Vec3(3, 4, 5)}); // the second follows no joint
}

TEST_CASE("The blended transform is the weighted sum and moves its vertex", "[skinning]") {
    const Fixture &f = fixture();
    std::vector<Vec3> out;
    skinPositions(f.skin, f.joints, f.fallback, f.positions, out);
    for (Index v = 0; v < 50; ++v) {
        const Affine blend = blendedTransform(f.skin, v, f.joints, f.fallback);
        for (int column = 0; column < 4; ++column) {
            DVec3 expected(f.skin.offsets[v] == f.skin.offsets[v + 1] ? DVec3(f.fallback[column]) : DVec3(0));
            for (Index k = f.skin.offsets[v]; k < f.skin.offsets[v + 1]; ++k)
                expected += double(f.skin.weights[k]) * DVec3(f.joints[f.skin.joints[k]][column]);
            CHECK(glm::length(DVec3(blend[column]) - expected) < 1e-6);
        }
        CHECK(blend * Vec4(f.positions[v], 1) == out[v]);
    }
}

TEST_CASE("One matrix for all joints is that matrix for all vertices", "[skinning]") {
    const Fixture &f = fixture();
    const std::vector<Affine> same(f.joints.size(), f.joints[3]);
    std::vector<Vec3> out;
    skinPositions(f.skin, same, f.joints[3], f.positions, out);
    float worst = 0;
    for (std::size_t v = 0; v < out.size(); ++v) worst = std::fmax(worst, glm::length(out[v] - f.joints[3] * Vec4(f.positions[v], 1)));
    CHECK(worst < 2e-6F); // the weights of the fixture sum to 1 up to rounding, and so do a file's
}

TEST_CASE("An unskinned mesh follows the fallback", "[skinning]") {
    std::vector<Vec3> out(1);
    const std::vector<Vec3> two{Vec3(0), Vec3(1)};
    skinPositions(SkinWeights{}, {}, fixture().fallback, two, out);
    CHECK(out == std::vector<Vec3>{Vec3(1, 2, 3), Vec3(3, 4, 5)});
}

TEST_CASE("Morphs add their weighted displacements", "[skinning][morph]") {
    const Fixture &f = fixture();
    const std::vector<float> weights{0.5F, 0, -2};
    std::vector<Vec3> out;
    morphPositions(f.positions, f.morphs, weights, out);
    double worst = 0;
    for (std::size_t v = 0; v < out.size(); ++v) {
        const DVec3 expected =
            DVec3(f.positions[v]) + 0.5 * DVec3(f.morphs[0].positionDeltas[v]) - 2.0 * DVec3(f.morphs[2].positionDeltas[v]);
        worst = std::fmax(worst, glm::length(DVec3(out[v]) - expected));
    }
    CHECK(worst < 1e-6);
    morphPositions(f.positions, f.morphs, {}, out);
    CHECK(sameBits(out, f.positions));
    morphPositions(f.positions, f.morphs, {0, 0, 0, 5}, out);
    CHECK(sameBits(out, f.positions));
    morphPositions({Vec3(1), Vec3(2)}, {MorphTarget{"short", {Vec3(1, 0, 0)}}}, {1}, out);
    CHECK(out == std::vector<Vec3>{Vec3(2, 1, 1), Vec3(2)});
}

TEST_CASE("Skinning and morphs give the same bits for any number of threads, and in place", "[skinning][morph]") {
    const Fixture &f = fixture();
    const auto run = [&] {
        std::vector<Vec3> out;
        morphPositions(f.positions, f.morphs, {0.25F, 0.5F, 1}, out);
        skinPositions(f.skin, f.joints, f.fallback, out, out);
        return out;
    };
    const std::vector<Vec3> alone = withThreads(1, run);
    CHECK(sameBits(alone, withThreads(2, run)));
    CHECK(sameBits(alone, withThreads(7, run)));
    std::vector<Vec3> morphed;
    std::vector<Vec3> apart;
    morphPositions(f.positions, f.morphs, {0.25F, 0.5F, 1}, morphed);
    skinPositions(f.skin, f.joints, f.fallback, morphed, apart);
    CHECK(sameBits(alone, apart));
}

TEST_CASE("A second frame allocates nothing", "[skinning][morph]") {
    const Fixture &f = fixture();
    std::vector<Vec3> out;
    skinPositions(f.skin, f.joints, f.fallback, f.positions, out);
    const Vec3 *const data = out.data();
    skinPositions(f.skin, f.joints, f.fallback, f.positions, out);
    morphPositions(f.positions, f.morphs, {1, 1, 1}, out);
    CHECK(out.data() == data);
}
