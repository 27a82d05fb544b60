#include "taut/base/instructions.h"

namespace taut {

bool has(Instructions instructions) {
#if defined(__x86_64__)
    switch (instructions) {
    case Instructions::Sse2: return true;
    case Instructions::Avx2: return __builtin_cpu_supports("avx2") != 0;
    case Instructions::Avx512:
        return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
               __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0;
    }
#endif
    return instructions == Instructions::Sse2;
}

Instructions widest() {
    static const Instructions best = has(Instructions::Avx512) ? Instructions::Avx512
                                     : has(Instructions::Avx2) ? Instructions::Avx2
                                                               : Instructions::Sse2;
    return best;
}

} // namespace taut
