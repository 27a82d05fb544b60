#pragma once
/// Owen-scrambled Sobol points, padded: sets of a few dimensions, each with its own scrambling and its own shuffle of the sample order
/// (Burley 2020, "Practical Hash-based Owen Scrambling"). The first two dimensions of a set are a (0, 2)-sequence; a third, and a fourth
/// and fifth, are there for what should be stratified together with them.

#include "taut/base/vec.h"

#include <array>
#include <initializer_list>

namespace taut {

constexpr std::uint32_t reverseBits(std::uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
    x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
    return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/// A well-mixed 32-bit hash (the finaliser of Wellons' "lowbias32").
inline std::uint32_t hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadU;
    x ^= x >> 15;
    x *= 0xd35a2d97U;
    return x ^ (x >> 15);
}
inline std::uint32_t hash(std::uint32_t a, std::uint32_t b) {
    return hash(a ^ (hash(b) + 0x9e3779b9U + (a << 6) + (a >> 2)));
}

/// Nested uniform scramble of a bit-reversed number (Laine & Karras 2011 with Vegdahl's constants).
inline std::uint32_t owenScrambleReversed(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeaU;
    x += seed;
    x *= (seed >> 16) | 1U;
    x ^= x * 0x05526c56U;
    return x ^ (x * 0x53a22864U);
}
inline std::uint32_t owenScramble(std::uint32_t x, std::uint32_t seed) {
    return reverseBits(owenScrambleReversed(reverseBits(x), seed));
}

/// Second dimension of Sobol's sequence, bit-reversed: the Pascal matrix modulo 2 applied to the index, five steps because
/// that matrix is the fifth Kronecker power of [1 1; 0 1].
inline std::uint32_t sobolSecondReversed(std::uint32_t index) {
    index ^= (index >> 1) & 0x55555555U;
    index ^= (index >> 2) & 0x33333333U;
    index ^= (index >> 4) & 0x0f0f0f0fU;
    index ^= (index >> 8) & 0x00ff00ffU;
    return index ^ (index >> 16);
}

/// A dimension of Sobol's sequence beyond the second: what each bit of the index adds, bit-reversed.
using SobolColumns = std::array<std::uint32_t, 32>;

/// By the degree and the inner coefficients of its primitive polynomial and its first direction numbers (Sobol 1967; Joe & Kuo 2008).
constexpr SobolColumns sobolColumns(std::size_t degree, std::uint32_t coefficients, std::initializer_list<std::uint32_t> first) {
    std::array<std::uint32_t, 32> m{};
    std::size_t given = 0;
    for (const std::uint32_t number : first) m[given++] = number;
    for (std::size_t i = degree; i < m.size(); ++i) {
        m[i] = (m[i - degree] << degree) ^ m[i - degree];
        for (std::size_t k = 1; k < degree; ++k)
            if ((coefficients >> (degree - 1 - k) & 1U) != 0) m[i] ^= m[i - k] << k;
    }
    SobolColumns columns{};
    for (std::size_t i = 0; i < m.size(); ++i) columns[i] = reverseBits(m[i] << (31 - i));
    return columns;
}
inline constexpr SobolColumns kSobolThird = sobolColumns(2, 1, {1, 3});
/// These two with the direction numbers by which both together, and all five, stratify each other best at 4 to 64 points.
inline constexpr SobolColumns kSobolFourth = sobolColumns(3, 1, {1, 1, 1});
inline constexpr SobolColumns kSobolFifth = sobolColumns(3, 2, {1, 3, 5});

[[gnu::always_inline]] inline std::uint32_t sobolReversed(const SobolColumns &columns, std::uint32_t index) {
    std::uint32_t x = 0;
#pragma GCC unroll 32
    for (std::size_t k = 0; k < 32; ++k) x ^= columns[k] & (0U - (index >> k & 1U));
    return x;
}

/// 24 random bits as a float in [0, 1).
inline float toUnitFloat(std::uint32_t x) {
    return static_cast<float>(x >> 8) * 0x1p-24F;
}

/// Sample `index` of the two-dimensional set named by `seed`.
inline Vec2 sobol2(std::uint32_t index, std::uint32_t seed) {
    // Shuffling the order with an Owen scramble keeps every power-of-two block of samples a net.
    const std::uint32_t shuffled = owenScramble(index, seed);
    const std::uint32_t x = reverseBits(owenScrambleReversed(shuffled, hash(seed ^ 0x68bc21ebU)));
    const std::uint32_t y = reverseBits(owenScrambleReversed(sobolSecondReversed(shuffled), hash(seed ^ 0x02e5be93U)));
    return {toUnitFloat(x), toUnitFloat(y)};
}

/// The third number of a sample of which sobol2() has the first two.
inline float sobolThird(std::uint32_t index, std::uint32_t seed) {
    const std::uint32_t z = sobolReversed(kSobolThird, owenScramble(index, seed));
    return toUnitFloat(reverseBits(owenScrambleReversed(z, hash(seed ^ 0x967a889bU))));
}

/// All three.
inline Vec3 sobol3(std::uint32_t index, std::uint32_t seed) {
    return {sobol2(index, seed), sobolThird(index, seed)};
}

/// The fourth and the fifth; `own` names their scrambling.
inline Vec2 sobolFourthFifth(std::uint32_t index, std::uint32_t seed, std::uint32_t own) {
    const std::uint32_t shuffled = owenScramble(index, seed);
    const std::uint32_t x = owenScrambleReversed(sobolReversed(kSobolFourth, shuffled), hash(own ^ 0x3c6ef372U));
    const std::uint32_t y = owenScrambleReversed(sobolReversed(kSobolFifth, shuffled), hash(own ^ 0x0f6d5a1bU));
    return {toUnitFloat(reverseBits(x)), toUnitFloat(reverseBits(y))};
}

/// Sample `index` of the one-dimensional set named by `seed` (scrambled van der Corput).
inline float sobol1(std::uint32_t index, std::uint32_t seed) {
    const std::uint32_t shuffled = owenScramble(index, seed);
    return toUnitFloat(reverseBits(owenScrambleReversed(shuffled, hash(seed ^ 0x967a889bU))));
}

} // namespace taut
