#include "taut/deform/lattice.h"

#include <algorithm>
#include <cstddef>

namespace taut {
namespace {

bool isWellFormed(const DeformerKeys &keys) {
    for (int axis = 0; axis < 3; ++axis) {
        const int points = keys.latticePoints[static_cast<std::size_t>(axis)];
        if (points < 2 || points > kMaxLatticePoints) return false;
        if (!(keys.latticeUpper[axis] > keys.latticeLower[axis])) return false;
    }
    return true;
}

/// Calls f(index, position) for every undisplaced control point, x fastest.
template <class F> void forEachGridPoint(const DeformerKeys &keys, const F &f) {
    const auto [nx, ny, nz] = keys.latticePoints;
    const DVec3 last(nx - 1, ny - 1, nz - 1);
    std::size_t index = 0;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) f(index++, glm::mix(keys.latticeLower, keys.latticeUpper, DVec3(i, j, k) / last));
}

/// A value and its derivatives by (u, v, w).
struct Jet {
    DVec3 value{0};
    DMat3 gradient{0};
};

/// Sum over the control points, one axis after the other: n^3 + n^2 + n steps in place of n^3 products of three.
Jet evaluateControl(const std::vector<DVec3> &control, const std::array<int, 3> &points, const std::array<BernsteinBasis, 3> &basis) {
    Jet sum;
    std::size_t index = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(points[2]); ++k) {
        DVec3 plane(0);
        DVec3 planeU(0);
        DVec3 planeV(0);
        for (std::size_t j = 0; j < static_cast<std::size_t>(points[1]); ++j) {
            DVec3 row(0);
            DVec3 rowU(0);
            for (std::size_t i = 0; i < static_cast<std::size_t>(points[0]); ++i, ++index) {
                row += basis[0].value[i] * control[index];
                rowU += basis[0].derivative[i] * control[index];
            }
            plane += basis[1].value[j] * row;
            planeU += basis[1].value[j] * rowU;
            planeV += basis[1].derivative[j] * row;
        }
        sum.value += basis[2].value[k] * plane;
        sum.gradient[0] += basis[2].value[k] * planeU;
        sum.gradient[1] += basis[2].value[k] * planeV;
        sum.gradient[2] += basis[2].derivative[k] * plane;
    }
    return sum;
}

} // namespace

BernsteinBasis bernsteinBasis(int points, double u) {
    BernsteinBasis basis;
    const auto degree = static_cast<std::size_t>(points - 1);
    basis.value[0] = 1;
    for (std::size_t d = 1; d <= degree; ++d) {
        if (d == degree) { // B'_i^n = n (B_{i-1}^{n-1} - B_i^{n-1})
            const auto n = static_cast<double>(degree);
            basis.derivative[0] = -n * basis.value[0];
            for (std::size_t i = 1; i <= degree; ++i) basis.derivative[i] = n * (basis.value[i - 1] - basis.value[i]);
        }
        for (std::size_t i = d; i > 0; --i) basis.value[i] = (1 - u) * basis.value[i] + u * basis.value[i - 1];
        basis.value[0] *= 1 - u;
    }
    return basis;
}

void latticeControlAtFrame(const DeformerKeys &keys, double frame, std::vector<DVec3> &control) {
    control.clear();
    if (!isWellFormed(keys)) return;
    const auto [nx, ny, nz] = keys.latticePoints;
    control.resize(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz));
    forEachGridPoint(keys, [&](std::size_t index, const DVec3 &point) {
        control[index] = index < keys.latticeOffsets.size() ? point + keys.latticeOffsets[index].at(frame) : point;
    });
}

DeformedPoint deformByLattice(const Deformer &deformer, const DVec3 &position) {
    const DeformerKeys &keys = deformer.keys;
    if (deformer.latticeControl.empty()) return {position, DMat3(1)};
    const DVec3 clamped = glm::min(glm::max(position, keys.latticeLower), keys.latticeUpper);
    const DVec3 extent = keys.latticeUpper - keys.latticeLower;
    const DVec3 parameter = (clamped - keys.latticeLower) / extent;
    const std::array<BernsteinBasis, 3> basis{bernsteinBasis(keys.latticePoints[0], parameter.x),
                                              bernsteinBasis(keys.latticePoints[1], parameter.y),
                                              bernsteinBasis(keys.latticePoints[2], parameter.z)};
    const Jet jet = evaluateControl(deformer.latticeControl, keys.latticePoints, basis);
    DeformedPoint result{jet.value + (position - clamped), DMat3(1)};
    for (int axis = 0; axis < 3; ++axis) // a clamped coordinate moves the point by the overshoot alone
        if (position[axis] == clamped[axis]) result.jacobian[axis] = jet.gradient[axis] / extent[axis];
    return result;
}

bool isLatticeIdentity(const Deformer &deformer) {
    if (deformer.latticeControl.empty()) return true;
    bool identity = true;
    forEachGridPoint(deformer.keys,
                     [&](std::size_t index, const DVec3 &point) { identity = identity && deformer.latticeControl[index] == point; });
    return identity;
}

} // namespace taut
