/// Global space deformations after Barr, "Global and local deformations of solid primitives", 1984, each with its exact
/// Jacobian. Twist, bend and taper are piecewise: at an end of the range the Jacobian is that of the inside.

#include "taut/deform/deformer.h"

#include "taut/deform/lattice.h"

#include <algorithm>

namespace taut {
namespace {

/// numerator / denominator, or 0 (no deformation) where the denominator is not a positive number or the ratio overflows.
double rateOf(double numerator, double denominator) {
    const double rate = denominator > 0 ? numerator / denominator : 0.0;
    return std::isfinite(rate) ? rate : 0.0;
}

/// A deformation's parameter along an axis: grows over a range, constant outside.
struct RangeParameter {
    double rate;     ///< amount per metre inside the range; 0 where the range is degenerate
    double clamped;  ///< coordinate relative to centre, clamped to the range
    double gradient; ///< rate inside the range, 0 outside
};

RangeParameter rangeParameter(const Deformer &deformer, double coordinate) {
    const DeformerKeys &keys = deformer.keys;
    const double rate = rateOf(deformer.amount, keys.upper - keys.lower);
    if (rate == 0) return {0, coordinate, 0};
    const double clamped = std::clamp(coordinate, keys.lower, keys.upper);
    return {rate, clamped, clamped == coordinate ? rate : 0};
}

double sinc(double x) {
    return x == 0 ? 1.0 : std::sin(x) / x;
}

/// (1 - cos x) / x, without the cancellation.
double versinc(double x) {
    return std::sin(0.5 * x) * sinc(0.5 * x);
}

DeformedPoint stretch(const Deformer &deformer, const DVec3 &position) {
    DMat3 jacobian(0);
    for (int axis = 0; axis < 3; ++axis) jacobian[axis][axis] = deformer.factor[axis];
    return {deformer.keys.centre + deformer.factor * (position - deformer.keys.centre), jacobian};
}

DeformedPoint shear(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    DeformedPoint result{position, DMat3(1)};
    result.position[keys.axis] += deformer.amount * (position[keys.axis2] - keys.centre[keys.axis2]);
    result.jacobian[keys.axis2][keys.axis] += deformer.amount;
    return result;
}

/// The centre line through `centre` becomes an arc of curvature amount / (upper - lower) and length upper - lower, its
/// cross-sections stay plane and perpendicular to it. The centre, and the direction of the line there, are fixed.
DeformedPoint bend(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    const int along = keys.axis;
    const int towards = keys.axis2;
    const double z = position[along] - keys.centre[along];
    const double r = position[towards] - keys.centre[towards];
    const RangeParameter range = rangeParameter(deformer, z);
    if (range.rate == 0) return {position, DMat3(1)};

    const double start = std::clamp(0.0, keys.lower, keys.upper); // where the arc is level
    const double arc = range.clamped - start;
    const double angle = range.rate * arc;
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const double overshoot = z - range.clamped; // goes on along the tangent

    DeformedPoint result{position, DMat3(1)};
    result.position[along] = keys.centre[along] + start + arc * sinc(angle) + cosine * overshoot - sine * r;
    result.position[towards] = keys.centre[towards] + arc * versinc(angle) + sine * overshoot + cosine * r;
    const double pace = 1 - range.gradient * r; // inner fibres shorten, outer ones stretch
    result.jacobian[along][along] = pace * cosine;
    result.jacobian[along][towards] = pace * sine;
    result.jacobian[towards][along] = -sine;
    result.jacobian[towards][towards] = cosine;
    return result;
}

DeformedPoint twist(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    const int along = keys.axis;
    const int b = (along + 1) % 3;
    const int c = (along + 2) % 3;
    const RangeParameter range = rangeParameter(deformer, position[along] - keys.centre[along]);
    if (range.rate == 0) return {position, DMat3(1)};

    const double angle = range.rate * (range.clamped - keys.lower);
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const DVec3 offset = position - keys.centre;
    const double rotatedB = cosine * offset[b] - sine * offset[c];
    const double rotatedC = sine * offset[b] + cosine * offset[c];

    DeformedPoint result{position, DMat3(1)};
    result.position[b] = keys.centre[b] + rotatedB;
    result.position[c] = keys.centre[c] + rotatedC;
    result.jacobian[b][b] = cosine;
    result.jacobian[b][c] = sine;
    result.jacobian[c][b] = -sine;
    result.jacobian[c][c] = cosine;
    result.jacobian[along][b] = -range.gradient * rotatedC;
    result.jacobian[along][c] = range.gradient * rotatedB;
    return result;
}

DeformedPoint taper(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    const int along = keys.axis;
    const RangeParameter range = rangeParameter(deformer, position[along] - keys.centre[along]);
    if (range.rate == 0) return {position, DMat3(1)};

    const double scale = 1 + range.rate * (range.clamped - keys.lower);
    DeformedPoint result{position, DMat3(1)};
    for (const int across : {(along + 1) % 3, (along + 2) % 3}) {
        const double offset = position[across] - keys.centre[across];
        result.position[across] = keys.centre[across] + scale * offset;
        result.jacobian[across][across] = scale;
        result.jacobian[along][across] = range.gradient * offset;
    }
    return result;
}

double waveNumber(const Deformer &deformer) {
    return rateOf(kTwoPi, deformer.wavelength);
}

DeformedPoint wave(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    const double number = waveNumber(deformer);
    DeformedPoint result{position, DMat3(1)};
    if (number == 0) return result;
    const double angle = number * (position[keys.axis] - keys.centre[keys.axis]) + deformer.phase;
    result.position[keys.axis2] += deformer.amplitude * std::sin(angle);
    result.jacobian[keys.axis][keys.axis2] += deformer.amplitude * number * std::cos(angle);
    return result;
}

} // namespace

Deformer deformerAtFrame(const DeformerKeys &keys, double frame) {
    Deformer deformer;
    setDeformer(keys, frame, deformer);
    return deformer;
}

void setDeformer(const DeformerKeys &keys, double frame, Deformer &deformer) {
    deformer.keys = keys;
    deformer.factor = keys.factor.at(frame);
    deformer.amount = keys.amount.at(frame);
    deformer.amplitude = keys.amplitude.at(frame);
    deformer.wavelength = keys.wavelength.at(frame);
    deformer.phase = keys.phase.at(frame);
    if (keys.type == DeformerType::Lattice) latticeControlAtFrame(keys, frame, deformer.latticeControl);
}

DeformedPoint deform(const Deformer &deformer, const DVec3 &position) {
    switch (deformer.keys.type) {
    case DeformerType::Stretch: return stretch(deformer, position);
    case DeformerType::Shear: return shear(deformer, position);
    case DeformerType::Bend: return bend(deformer, position);
    case DeformerType::Twist: return twist(deformer, position);
    case DeformerType::Taper: return taper(deformer, position);
    case DeformerType::Lattice: return deformByLattice(deformer, position);
    case DeformerType::Wave: return wave(deformer, position);
    }
    return {position, DMat3(1)};
}

bool isIdentity(const Deformer &deformer) {
    switch (deformer.keys.type) {
    case DeformerType::Stretch: return deformer.factor == DVec3(1);
    case DeformerType::Shear: return deformer.amount == 0;
    case DeformerType::Bend:
    case DeformerType::Twist:
    case DeformerType::Taper: return rateOf(deformer.amount, deformer.keys.upper - deformer.keys.lower) == 0;
    case DeformerType::Lattice: return isLatticeIdentity(deformer);
    case DeformerType::Wave: return deformer.amplitude == 0 || waveNumber(deformer) == 0;
    }
    return true;
}

} // namespace taut
