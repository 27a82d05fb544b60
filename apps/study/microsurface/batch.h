#pragma once
/// The transformed GGX for many hits at once, structure of arrays: reflection at F = 1, evaluated, sampled and weighted by the very
/// functions of ggx.h in loops that the compiler vectorises. batch.cpp compiles them for SSE2, AVX2 and AVX-512; the widest set that
/// the machine has runs. All give the same bits, and those of the scalar functions.
///
/// Arrays hold `count` floats each and may be the same only where a call reads and does not write them. Directions are unit, in local
/// shading space.

#include "taut/base/instructions.h"
#include "taut/microsurface/transform.h"

#include <cstddef>

namespace taut::batch {

struct Vectors {
    const float *x, *y, *z;
};
struct VectorsOut {
    float *x, *y, *z;
};

/// Transforms, one a hit: [a b p; 0 d q; 0 0 1] as MicroTransform has them.
struct Transforms {
    const float *a, *b, *d, *p, *q;
};

/// f cos into `fCos` and the density of visible-normal reflection, D / (2 (wo.z + L(wo))), into `pdf`; both 0 where wi.z <= 0.
/// `correlated`: height-correlated masking, else separable. A wo below the horizon has the weight G1(wi) (Tokuyoshi 2021).
void evaluate(const Transforms &m, const Vectors &wo, const Vectors &wi, std::size_t count, bool correlated, float *fCos, float *pdf,
              Instructions instructions = widest());

/// f cos / pdf of visible-normal reflection, G2 / G1(wo); 0 where wi.z <= 0.
void weight(const Transforms &m, const Vectors &wo, const Vectors &wi, std::size_t count, bool correlated, float *weights,
            Instructions instructions = widest());

/// A reflected direction by bounded caps (Eto & Tokuyoshi 2023) and its density; a density of 0 where it is below the horizon and the
/// sample is rejected. ux, uy: uniform in [0, 1).
void sample(const Transforms &m, const Vectors &wo, const float *ux, const float *uy, std::size_t count, const VectorsOut &wi, float *pdf,
            Instructions instructions = widest());

} // namespace taut::batch
