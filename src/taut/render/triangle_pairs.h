#pragma once
/// Triangles taken two by two along a shared edge, as Embree's quads: half as many boxes and half as many steps through them.

#include "taut/render/ray_batch.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace taut {

/// Corners a, b, c, d of a quad are the triangles (a, b, d) and (c, d, b); of a triangle alone c and d are the same.
using QuadCorners = std::array<Index, 4>;

class TrianglePairs {
  public:
    /// More triangles than this are refused (their places and turns share 32 bits).
    static constexpr std::size_t kMost = std::size_t{1} << 30U;

    /// Pairs what shares an edge that both pass in opposite directions; what finds no partner stays alone. `places`: [vertices] those with
    /// the same number are at one place in every frame, to rounding; empty: each is at its own. Indices alone decide, so that a mesh has
    /// the same pairs in every frame. Throws InputError beyond kMost.
    explicit TrianglePairs(std::span<const Index3> triangles, std::span<const Index> places = {});

    /// Quads, in the order of their first triangles where neighbours follow each other in the mesh.
    [[nodiscard]] std::size_t size() const { return turns_.size() + members_.size(); }
    /// Writes size() of them. `triangles`: those that it was made of.
    void corners(std::span<const Index3> triangles, std::span<QuadCorners> quads) const;
    [[nodiscard]] std::size_t bytes() const { return turns_.capacity() + members_.capacity() * sizeof(members_[0]); }

    /// A hit as Embree tells it of a quad (place u along a b, v along a d, 1 + 1 at c), as one of a triangle: its number, and barycentrics
    /// of its own second and third corner.
    void toTriangle(Hit &hit) const;

  private:
    /// The place of a triangle, four times, and how many corners it is turned by: its own corner `turn` is a, or c.
    using Member = std::uint32_t;
    using Members = std::array<Member, 2>;
    static constexpr Member kAlone = kNone;
    /// [quads] where quad q is triangles 2 q and 2 q + 1: the first one's turns, and four times the second one's.
    std::vector<std::uint8_t> turns_;
    std::vector<Members> members_; ///< [quads] of other meshes

    [[nodiscard]] Members membersOf(Index quad) const {
        if (turns_.empty()) return members_[quad];
        const Member turns = turns_[quad];
        return {8 * quad + (turns & 3U), 8 * quad + 4 + (turns >> 2U)};
    }
};

// Without a branch: which of the two it is no processor foresees.
inline void TrianglePairs::toTriangle(Hit &hit) const {
    constexpr std::array<std::uint8_t, 4> kSecond{1, 0, 2, 0}; // [turns] which of a, b and d the triangle's own second corner is
    constexpr std::array<std::uint8_t, 4> kThird{2, 1, 0, 0};
    const Members pair = membersOf(hit.primitive);
    const auto second = static_cast<unsigned>(hit.u + hit.v > 1) & static_cast<unsigned>(pair[1] != kAlone);
    const Member member = pair[second];
    const float one = static_cast<float>(second);
    const float u = std::abs(one - hit.u);
    const float v = std::abs(one - hit.v);
    const std::array<float, 3> weights{1 - u - v, u, v};
    hit.primitive = member >> 2U;
    hit.u = weights[kSecond[member & 3U]];
    hit.v = weights[kThird[member & 3U]];
}

} // namespace taut
