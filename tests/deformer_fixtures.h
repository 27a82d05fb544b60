#pragma once
/// What the tests of the deformers share: random parameters, lattices from a map, largest differences.

#include "taut/deform/deformer.h"

#include <array>
#include <random>

namespace taut::test::deformers {

inline constexpr double kPiD = 3.14159265358979323846;

class Random {
  public:
    double uniform(double lower, double upper) { return lower + (upper - lower) * std::uniform_real_distribution<double>(0, 1)(engine_); }
    int below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine_); }
    DVec3 point(double lower, double upper) { return {uniform(lower, upper), uniform(lower, upper), uniform(lower, upper)}; }

  private:
    std::mt19937_64 engine_{20240607};
};

inline DeformerKeys keysOf(DeformerType type) {
    DeformerKeys keys;
    keys.type = type;
    return keys;
}

/// A lattice over a box with `points` and the offsets that move each control point P to image(P).
template <class F> DeformerKeys latticeKeys(const std::array<int, 3> &points, const DVec3 &lower, const DVec3 &upper, const F &image) {
    DeformerKeys keys = keysOf(DeformerType::Lattice);
    keys.latticePoints = points;
    keys.latticeLower = lower;
    keys.latticeUpper = upper;
    for (int k = 0; k < points[2]; ++k)
        for (int j = 0; j < points[1]; ++j)
            for (int i = 0; i < points[0]; ++i) {
                const DVec3 u(double(i) / (points[0] - 1), double(j) / (points[1] - 1), double(k) / (points[2] - 1));
                const DVec3 control = lower + u * (upper - lower);
                keys.latticeOffsets.emplace_back(image(control) - control);
            }
    return keys;
}

inline constexpr std::array<DeformerType, 7> kTypes{DeformerType::Stretch, DeformerType::Shear,   DeformerType::Bend, DeformerType::Twist,
                                                    DeformerType::Taper,   DeformerType::Lattice, DeformerType::Wave};

/// Random but ordinary parameters; axis and axis2 differ.
inline DeformerKeys randomKeys(DeformerType type, Random &random) {
    DeformerKeys keys = keysOf(type);
    keys.centre = random.point(-0.5, 0.5);
    keys.axis = random.below(3);
    keys.axis2 = (keys.axis + 1 + random.below(2)) % 3;
    keys.lower = random.uniform(-1, 0.4);
    keys.upper = keys.lower + random.uniform(0.3, 1.5);
    keys.factor = random.point(-2, 2);
    keys.amount = random.uniform(-3, 3);
    keys.amplitude = random.uniform(-0.4, 0.4);
    keys.wavelength = random.uniform(0.5, 3);
    keys.phase = random.uniform(-4, 4);
    if (type != DeformerType::Lattice) return keys;
    const DVec3 lower = random.point(-1, -0.3);
    const DVec3 upper = random.point(0.3, 1);
    const std::array<int, 3> points{2 + random.below(4), 2 + random.below(4), 2 + random.below(4)};
    return latticeKeys(points, lower, upper, [&](const DVec3 &p) { return p + random.point(-0.3, 0.3); });
}

inline double maxDifference(const DVec3 &a, const DVec3 &b) {
    const DVec3 d = glm::abs(a - b);
    return std::fmax(d.x, std::fmax(d.y, d.z));
}

inline double maxDifference(const DMat3 &a, const DMat3 &b) {
    return std::fmax(maxDifference(a[0], b[0]), std::fmax(maxDifference(a[1], b[1]), maxDifference(a[2], b[2])));
}

} // namespace taut::test::deformers
