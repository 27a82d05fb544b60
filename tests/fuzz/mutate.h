#pragma once
/// Changes to inputs that keep to their grammar, so that mutation gets behind the parser.

#include "harness.h"

#include <cstdint>

namespace taut::fuzz {

/// Random numbers of one mutation.
class Dice {
  public:
    explicit Dice(std::uint64_t seed) : state_(seed * 2 + 1) {}
    std::uint64_t next(); ///< SplitMix64
    std::size_t below(std::size_t count) { return count == 0 ? 0 : next() % count; }
    bool chance(unsigned percent) { return below(100) < percent; }

  private:
    std::uint64_t state_;
};

/// libFuzzer's own change of some bytes.
using ChangeBytes = std::function<std::string(const std::string &bytes)>;

/// One change that the grammar allows; empty where the input has none of that grammar.
std::string mutated(Grammar grammar, std::string_view bytes, Dice &dice, const ChangeBytes &change);

// mutate_json.cpp: members and elements of the tree; of a .glb the lengths of its chunks are those of what they hold.
std::string mutatedJson(std::string_view text, Dice &dice);
std::string mutatedGlb(std::string_view bytes, Dice &dice, const ChangeBytes &change);

// mutate_toml.cpp: lines of tables, with the keys that scene files know
std::string mutatedToml(std::string_view text, Dice &dice);

// mutate_png.cpp: what chunks hold; their checksums are made right again
std::string mutatedPng(std::string_view bytes, Dice &dice, const ChangeBytes &change);

} // namespace taut::fuzz
