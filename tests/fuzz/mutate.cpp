#include "mutate.h"

namespace taut::fuzz {

std::uint64_t Dice::next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15ULL;
    z = (z ^ z >> 30U) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ z >> 27U) * 0x94d049bb133111ebULL;
    return z ^ z >> 31U;
}

std::string mutated(Grammar grammar, std::string_view bytes, Dice &dice, const ChangeBytes &change) {
    switch (grammar) {
    case Grammar::Json: return mutatedJson(bytes, dice);
    case Grammar::Glb: return mutatedGlb(bytes, dice, change);
    case Grammar::Toml: return mutatedToml(bytes, dice);
    case Grammar::Png: return mutatedPng(bytes, dice, change);
    case Grammar::Bytes: break;
    }
    return {};
}

} // namespace taut::fuzz
