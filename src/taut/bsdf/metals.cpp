#include "taut/bsdf/metals.h"

#include <array>

namespace taut {

std::span<const Metal> metals() {
    static const std::array<Metal, 7> table{{
        {"Al", {1.5580F, 1.0152F, 0.63324F}, {7.7124F, 6.6273F, 5.4544F}},
        {"Ag", {0.05222F, 0.05958F, 0.04000F}, {4.4094F, 3.5974F, 2.6484F}},
        {"Au", {0.15557F, 0.42415F, 1.3831F}, {3.6024F, 2.4721F, 1.9155F}},
        {"Cu", {0.23780F, 1.0066F, 1.2404F}, {3.6264F, 2.5823F, 2.3929F}},
        {"Fe", {2.9114F, 2.9497F, 2.5845F}, {3.0893F, 2.9318F, 2.7670F}},
        {"Ti", {2.7407F, 2.5418F, 2.2670F}, {3.8143F, 3.4345F, 3.0385F}},
        {"Cr", {3.1071F, 3.1812F, 2.3230F}, {3.3314F, 3.3291F, 3.1350F}},
    }};
    return table;
}

} // namespace taut
