#pragma once
/// Space deformers: maps D: R^3 -> R^3 of an object's own space with closed-form Jacobians, stacked in order.
///
/// Each acts on points in object space (metres) about a centre, along the axes of object space. The Jacobian is exact, so
/// surface gradients are carried through a stack without a fit: d(D o X) = J_D(X) dX.
///
/// All maps are continuous. Bend, twist, taper (Barr 1984) and lattice are smooth up to the ends of their range or box, where
/// the Jacobian jumps to that of the outside: by curvature * offset for bend (so not on its centre line), by the rate of twist
/// or taper times the offset. At an end itself it is that of the inside.

#include "taut/base/vec.h"
#include "taut/deform/keyed.h"

#include <array>
#include <string>
#include <vector>

namespace taut {

enum class DeformerType { Stretch, Shear, Bend, Twist, Taper, Lattice, Wave };

/// One deformer of a scene file, parameters keyed over frames. Which fields a type reads is said at the field.
struct DeformerKeys {
    DeformerType type = DeformerType::Stretch;
    DVec3 centre{0};               ///< all but lattice: the fixed point
    int axis = 2;                  ///< bend, twist, taper, wave: 0, 1, 2 = x, y, z
    int axis2 = 0;                 ///< shear: the coordinate that drives (plane "xy": x is displaced by y -> axis = 0,
                                   ///< axis2 = 1); bend: the direction bent towards (not `axis`); wave: the direction displaced
    double lower = -1;             ///< bend, twist, taper: start of the range along `axis`, relative to centre
    double upper = 1;              ///< end of the range; outside it the map continues rigidly (bend, twist) or constant
    Keyed<DVec3> factor{DVec3(1)}; ///< stretch: factor along x, y, z
    Keyed<double> amount{0.0};     ///< shear: displacement per unit; bend, twist: angle over the range, radians
                                   ///< (bend: level at centre; twist: right-handed about +axis, 0 at `lower`);
                                   ///< taper: scale at `upper` minus 1 (cross-section scale goes 1 -> 1 + amount)
    Keyed<double> amplitude{0.0};  ///< wave: metres
    Keyed<double> wavelength{1.0}; ///< wave: metres, > 0
    Keyed<double> phase{0.0};      ///< wave: radians
    // lattice: trivariate Bernstein free-form deformation (Sederberg & Parry 1986)
    DVec3 latticeLower{0}; ///< box in object space
    DVec3 latticeUpper{1};
    std::array<int, 3> latticePoints{2, 2, 2}; ///< control points along x, y, z; each >= 2 and <= 16
    std::vector<Keyed<DVec3>> latticeOffsets;  ///< displacement of each control point, x fastest; metres
};

/// A deformer at one time: constants ready for evaluation.
struct Deformer {
    DeformerKeys keys; ///< geometry (axes, ranges, boxes)
    DVec3 factor{1};
    double amount = 0;
    double amplitude = 0;
    double wavelength = 1;
    double phase = 0;
    std::vector<DVec3> latticeControl; ///< displaced control points, object space
};

Deformer deformerAtFrame(const DeformerKeys &keys, double frame);
/// deformerAtFrame() in place: allocates nothing where `out` held a deformer of the same shape.
void setDeformer(const DeformerKeys &keys, double frame, Deformer &out);

/// The image of a point and the Jacobian dD/dx there; object space.
struct DeformedPoint {
    DVec3 position;
    DMat3 jacobian; ///< column j = dD/dx_j
};
DeformedPoint deform(const Deformer &deformer, const DVec3 &position);

/// True where the deformer, at this time, is the identity map. So are those that have no meaning: an empty range or box, a
/// wavelength that is not positive (the scene reader rejects them).
bool isIdentity(const Deformer &deformer);

} // namespace taut
