#include "taut/render/triangle_pairs.h"

#include "taut/base/error.h"

#include <algorithm>
#include <string>

namespace taut {

namespace {

constexpr int kCorners = 3;
/// Edges that wait at a vertex among which a partner is looked for: a hub of a million open edges shall not take their square.
constexpr std::size_t kMostLooked = 64;
/// A mesh is one of quads that were cut where all but one in so many of its triangles have their partner beside them.
constexpr std::size_t kOfQuads = 16;

Index cornerOf(const Index3 &triangle, int corner) {
    return triangle[corner < kCorners ? corner : corner - kCorners];
}

bool isFlat(const Index3 &t) { // by its indices: its edges are not three
    return t.x == t.y || t.y == t.z || t.z == t.x;
}

/// An edge of `a` that `b` passes the other way round: the corner that it begins at in either. One where all three are shared, front and
/// back of a sheet. Negative: there is none.
struct SharedEdge {
    int ofA = -1, ofB = -1;
    [[nodiscard]] bool exists() const { return ofA >= 0; }
};
SharedEdge sharedEdge(const Index3 &a, const Index3 &b) {
    for (int i = 0; i < kCorners; ++i)
        for (int j = 0; j < kCorners; ++j)
            if (cornerOf(a, i) == cornerOf(b, j + 1) && cornerOf(a, i + 1) == cornerOf(b, j)) return {i, j};
    return {};
}

/// Who shares an edge with whom: for each triangle, up to three others that pass its edges the other way round. An edge of more than two
/// triangles joins the first two that fit.
class Neighbours {
  public:
    explicit Neighbours(std::span<const Index3> triangles) : of_(triangles.size(), Index3(kNone)) {
        Index most = 0;
        for (const Index3 &t : triangles) most = std::max({most, t.x, t.y, t.z});
        // Edges by the lower of their vertices, counted and laid side by side: a vertex has few.
        std::vector<Index> first(std::size_t{most} + 2, 0);
        const auto each = [&](auto &&of) {
            for (Index t = 0; t < triangles.size(); ++t)
                for (int i = 0; i < kCorners && !isFlat(triangles[t]); ++i) of(t, i);
        };
        const auto lower = [&](Index t, int i) { return std::min(cornerOf(triangles[t], i), cornerOf(triangles[t], i + 1)); };
        each([&](Index t, int i) { ++first[lower(t, i) + 1]; });
        for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
        std::vector<Edge> edges(first.back());
        std::vector<Index> next(first.begin(), first.end() - 1);
        each([&](Index t, int i) {
            const Index from = cornerOf(triangles[t], i);
            const Index to = cornerOf(triangles[t], i + 1);
            const Index at = std::min(from, to);
            Edge *const end = edges.data() + next[at];
            Edge *const begin = end - std::min<std::size_t>(next[at] - first[at], kMostLooked);
            Edge *const other = std::find_if(begin, end, [&](const Edge &e) { return e.from == to && e.to == from && e.triangle != t; });
            if (other == end) {
                edges[next[at]++] = {from, to, t, i};
                return;
            }
            of_[t][i] = other->triangle;
            of_[other->triangle][other->corner] = t;
            *other = *(end - 1);
            --next[at];
        });
    }

    template <class Do> void each(Index triangle, Do &&act) const {
        for (int i = 0; i < kCorners; ++i)
            if (of_[triangle][i] != kNone) act(of_[triangle][i]);
    }

