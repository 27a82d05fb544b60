#include "catch.h"
#include "deformer_fixtures.h"

#include <limits>

using namespace taut;
using namespace taut::test::deformers;

namespace {

/// Whether a coordinate of `p` lies so near an end of the deformer's range that a difference would straddle the kink.
bool isNearKink(const DeformerKeys &keys, const DVec3 &p, double distance) {
    if (keys.type == DeformerType::Lattice) {
        for (int axis = 0; axis < 3; ++axis)
            if (std::fabs(p[axis] - keys.latticeLower[axis]) < distance || std::fabs(p[axis] - keys.latticeUpper[axis]) < distance)
                return true;
        return false;
    }
    const double z = p[keys.axis] - keys.centre[keys.axis];
    return std::fabs(z - keys.lower) < distance || std::fabs(z - keys.upper) < distance;
}

DMat3 centralDifferences(const Deformer &deformer, const DVec3 &p) {
    DMat3 jacobian;
    for (int axis = 0; axis < 3; ++axis) {
        DVec3 forward = p;
        DVec3 backward = p;
        forward[axis] += 4e-6;
        backward[axis] -= 4e-6;
        jacobian[axis] = (deform(deformer, forward).position - deform(deformer, backward).position) / (forward[axis] - backward[axis]);
    }
    return jacobian;
}

double norm(const DMat3 &m) {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

} // namespace

TEST_CASE("The Jacobian of every deformer is that of central differences", "[deformer]") {
    Random random;
    for (const DeformerType type : kTypes) {
        CAPTURE(static_cast<int>(type));
        double worst = 0;
        int tested = 0;
        for (int trial = 0; trial < 100; ++trial) {
            const DeformerKeys keys = randomKeys(type, random);
            const Deformer deformer = deformerAtFrame(keys, 0);
            for (int sample = 0; sample < 40; ++sample) {
                const DVec3 p = random.point(-1.5, 1.5);
                if (isNearKink(keys, p, 1e-5)) continue;
                const DMat3 exact = deform(deformer, p).jacobian;
                worst = std::fmax(worst, norm(exact - centralDifferences(deformer, p)) / std::fmax(norm(exact), 1e-3));
                ++tested;
            }
        }
        CHECK(tested > 3900);
        CHECK(worst < 1e-7);
    }
}

TEST_CASE("Stretch scales about its centre", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Stretch);
    keys.centre = {1, 2, 3};
    keys.factor = DVec3(2, 0.5, 1);
    const DeformedPoint image = deform(deformerAtFrame(keys, 0), {2, 4, 7});
    CHECK(image.position == DVec3(3, 3, 7));
    CHECK(image.jacobian == DMat3(2, 0, 0, 0, 0.5, 0, 0, 0, 1));
}

TEST_CASE("Shear displaces one coordinate by another", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Shear);
    keys.axis = 0;
    keys.axis2 = 1;
    keys.centre = {5, 1, 0};
    keys.amount = 0.5;
    const DeformedPoint image = deform(deformerAtFrame(keys, 0), {1, 3, 2});
    CHECK(image.position == DVec3(2, 3, 2));
    CHECK(image.jacobian[1] == DVec3(0.5, 1, 0)); // dD/dy
    CHECK(glm::determinant(image.jacobian) == 1);
}

TEST_CASE("A bent bar is a piece of a ring with straight ends", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Bend); // along z, towards x
    keys.centre = {1, 2, 3};
    keys.lower = 0;
    keys.upper = 2;
    keys.amount = kPiD / 2;
    const double radius = 2 / (kPiD / 2);
    const Deformer deformer = deformerAtFrame(keys, 0);
    const auto image = [&](double x, double y, double z) { return deform(deformer, keys.centre + DVec3(x, y, z)).position - keys.centre; };
    CHECK(maxDifference(image(0, 0, 0), {0, 0, 0}) < 1e-14);
    CHECK(maxDifference(image(0.3, -0.4, -1), {0.3, -0.4, -1}) < 1e-14);   // before the range nothing moves
    CHECK(maxDifference(image(0, 0, 2), {radius, 0, radius}) < 1e-14);     // a quarter of the ring
    CHECK(maxDifference(image(0, 0, 5), {radius + 3, 0, radius}) < 1e-14); // then straight on along +x
    CHECK(maxDifference(image(radius, 7, 1.234), {radius, 7, 0}) < 1e-14); // the ring's axis does not move
    CHECK(maxDifference(image(0.25, 0, 2), {radius, 0, radius - 0.25}) < 1e-14);
    CHECK(glm::determinant(deform(deformer, keys.centre + DVec3(0.25, 1, 1)).jacobian) == Approx(1 - 0.25 / radius).epsilon(1e-14));

    keys.lower = -1; // the centre stays level inside the range, and both halves bend
    keys.upper = 1;
    const Deformer both = deformerAtFrame(keys, 0);
    const DVec3 up = deform(both, keys.centre + DVec3(0, 0, 1)).position - keys.centre;
    const DVec3 down = deform(both, keys.centre - DVec3(0, 0, 1)).position - keys.centre;
    CHECK(up.x == Approx(radius * (1 - std::cos(kPiD / 4))).epsilon(1e-14));
    CHECK(up.z == Approx(radius * std::sin(kPiD / 4)).epsilon(1e-14));
    CHECK(maxDifference(down, {up.x, 0, -up.z}) < 1e-14);
    CHECK(maxDifference(deform(both, keys.centre).jacobian, DMat3(1)) < 1e-15);
}

