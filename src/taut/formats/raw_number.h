#pragma once
/// Numbers of binary files.

#include <bit>
#include <cstring>

namespace taut {

static_assert(std::endian::native == std::endian::little, "binary files are read in the machine's order");

template <class T> T rawNumber(const void *bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}
/// As a double, for tables of types that a file names.
template <class T> double rawAsDouble(const void *bytes) {
    return static_cast<double>(rawNumber<T>(bytes));
}

} // namespace taut