  private:
    struct Edge {
        Index from, to, triangle;
        int corner;
    };
    std::vector<Index3> of_; ///< [triangle][edge]
};

/// Partners of triangles; kNone: alone.
using Partners = std::vector<Index>;

/// Those that follow each other, as in a mesh of quads that were cut.
std::size_t pairInOrder(std::span<const Index3> triangles, Partners &partners) {
    std::size_t paired = 0;
    for (Index t = 0; t + 1 < triangles.size(); ++t) {
        if (isFlat(triangles[t]) || isFlat(triangles[t + 1]) || !sharedEdge(triangles[t], triangles[t + 1]).exists()) continue;
        partners[t] = t + 1;
        partners[t + 1] = t;
        paired += 2;
        ++t;
    }
    return paired;
}

/// Who has the fewest free neighbours chooses first, and of them the one with the fewest: few stay alone.
void pairByNeighbours(std::span<const Index3> triangles, Partners &partners) {
    const Neighbours neighbours(triangles);
    std::vector<unsigned char> free(triangles.size(), 0); // neighbours without a partner
    for (Index t = 0; t < triangles.size(); ++t) neighbours.each(t, [&](Index) { ++free[t]; });
    std::vector<Index> urgent; // one free neighbour is left
    for (Index t = static_cast<Index>(triangles.size()); t-- > 0;)
        if (free[t] == 1) urgent.push_back(t);
    const auto pair = [&](Index t) {
        if (partners[t] != kNone) return;
        Index best = kNone;
        neighbours.each(t, [&](Index other) {
            if (partners[other] == kNone && (best == kNone || free[other] < free[best])) best = other;
        });
        if (best == kNone) return;
        partners[t] = best;
        partners[best] = t;
        for (const Index member : {t, best})
            neighbours.each(member, [&](Index other) {
                if (--free[other] == 1 && partners[other] == kNone) urgent.push_back(other);
            });
    };
    for (Index t = 0; t < triangles.size(); ++t) {
        pair(t);
        while (!urgent.empty()) {
            const Index hurried = urgent.back();
            urgent.pop_back();
            pair(hurried);
        }
    }
}

} // namespace

TrianglePairs::TrianglePairs(std::span<const Index3> triangles, std::span<const Index> places) {
    if (triangles.size() > kMost)
        throw InputError("found a mesh of " + std::to_string(triangles.size()) + " triangles, expected at most " + std::to_string(kMost));
    std::vector<Index3> joined; // the triangles, of places
    if (!places.empty()) {
        joined.reserve(triangles.size());
        for (const Index3 &t : triangles) joined.emplace_back(places[t.x], places[t.y], places[t.z]);
        triangles = joined;
    }
    Partners partners(triangles.size(), kNone);
    if (pairInOrder(triangles, partners) < triangles.size() - triangles.size() / kOfQuads) {
        std::fill(partners.begin(), partners.end(), kNone);
        pairByNeighbours(triangles, partners);
    }
    for (Index t = 0; t < triangles.size(); ++t) {
        const Index other = partners[t];
        if (other == kNone) members_.push_back({4 * t, kAlone});
        if (other == kNone || other < t) continue;
        const SharedEdge edge = sharedEdge(triangles[t], triangles[other]);
        const int a = (edge.ofA + 2) % kCorners; // across from the edge
        const int c = (edge.ofB + 2) % kCorners;
        members_.push_back({4 * t + static_cast<Member>(a), 4 * other + static_cast<Member>(c)});
    }
    const auto isInOrder = [q = Member{0}](const Members &pair) mutable {
        const Member first = 2 * q++;
        return pair[0] >> 2U == first && pair[1] >> 2U == first + 1;
    };
    if (!std::all_of(members_.begin(), members_.end(), isInOrder)) {
        members_.shrink_to_fit();
        return;
    }
    turns_.reserve(members_.size());
    for (const auto &[first, second] : members_) turns_.push_back(static_cast<std::uint8_t>((first & 3U) | (second & 3U) << 2U));
    members_ = std::vector<Members>();
}

void TrianglePairs::corners(std::span<const Index3> triangles, std::span<QuadCorners> quads) const {
    for (Index q = 0; q < size(); ++q) {
        const auto [first, second] = membersOf(q);
        const Index3 &t = triangles[first >> 2U];
        const int turn = static_cast<int>(first & 3U);
        const Index d = cornerOf(t, turn + 2);
        const Index c = second == kAlone ? d : cornerOf(triangles[second >> 2U], static_cast<int>(second & 3U));
        quads[q] = {cornerOf(t, turn), cornerOf(t, turn + 1), c, d};
    }
}

} // namespace taut