TEST_CASE("Bend keeps arc length along its centre line, and right angles to it", "[deformer]") {
    Random random;
    for (int trial = 0; trial < 50; ++trial) {
        const DeformerKeys keys = randomKeys(DeformerType::Bend, random);
        const Deformer deformer = deformerAtFrame(keys, 0);
        // Polyline of n chords; the length of a chord of angle a is short by a^2 / 24 of itself.
        const int n = 4000;
        double length = 0;
        DVec3 previous(0);
        for (int i = 0; i <= n; ++i) {
            DVec3 p = keys.centre;
            p[keys.axis] += -2.0 + 4.0 * i / n;
            const DeformedPoint image = deform(deformer, p);
            if (i > 0) length += glm::distance(image.position, previous);
            previous = image.position;
            if (i % 100 == 0) CHECK(maxDifference(glm::transpose(image.jacobian) * image.jacobian, DMat3(1)) < 1e-13);
        }
        CHECK(length == Approx(4.0).epsilon(1e-6));
    }
}

TEST_CASE("The ends of a bend go on along the tangent", "[deformer]") {
    Random random;
    for (int trial = 0; trial < 50; ++trial) {
        const DeformerKeys keys = randomKeys(DeformerType::Bend, random);
        const Deformer deformer = deformerAtFrame(keys, 0);
        for (const double end : {keys.lower, keys.upper}) {
            DVec3 p = keys.centre;
            p[keys.axis] += end;
            DVec3 step(0);
            step[keys.axis] = 1e-9;
            // On the centre line the map is C1.
            CHECK(maxDifference(deform(deformer, p - step).jacobian, deform(deformer, p + step).jacobian) < 1e-7);
            CHECK(maxDifference(deform(deformer, p - step).position, deform(deformer, p + step).position) < 1e-7);
            // Beside it fibres keep their direction (G1) while their pace changes from 1 - r * curvature to 1.
            DVec3 beside = p + random.point(-0.1, 0.1);
            beside[keys.axis] = p[keys.axis];
            const DMat3 before = deform(deformer, beside - step).jacobian;
            const DMat3 after = deform(deformer, beside + step).jacobian;
            CHECK(maxDifference(deform(deformer, beside - step).position, deform(deformer, beside + step).position) < 1e-7);
            CHECK(maxDifference(glm::normalize(before[keys.axis]), glm::normalize(after[keys.axis])) < 1e-7);
            CHECK(maxDifference(before[keys.axis2], after[keys.axis2]) < 1e-7);
            // Outside: a rigid motion.
            DVec3 outside = random.point(-0.5, 0.5);
            outside[keys.axis] = keys.centre[keys.axis] + (end == keys.upper ? keys.upper + 0.7 : keys.lower - 0.7);
            const DMat3 rigid = deform(deformer, outside).jacobian;
            CHECK(maxDifference(glm::transpose(rigid) * rigid, DMat3(1)) < 1e-14);
            CHECK(glm::determinant(rigid) == Approx(1).epsilon(1e-14));
        }
    }
}

