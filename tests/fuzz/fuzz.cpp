/// libFuzzer's entry points: one program for all harnesses, of which the environment variable TAUT_FUZZ_HARNESS names one.

#include "mutate.h"

#include <tbb/global_control.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

// libFuzzer's own names.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t *data, std::size_t size, std::size_t greatest);
extern "C" int LLVMFuzzerInitialize(int *argc, char ***argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t *data, std::size_t size, std::size_t greatest, unsigned seed);

namespace {

const taut::fuzz::Harness *chosen = nullptr;

std::string changedBytes(const std::string &bytes) {
    std::string out = bytes;
    const std::size_t room = bytes.size() + 64;
    out.resize(room);
    out.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t *>(out.data()), bytes.size(), room));
    return out;
}

} // namespace

int LLVMFuzzerInitialize(int * /*argc*/, char *** /*argv*/) {
    static const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const char *name = std::getenv("TAUT_FUZZ_HARNESS");
    try {
        chosen = &taut::fuzz::harnessNamed(name != nullptr ? name : "");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "TAUT_FUZZ_HARNESS: %s\n", error.what());
        std::exit(2);
    }
    static_cast<void>(taut::fuzz::scratchFolder());
    return 0;
}

/// What escapes a harness ends the process: a finding.
int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    chosen->run({reinterpret_cast<const char *>(data), size});
    return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t *data, std::size_t size, std::size_t greatest, unsigned seed) {
    taut::fuzz::Dice dice(seed);
    if (chosen->grammar != taut::fuzz::Grammar::Bytes && dice.chance(80)) {
        // The first byte of a writers' input is no part of the scene.
        const bool hasChoice = chosen->name == "writers";
        const std::string_view bytes(reinterpret_cast<const char *>(data), size);
        const std::size_t skip = hasChoice && size > 0 ? 1 : 0;
        std::string out = mutated(chosen->grammar, bytes.substr(skip), dice, changedBytes);
        if (!out.empty()) {
            if (skip == 1) out.insert(0, 1, static_cast<char>(dice.chance(10) ? dice.below(56) : data[0]));
            out.resize(std::min(out.size(), greatest));
            std::memcpy(data, out.data(), out.size());
            return out.size();
        }
    }
    return LLVMFuzzerMutate(data, size, greatest);
}
