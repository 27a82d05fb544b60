#pragma once
/// Names of objects and materials as numbers in an image: Cryptomatte 1.2.0 (Friedman & Jones, Psyop, 2015 to 2018).

#include <cstdint>
#include <string_view>

namespace taut {

/// MurmurHash3_x86_32 with seed 0 (Appleby 2011).
std::uint32_t murmurHash3(std::string_view bytes);

/// What Cryptomatte calls a name: the bits of a float whose hash they are, with the exponent held to 1 to 254 so that it is neither
/// subnormal nor infinite nor not a number.
std::uint32_t matteId(std::string_view name);

} // namespace taut
