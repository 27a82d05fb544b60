#pragma once
/// Harnesses: each takes any bytes as one kind of input. What comes of them is a result that holds together, or InputError or RunError on
/// one line; everything else is a finding. libFuzzer drives them (fuzz.cpp), and the tests run them over their seeds (fuzz_test.cpp).

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace taut::fuzz {

/// How an input is changed beside what libFuzzer does to bytes.
enum class Grammar { Bytes, Json, Glb, Toml, Png };

struct Harness {
    std::string_view name;
    void (*run)(std::string_view bytes); ///< throws what is a finding
    std::vector<std::string> (*seeds)(); ///< small inputs from which mutation starts, most of them valid
    Grammar grammar = Grammar::Bytes;
};

std::span<const Harness> harnesses();
/// The harness of a name; throws std::invalid_argument with all names where there is none.
const Harness &harnessNamed(std::string_view name);

/// Runs `body`. Lets InputError and RunError pass, but for messages that are empty or more than one line; with the environment variable
/// TAUT_FUZZ_SAY they are printed.
void survive(const std::function<void()> &body);

/// Throws std::logic_error where what a reader or a round trip promised does not hold.
void require(bool holds, std::string_view promise);

/// A folder in memory where there is one, of this process alone and removed when it ends.
const std::string &scratchFolder();
/// Writes a file of that name there and returns its path.
std::string scratchFile(const std::string &name, std::string_view bytes);

} // namespace taut::fuzz