TEST_CASE("Twist, taper and lattice are continuous over the ends of their ranges", "[deformer]") {
    Random random;
    for (const DeformerType type : {DeformerType::Twist, DeformerType::Taper, DeformerType::Lattice})
        for (int trial = 0; trial < 50; ++trial) {
            const DeformerKeys keys = randomKeys(type, random);
            const Deformer deformer = deformerAtFrame(keys, 0);
            const bool lattice = type == DeformerType::Lattice;
            for (const double end : {lattice ? keys.latticeLower[keys.axis] : keys.centre[keys.axis] + keys.lower,
                                     lattice ? keys.latticeUpper[keys.axis] : keys.centre[keys.axis] + keys.upper}) {
                DVec3 p = random.point(-1, 1);
                p[keys.axis] = end;
                DVec3 step(0);
                step[keys.axis] = 1e-9;
                CHECK(maxDifference(deform(deformer, p - step).position, deform(deformer, p + step).position) < 1e-7);
            }
        }
}

TEST_CASE("Small bends are smooth in the amount", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Bend);
    keys.lower = 0;
    keys.upper = 2;
    const DVec3 p(0.5, 0.25, 1.5);
    for (const double amount : {1e-1, 1e-3, 1e-5, 1e-8, 1e-12, 1e-300}) {
        keys.amount = amount;
        const DeformedPoint image = deform(deformerAtFrame(keys, 0), p);
        // Series of the displacement in the angle t at z = 1.5: the terms left out are of the order t^5.
        const double t = amount * 0.75;
        const double towards = 1.5 * (t / 2 - t * t * t / 24) - 0.5 * (t * t / 2 - t * t * t * t / 24);
        const double along = -1.5 * (t * t / 6 - t * t * t * t / 120) - 0.5 * (t - t * t * t / 6);
        CHECK(std::fabs(image.position.x - 0.5 - towards) < 2e-16 + std::pow(t, 5));
        CHECK(std::fabs(image.position.z - 1.5 - along) < 4e-16 + std::pow(t, 5));
        CHECK(std::fabs(image.jacobian[2][0] - std::sin(t) * (1 - 0.25 * amount)) <= 1e-15 * t);
    }
}

TEST_CASE("Every deformer tends to the identity with its amount", "[deformer]") {
    Random random;
    for (const DeformerType type : {DeformerType::Shear, DeformerType::Bend, DeformerType::Twist, DeformerType::Taper, DeformerType::Wave})
        for (const double amount : {1e-6, 1e-9, 1e-13, 0.0})
            for (int trial = 0; trial < 20; ++trial) {
                DeformerKeys keys = randomKeys(type, random);
                keys.amount = amount;
                keys.amplitude = amount;
                const DVec3 p = random.point(-1, 1);
                const DeformedPoint image = deform(deformerAtFrame(keys, 0), p);
                // No map moves more than 20 lengths per unit of amount; centre and position add rounding of their own.
                CHECK(maxDifference(image.position, p) <= 20 * amount + 5e-16);
                CHECK(maxDifference(image.jacobian, DMat3(1)) <= 20 * amount);
            }
}

TEST_CASE("Twist turns each section and keeps volume", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Twist);
    keys.centre = {1, 0, 0};
    keys.lower = 0;
    keys.upper = 2;
    keys.amount = kPiD;
    const Deformer deformer = deformerAtFrame(keys, 0);
    CHECK(maxDifference(deform(deformer, {2, 0, 1}).position, {1, 1, 1}) < 1e-15);   // a quarter turn, x towards y
    CHECK(maxDifference(deform(deformer, {2, 0, 9}).position, {0, 0, 9}) < 1e-15);   // a half turn above the range
    CHECK(maxDifference(deform(deformer, {2, 0, -9}).position, {2, 0, -9}) < 1e-15); // none below
    Random random;
    for (int trial = 0; trial < 500; ++trial) {
        const Deformer other = deformerAtFrame(randomKeys(DeformerType::Twist, random), 0);
        CHECK(glm::determinant(deform(other, random.point(-2, 2)).jacobian) == Approx(1).epsilon(1e-13));
    }
}

TEST_CASE("Taper scales the cross-section from 1 to 1 + amount", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Taper);
    keys.axis = 1;
    keys.centre = {1, 1, 1};
    keys.lower = -1;
    keys.upper = 3;
    keys.amount = -0.5;
    const Deformer deformer = deformerAtFrame(keys, 0);
    CHECK(deform(deformer, {3, -7, 5}).position == DVec3(3, -7, 5));
    CHECK(deform(deformer, {3, 2, 5}).position == DVec3(2.5, 2, 4)); // halfway: 0.75
    CHECK(deform(deformer, {3, 4, 5}).position == DVec3(2, 4, 3));
    CHECK(deform(deformer, {3, 9, 5}).position == DVec3(2, 9, 3));
    CHECK(deform(deformer, {3, 2, 5}).jacobian[1] == DVec3(-0.25, 1, -0.5));
}

