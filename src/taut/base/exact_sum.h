#pragma once
/// Sums of floats that are exact, so that any order and any split of what is added gives the same bits.
///
/// Fixed point with 64 bits before the binary point and 64 behind it. A float is added without rounding from 2^-41 (4.5e-13) up; a
/// smaller one is first rounded to the nearest multiple of 2^-64 (5.4e-20), for itself, so that the order still does not matter. Sums
/// are held at +-2^63 (9.2e18): as long as all that is added has one sign, or the limits are not reached, held sums are exact in this
/// sense too. Cf. Kulisch's long accumulator, which would hold every float in 4,288 bits.

#include <bit>
#include <cstdint>
#include <limits>

namespace taut {

__extension__ typedef __int128 Int128;

class ExactSum {
  public:
    constexpr ExactSum() = default;
    /// From the two halves that words() gave.
    constexpr ExactSum(std::uint64_t low, std::int64_t high) : value_((Int128{high} << 64) | Int128{low}) {}

    /// NaN adds nothing; an infinity holds the sum at its limit.
    constexpr void add(float x) {
        const auto bits = std::bit_cast<std::uint32_t>(x);
        // |x| = significand 2^(exponent - 150).
        const int exponent = static_cast<int>(bits >> 23U & 0xffU);
        const int shift = exponent - 150 + 64;
        // What light mostly is, far from the limit: neither rounded nor held.
        if (static_cast<unsigned>(shift) < 64U && static_cast<std::uint64_t>(high()) + kFar < 2 * kFar) {
            const Int128 units = static_cast<Int128>((bits & 0x7fffffU) | 0x800000U) << shift;
            value_ += (bits >> 31U) != 0 ? -units : units;
        } else if ((bits & 0x7fffffffU) != 0) {
            addSeldom(bits, exponent, shift);
        }
    }
    constexpr void add(const ExactSum &other) { addUnits(other.value_); }
    constexpr void subtract(const ExactSum &other) { addUnits(-other.value_); }
    /// Adds x^2 as add() adds x: without rounding from |x| = 2^-9 up, else first rounded to a multiple of 2^-64.
    constexpr void addSquare(float x) {
        const auto bits = std::bit_cast<std::uint32_t>(x);
        const int exponent = static_cast<int>(bits >> 23U & 0xffU);
        const std::uint32_t fraction = bits & 0x7fffffU;
        if (exponent == 0 || (exponent == 0xff && fraction != 0)) return;
        const Int128 square = static_cast<Int128>(fraction | 0x800000U) * static_cast<Int128>(fraction | 0x800000U);
        const int shift = 2 * (exponent - 150) + 64;
        if (shift > kHighestShift - 24)
            addUnits(kLimit);
        else if (shift >= 0)
            addUnits(square << shift);
        else if (shift >= -49)
            addUnits((square + (Int128{1} << (-shift - 1))) >> -shift);
    }

    /// Rounded once.
    [[nodiscard]] constexpr double value() const { return static_cast<double>(value_) * 0x1p-64; }

    [[nodiscard]] constexpr std::uint64_t low() const { return static_cast<std::uint64_t>(value_); }
    [[nodiscard]] constexpr std::int64_t high() const { return static_cast<std::int64_t>(value_ >> 64); }

    constexpr bool operator==(const ExactSum &other) const { return value_ == other.value_; }

  private:
    static constexpr Int128 kLimit =
        (Int128{std::numeric_limits<std::int64_t>::max()} << 64) | Int128{std::numeric_limits<std::uint64_t>::max()};
    static constexpr int kHighestShift = 127 - 24 - 1;          ///< of 24 bits that stay within the limit
    static constexpr std::uint64_t kFar = std::uint64_t{1} << 62; ///< high words below it are far from the limit

    constexpr void addSeldom(std::uint32_t bits, int exponent, int shift) {
        const std::uint32_t fraction = bits & 0x7fffffU;
        if (exponent == 0xff && fraction != 0) return;
        const Int128 significand = exponent == 0 ? 0 : static_cast<Int128>(fraction | 0x800000U); // of subnormal numbers not a bit is left
        Int128 units = 0;
        if (shift > kHighestShift)
            units = kLimit;
        else if (shift >= 0)
            units = significand << shift;
        else if (shift >= -25)
            units = (significand + (Int128{1} << (-shift - 1))) >> -shift;
        addUnits((bits >> 31U) != 0 ? -units : units);
    }

    constexpr void addUnits(Int128 units) {
        Int128 sum = 0;
        value_ = __builtin_add_overflow(value_, units, &sum) ? (units < 0 ? -kLimit : kLimit) : sum;
    }

    Int128 value_ = 0;
};

} // namespace taut
