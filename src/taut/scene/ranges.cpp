#include "taut/scene/ranges.h"

#include "taut/base/error.h"

namespace taut {

std::string describe(const Range &range) {
    const bool bounded = range.upper < kAnyNumber.upper;
    if (bounded)
        return std::string("a number in ") + (range.openLower ? "(" : "[") + formatNumber(range.lower) + ", " + formatNumber(range.upper) +
               "]";
    if (range.lower <= kAnyNumber.lower) return "a finite number";
    return (range.openLower ? "a number above " : "a number of at least ") + formatNumber(range.lower);
}

std::string describe(const IntegerRange &range) {
    return "an integer in [" + std::to_string(range.lower) + ", " + std::to_string(range.upper) + "]";
}

} // namespace taut