TEST_CASE("Wave displaces by a sine", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Wave);
    keys.axis = 0;
    keys.axis2 = 2;
    keys.centre = {1, 0, 0};
    keys.amplitude = 0.5;
    keys.wavelength = 4.0;
    const DeformedPoint crest = deform(deformerAtFrame(keys, 0), {2, 3, 1});
    CHECK(maxDifference(crest.position, {2, 3, 1.5}) < 1e-15);
    CHECK(maxDifference(crest.jacobian, DMat3(1)) < 1e-15);
    const DeformedPoint node = deform(deformerAtFrame(keys, 0), {1, 3, 1});
    CHECK(maxDifference(node.position, {1, 3, 1}) < 1e-15);
    CHECK(node.jacobian[0][2] == Approx(0.5 * 2 * kPiD / 4));
    keys.phase = kPiD / 2;
    CHECK(maxDifference(deform(deformerAtFrame(keys, 0), {1, 3, 1}).position, {1, 3, 1.5}) < 1e-15);
}

TEST_CASE("Parameters follow their keys", "[deformer]") {
    DeformerKeys keys = keysOf(DeformerType::Shear);
    keys.axis = 0;
    keys.axis2 = 1;
    keys.amount.keys = {{1, 0.0}, {49, 1.2}};
    CHECK(deformerAtFrame(keys, -5).amount == 0);
    CHECK(deformerAtFrame(keys, 25).amount == Approx(0.6));
    CHECK(deformerAtFrame(keys, 60).amount == 1.2);
    CHECK(isIdentity(deformerAtFrame(keys, 1)));
    CHECK_FALSE(isIdentity(deformerAtFrame(keys, 2)));

    DeformerKeys lattice = latticeKeys({2, 2, 2}, DVec3(0), DVec3(1), [](const DVec3 &p) { return p; });
    lattice.latticeOffsets[7].keys = {{0, DVec3(0)}, {10, DVec3(1, 0, 0)}};
    CHECK(isIdentity(deformerAtFrame(lattice, 0)));
    CHECK_FALSE(isIdentity(deformerAtFrame(lattice, 5)));
    CHECK(maxDifference(deform(deformerAtFrame(lattice, 5), DVec3(1)).position, {1.5, 1, 1}) < 1e-15);
}

TEST_CASE("The identity is recognised for every type, and only it", "[deformer]") {
    Random random;
    for (const DeformerType type : kTypes) {
        CAPTURE(static_cast<int>(type));
        DeformerKeys keys = randomKeys(type, random);
        CHECK_FALSE(isIdentity(deformerAtFrame(keys, 0)));
        keys.factor = DVec3(1);
        keys.amount = 0.0;
        keys.amplitude = 0.0;
        for (auto &offset : keys.latticeOffsets) offset = DVec3(0);
        const Deformer identity = deformerAtFrame(keys, 0);
        REQUIRE(isIdentity(identity));
        for (int trial = 0; trial < 50; ++trial) {
            const DVec3 p = random.point(-2, 2);
            const DeformedPoint image = deform(identity, p);
            CHECK(maxDifference(image.position, p) < 2e-15);
            CHECK(maxDifference(image.jacobian, DMat3(1)) < 3e-14);
        }
    }
}

TEST_CASE("A degenerate range or box is the identity, never a NaN", "[deformer]") {
    Random random;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const DeformerType type :
         {DeformerType::Bend, DeformerType::Twist, DeformerType::Taper, DeformerType::Lattice, DeformerType::Wave})
        for (const double extent : {0.0, -1.0, nan}) {
            CAPTURE(static_cast<int>(type), extent);
            DeformerKeys keys = randomKeys(type, random);
            keys.upper = keys.lower + extent;
            keys.wavelength = extent;
            keys.latticeUpper.y = keys.latticeLower.y + extent;
            const Deformer deformer = deformerAtFrame(keys, 0);
            CHECK(isIdentity(deformer));
            for (const double z : {-2.0, keys.lower, 0.0, 2.0}) {
                const DeformedPoint image = deform(deformer, DVec3(z));
                CHECK(image.position == DVec3(z));
                CHECK(image.jacobian == DMat3(1));
            }
        }
    DeformerKeys keys = randomKeys(DeformerType::Lattice, random);
    for (const int points : {-1, 0, 1, 17, std::numeric_limits<int>::max()}) {
        keys.latticePoints = {points, 2, 2};
        CHECK(isIdentity(deformerAtFrame(keys, 0)));
    }
}
