#pragma once
/// What the parts of check() share. Internal to `scene/`.

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/scene/ranges.h"
#include "taut/scene/rules.h"
#include "taut/scene/scene.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <string_view>

namespace taut {

/// A part of the scene that is being checked: objects[3] 'sail'. It becomes text where there is something to say.
struct Part {
    std::string_view scene; ///< its path; may be empty
    std::string_view list;  ///< "objects"
    Index index = kNone;    ///< kNone: there is one alone
    std::string_view name{};

    [[noreturn]] void fail(std::string_view member, std::string_view found, std::string_view expected) const;
    void failOn(std::string_view member, const std::optional<Mistake> &mistake) const {
        if (mistake) fail(member, mistake->found, mistake->expected);
    }
};

/// Within a range but for rounding: to float, to another unit and back, and to the digits of a file. Without an upper bound all that a
/// float can hold counts.
bool isWithin(const Range &range, double value);

/// `unit`: what the value is counted in, in the units of the range (degrees).
void checkNumber(const Part &part, std::string_view member, double value, const Range &range, double unit = 1);
void checkInteger(const Part &part, std::string_view member, std::int64_t value, const IntegerRange &range);
void checkVector(const Part &part, std::string_view member, const DVec3 &value, const Range &range = kAnyNumber, double unit = 1);
void checkCount(const Part &part, std::string_view member, std::size_t count, std::size_t expected);
/// An element of an array of `count` (of "textures").
void checkIndex(const Part &part, std::string_view member, Index index, std::size_t count, std::string_view of);
inline void checkOptionalIndex(const Part &part, std::string_view member, Index index, std::size_t count, std::string_view of) {
    if (index != kNone) checkIndex(part, member, index, count, of);
}

/// Keys at increasing frames, at least one, each within the range.
void checkKeys(const Part &part, std::string_view member, const Keyed<double> &keyed, const Range &range, double unit = 1);
void checkKeys(const Part &part, std::string_view member, const Keyed<DVec3> &keyed, const Range &range = kAnyNumber, double unit = 1);

/// The first of [0, count) for which bad(i) holds, else `count`; in parallel. Nearly always there is none: a chunk is asked without a
/// branch, as vectors can, and searched only where it has one.
template <class F> std::size_t firstWhere(std::size_t count, const F &bad) {
    constexpr std::size_t kChunk = 4096;
    std::atomic<std::size_t> first{count};
    parallelFor((count + kChunk - 1) / kChunk, 4, [&](std::size_t chunk) {
        const std::size_t begin = chunk * kChunk;
        const std::size_t end = std::min(count, begin + kChunk);
        bool any = false;
        for (std::size_t i = begin; i < end; ++i) any |= bad(i);
        if (!any) return;
        std::size_t at = begin;
        while (!bad(at)) ++at;
        std::size_t least = first;
        while (at < least && !first.compare_exchange_weak(least, at)) {}
    });
    return first;
}

/// Fails at the first element for which bad(i) holds.
template <class F>
void checkEach(const Part &part, std::string_view member, std::size_t count, std::string_view found, std::string_view expected,
               const F &bad) {
    const std::size_t at = firstWhere(count, bad);
    if (at < count) part.fail(member, std::string(found) + " in element " + std::to_string(at), expected);
}

/// Structure of one mesh; `part` is an object that has it.
void checkMesh(const Part &part, const Mesh &mesh);
/// Every index and length of a rig.
void checkRig(const Part &part, const Rig &rig);
/// What a motion names in its rig, which has been checked.
void checkMotion(const Part &part, const RigMotion &motion);
void checkDeformer(const Part &part, const DeformerKeys &keys);

} // namespace taut
