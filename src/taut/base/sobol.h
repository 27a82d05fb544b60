#pragma once
/// Owen-scrambled Sobol points, padded: every pair of dimensions is the two-dimensional (0, 2)-sequence with its own
/// scrambling and its own shuffle of the sample order (Burley 2020, "Practical Hash-based Owen Scrambling").

#include "taut/base/vec.h"

namespace taut {

inline std::uint32_t reverseBits(std::uint32_t x) {
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

/// Sample `index` of the one-dimensional set named by `seed` (scrambled van der Corput).
inline float sobol1(std::uint32_t index, std::uint32_t seed) {
    const std::uint32_t shuffled = owenScramble(index, seed);
    return toUnitFloat(reverseBits(owenScrambleReversed(shuffled, hash(seed ^ 0x967a889bU))));
}

} // namespace taut
