#pragma once
/// Loops that are compiled for several sets of vector instructions from one source, the widest that the machine has being run. With
/// contraction off (the build's flags) all sets give the same bits.
///
///     #define MY_LOOPS(NAME, ...) struct NAME { [[gnu::flatten __VA_ARGS__]] static void run(...) { ... } };
///     TAUT_FOR_INSTRUCTION_SETS(MY_LOOPS)
///     onInstructions(widest(), [&](auto loops) { decltype(loops)::run(...); });
///
/// flatten inlines everything that a loop calls into it, so that it is compiled for the set. A file with such loops wants
/// -fno-trapping-math (CMakeLists.txt): conditions on floats then become selections.

namespace taut {

enum class Instructions { Sse2, Avx2, Avx512 };

/// Whether this machine and this build have them.
bool has(Instructions instructions);
/// The widest that there are.
Instructions widest();

} // namespace taut

#if defined(__x86_64__)
#define TAUT_FOR_INSTRUCTION_SETS(LOOPS)                                                                                                   \
    LOOPS(Baseline)                                                                                                                        \
    LOOPS(Avx2, , gnu::target("avx2"))                                                                                                     \
    LOOPS(Avx512, , gnu::target("avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512"))                                             \
    template <class Call> void onInstructions(Instructions instructions, const Call &call) {                                               \
        if (instructions == Instructions::Avx512 && has(instructions)) return call(Avx512{});                                              \
        if (instructions == Instructions::Avx2 && has(instructions)) return call(Avx2{});                                                  \
        call(Baseline{});                                                                                                                  \
    }
#else
#define TAUT_FOR_INSTRUCTION_SETS(LOOPS)                                                                                                   \
    LOOPS(Baseline)                                                                                                                        \
    template <class Call> void onInstructions(Instructions, const Call &call) {                                                            \
        call(Baseline{});                                                                                                                  \
    }
#endif
