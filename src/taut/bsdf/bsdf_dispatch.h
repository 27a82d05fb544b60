#pragma once
/// From a kind of BSDF to its class: a switch made from the table (bsdf_table.h), in which every case is compiled for its class.

#include "taut/bsdf/coated.h"
#include "taut/bsdf/conductor.h"
#include "taut/bsdf/dielectric.h"
#include "taut/bsdf/diffuse.h"
#include "taut/bsdf/metal.h"
#include "taut/bsdf/metallic_roughness.h"
#include "taut/bsdf/thin_glass.h"

namespace taut {

/// A kind as a type.
template <class Class_, BsdfType kType> struct BsdfKind {
    using Class = Class_;
    static constexpr BsdfInfo kInfo = bsdfInfo(kType);
};

/// use(BsdfKind<...>()) of the kind.
template <class Use> [[gnu::always_inline]] inline auto onBsdf(BsdfType type, const Use &use) {
#define TAUT_CASE(TYPE, ...)                                                                                                               \
    case BsdfType::TYPE: return use(BsdfKind<TYPE##Bsdf, BsdfType::TYPE>());
    switch (type) { TAUT_BSDFS(TAUT_CASE) }
#undef TAUT_CASE
    __builtin_unreachable();
}

/// use(facet) with the interface of a BSDF that light of several facets can be followed on.
template <class Use> auto withInterface(const Bsdf &bsdf, const Use &use) {
    using Result = decltype(use(SchlickInterface()));
    return onBsdf(bsdf.type, [&](auto kind) -> Result {
        if constexpr (decltype(kind)::kInfo.manyFacets)
            return use(decltype(kind)::Class::interface(bsdf));
        else
            __builtin_unreachable();
    });
}

} // namespace taut
