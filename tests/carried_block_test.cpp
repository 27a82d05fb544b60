/// Vertices that a placement and deformers carry, many at once: the bits of one by one, for every set of instructions.

#include "catch.h"
#include "deformer_fixtures.h"

#include "taut/base/frame.h"
#include "taut/deform/carried_block.h"
#include "taut/deform/surface_normal.h"

using namespace taut;
using namespace taut::test::deformers;

namespace {

struct One {
    Vec3 position, f1, f2, image, normal;
    int side = 1;
};

/// The chain, a vertex at a time.
One carryOne(const CarryingMap &map, const Vec3 &rest, const Vec3 &restNormal) {
    const Frame frame = quickFrameFromNormal(restNormal);
    One v{
        transformPoint(map.carrier, rest), map.carrierFromRest * frame.s, map.carrierFromRest * frame.t, map.carrierFromRest * frame.n, {}};
    if (!map.deformers.empty()) {
        DVec3 x(v.position);
        DVec3 directions[3] = {DVec3(v.f1), DVec3(v.f2), DVec3(v.image)};
        for (const Deformer &deformer : map.deformers) {
            const DeformedPoint image = deform(deformer, x);
            v.side *= orientationOf(image.jacobian);
            x = image.position;
            for (DVec3 &d : directions) d = image.jacobian * d;
        }
        for (DVec3 &d : directions) d = DMat3(map.renderFromDeformed) * d;
        v.position = Vec3(DVec3(map.renderFromDeformed * DVec4(x, 1)));
        v.f1 = Vec3(directions[0]);
        v.f2 = Vec3(directions[1]);
        v.image = Vec3(directions[2]);
    }
    v.normal = normalOf(v.f1, v.f2, v.image);
    return v;
}

} // namespace

TEST_CASE("Carried vertices: a block has the bits of one by one, for every set of instructions and deformer", "[surface][batch]") {
    Random random;
    const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
    for (int trial = 0; trial < 60; ++trial) {
        std::vector<Deformer> deformers;
        for (int k = trial % 4; k > 0; --k) {
            const DeformerType type = kTypes[static_cast<std::size_t>((trial / 4 + 2 * k) % 7)];
            if (type != DeformerType::Lattice) deformers.push_back(deformerAtFrame(randomKeys(type, random), 1));
        }
        CarryingMap map;
        const float scale = trial % 9 == 8 ? 1e20F : 1; // areas leave float
        for (int c = 0; c < 4; ++c) map.carrier[c] = Vec3(number(2), number(2), number(2)) * scale;
        map.carrierFromRest = linearOf(map.carrier);
        if (trial % 7 == 6) map.carrierFromRest[2] = map.carrierFromRest[0]; // flat: some parallelograms collapse
        if (trial % 10 == 9) map.carrierFromRest = Mat3(0);
        map.deformers = deformers;
        map.renderFromDeformed = DMat4(1);
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 3; ++r) map.renderFromDeformed[c][r] += random.uniform(-1, 1);
        CarriedBlock block;
        for (std::size_t i = 0; i < CarriedBlock::kSize; ++i) {
            block.rest.set(i, Vec3(number(1), number(1), number(1)));
            block.restNormal.set(i, glm::normalize(Vec3(number(1), number(1), number(1) + 1e-3F)));
        }
        for (const Instructions set : {Instructions::Sse2, Instructions::Avx2, Instructions::Avx512}) {
            if (!has(set)) continue;
            CarriedBlock out = block;
            carry(map, out, set);
            for (std::size_t i = 0; i < CarriedBlock::kSize; ++i) {
                const One one = carryOne(map, block.rest.at(i), block.restNormal.at(i));
                const bool same = out.position.at(i) == one.position && out.f1.at(i) == one.f1 && out.f2.at(i) == one.f2 &&
                                  out.image.at(i) == one.image && out.side[i] == one.side;
                const float area = glm::length(glm::cross(one.f1, one.f2));
                const bool collapsed = !std::isfinite(area) || isCollapsed(area, one.f1, one.f2);
                if (!same || (out.upright[i] > 0) == collapsed || (!collapsed && out.normal.at(i) != one.normal))
                    FAIL("trial " << trial << ", vertex " << i);
            }
        }
    }
}
