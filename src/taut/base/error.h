#pragma once
/// What a user sees when an input is wrong: one line, `file:line:column: found X, expected Y; nearest valid name: Z`.

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace taut {

/// A place in an input. Text inputs use 1-based line and column; binary inputs use the byte offset.
struct Location {
    std::string file;
    int line = 0;                 ///< 0: not known
    int column = 0;               ///< 0: not known
    std::int64_t byteOffset = -1; ///< -1: not a binary input
    [[nodiscard]] std::string text() const;
};

/// Bad input or bad usage: the command prints what() and exits with code 2. what() is always a single line.
class InputError : public std::runtime_error {
  public:
    explicit InputError(const std::string &line);
};

/// Input that asks for more than a limit which can be raised by hand.
class LimitError : public InputError {
  public:
    using InputError::InputError;
};

/// Something failed while running (disk full, ...): exit code 1.
class RunError : public std::runtime_error {
  public:
    explicit RunError(const std::string &line);
};

/// Throws InputError("LOCATION: found FOUND, expected EXPECTED").
[[noreturn]] void failInput(const Location &where, std::string_view found, std::string_view expected);

/// Throws InputError("LOCATION: found FOUND, expected one of A, B, C; did you mean A?").
[[noreturn]] void failUnknownName(const Location &where, std::string_view found, std::span<const std::string_view> valid);

/// The valid name with the least Damerau-Levenshtein distance to `name`; empty where `valid` is empty.
std::string_view nearestName(std::string_view name, std::span<const std::string_view> valid);

/// `text` in single quotes with control bytes escaped, and only both ends of long input, fit for one line of an error.
std::string quoted(std::string_view text);
/// For std::string, constant or not, so that argument-dependent lookup does not find std::quoted first.
inline std::string quoted(const std::string &text) {
    return quoted(std::string_view(text));
}
inline std::string quoted(std::string &text) {
    return quoted(std::string_view(text));
}

/// A number as people write it: 0.5, 10, 1e-4.
std::string formatNumber(double value);

/// Things a loader wants to say without failing. Each is true, says what was done about it, and is said once.
struct Warnings {
    std::vector<std::string> lines;
    void add(std::string line);

  private:
    std::unordered_multimap<std::size_t, std::size_t> places_; ///< of lines, by hash
};

} // namespace taut
