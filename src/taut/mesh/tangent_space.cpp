#include "taut/mesh/tangent_space.h"

#include "taut/mesh/triangulate.h"

#include <array>
#include <bit>
#include <map>
#include <tuple>

namespace taut {

namespace {

struct Triangle {
    std::array<Index, 3> corners{};
    Vec3 dPdu{0}; ///< unit, in the direction of growing u; 0 where the triangle has no UV area
    bool preserves = false;
    bool degenerate = false;                              ///< joins any group
    std::array<Index, 3> neighbours{kNone, kNone, kNone}; ///< across the edge from corner k to k + 1
    std::array<Index, 3> groups{kNone, kNone, kNone};
};

class TangentBuilder {
  public:
    TangentBuilder(const Mesh &mesh, std::span<const Vec3> positions, std::span<const Vec3> normals)
        : mesh_(mesh), positions_(positions), normals_(normals) {}

    TangentSpace build() {
        out_.corners.assign(mesh_.cornerCount(), kNone);
        if (mesh_.cornerUvs.empty()) return std::move(out_);
        weld();
        for (std::size_t face = 0; face < mesh_.faceCount(); ++face) addFace(face);
        findNeighbours();
        for (Index t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k)
                if (!triangles_[t].degenerate && group(t, k) == kNone) makeGroup(t, k);
        copyToDegenerate();
        return std::move(out_);
    }

  private:
    [[nodiscard]] const Vec3 &position(Index corner) const { return positions_[mesh_.cornerPositions[corner]]; }
    [[nodiscard]] const Vec2 &uv(Index corner) const { return mesh_.uvs[mesh_.cornerUvs[corner]]; }
    Index &group(Index triangle, int k) { return triangles_[triangle].groups[static_cast<std::size_t>(k)]; }
    [[nodiscard]] Index cornerOf(Index triangle, int k) const { return triangles_[triangle].corners[static_cast<std::size_t>(k % 3)]; }

    /// Numbers the vertices that corners share: equal in position, normal and UV, bit by bit.
    void weld() {
        std::map<std::array<std::uint32_t, 8>, Index> known;
        vertices_.resize(mesh_.cornerCount());
        for (Index c = 0; c < mesh_.cornerCount(); ++c) {
            if (mesh_.cornerUvs[c] == kNone) {
                vertices_[c] = kNone;
                continue;
            }
            std::array<std::uint32_t, 8> key{};
            const Vec3 &p = position(c);
            const Vec3 &n = normals_[c];
            const std::array<float, 8> values{p.x, p.y, p.z, n.x, n.y, n.z, uv(c).x, uv(c).y};
            for (std::size_t i = 0; i < key.size(); ++i) key[i] = std::bit_cast<std::uint32_t>(values[i] + 0.0F); // no -0
            vertices_[c] = known.try_emplace(key, static_cast<Index>(known.size())).first->second;
        }
    }

    void addFace(std::size_t face) {
        const Index begin = mesh_.faceOffsets[face];
        const Index count = mesh_.faceOffsets[face + 1] - begin;
        for (Index c = begin; c < begin + count; ++c)
            if (vertices_[c] == kNone) return;
        if (count == 4) return addQuad(begin);
        std::vector<Vec3> points;
        for (Index c = begin; c < begin + count; ++c) points.push_back(position(c));
        std::vector<Index3> local;
        triangulate(points, local);
        for (const Index3 &t : local) addTriangle({begin + t.x, begin + t.y, begin + t.z});
    }

    void addQuad(Index c) {
        const auto squared = [](const auto &v) { return glm::dot(v, v); };
        const float uv02 = squared(uv(c + 2) - uv(c));
        const float uv13 = squared(uv(c + 3) - uv(c + 1));
        bool along02 = uv02 < uv13;
        if (uv02 == uv13) along02 = !(squared(position(c + 3) - position(c + 1)) < squared(position(c + 2) - position(c)));
        const std::size_t first = triangles_.size();
        addTriangle(along02 ? std::array{c, c + 1, c + 2} : std::array{c, c + 1, c + 3});
        addTriangle(along02 ? std::array{c, c + 2, c + 3} : std::array{c + 1, c + 2, c + 3});
        Triangle &a = triangles_[first];
        Triangle &b = triangles_[first + 1];
        if (a.degenerate || b.degenerate || a.preserves == b.preserves) return;
        // The halves of a quad go together, with the larger one.
        (uvArea(a.corners) >= uvArea(b.corners) ? b : a).preserves = (uvArea(a.corners) >= uvArea(b.corners) ? a : b).preserves;
    }

    [[nodiscard]] float uvArea(const std::array<Index, 3> &c) const {
        const Vec2 a = uv(c[1]) - uv(c[0]);
        const Vec2 b = uv(c[2]) - uv(c[0]);
        return std::fabs(a.x * b.y - a.y * b.x);
    }

    void addTriangle(const std::array<Index, 3> &c) {
        Triangle t;
        t.corners = c;
        const Vec2 d1 = uv(c[1]) - uv(c[0]);
        const Vec2 d2 = uv(c[2]) - uv(c[0]);
        const float area = d1.x * d2.y - d1.y * d2.x;
        const Vec3 along = (position(c[1]) - position(c[0])) * d2.y - (position(c[2]) - position(c[0])) * d1.y;
        const float length = glm::length(along);
        t.preserves = area > 0;
        t.degenerate = !(std::fabs(area) > 0) || !(length > 0) || !std::isfinite(length);
        if (!t.degenerate) t.dPdu = along * ((t.preserves ? 1.0F : -1.0F) / length);
        triangles_.push_back(t);
    }

    void findNeighbours() {
        std::map<std::pair<Index, Index>, std::pair<Index, int>> open; // directed edge -> triangle, corner
        for (Index t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k) open.try_emplace({vertices_[cornerOf(t, k)], vertices_[cornerOf(t, k + 1)]}, t, k);
        for (Index t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const auto found = open.find({vertices_[cornerOf(t, k + 1)], vertices_[cornerOf(t, k)]});
                if (found != open.end()) triangles_[t].neighbours[static_cast<std::size_t>(k)] = found->second.first;
            }
    }

    /// The group of a corner: all that hangs together with it around its vertex.
    void makeGroup(Index first, int firstK) {
        const auto number = static_cast<Index>(out_.tangents.size());
        const Index vertex = vertices_[cornerOf(first, firstK)];
        const bool preserves = triangles_[first].preserves;
        std::vector<std::pair<Index, int>> stack{{first, firstK}};
        std::vector<std::pair<Index, int>> members;
        group(first, firstK) = number;
        while (!stack.empty()) {
            const auto [t, k] = stack.back();
            stack.pop_back();
            members.emplace_back(t, k);
            for (const int edge : {k, (k + 2) % 3}) { // the two edges at the vertex
                const Index other = triangles_[t].neighbours[static_cast<std::size_t>(edge)];
                if (other == kNone) continue;
                Triangle &n = triangles_[other];
                for (int j = 0; j < 3; ++j) {
                    if (vertices_[cornerOf(other, j)] != vertex || group(other, j) != kNone) continue;
                    if (n.degenerate) n.preserves = preserves;
                    if (n.preserves != preserves) continue;
                    group(other, j) = number;
                    stack.emplace_back(other, j);
                }
            }
        }
        Vec3 sum(0);
        for (const auto &[t, k] : members) {
            sum += weighted(t, k);
            out_.corners[cornerOf(t, k)] = number;
        }
        const Vec3 &n = normals_[cornerOf(first, firstK)];
        const float length = glm::length(sum);
        if (!(length > 0)) sum = smoothEnough(n);
        out_.tangents.emplace_back(length > 0 ? sum / length : sum, preserves ? 1.0F : -1.0F);
    }

    static Vec3 smoothEnough(const Vec3 &n) { return glm::normalize(std::fabs(n.x) < 0.5F ? Vec3(0, n.z, -n.y) : Vec3(-n.z, 0, n.x)); }

    /// A triangle's tangent at a corner, by its angle there.
    [[nodiscard]] Vec3 weighted(Index t, int k) const {
        if (triangles_[t].degenerate) return Vec3(0);
        const Index self = cornerOf(t, k);
        const Vec3 &n = normals_[self];
        const auto inPlane = [&](const Vec3 &v) {
            const Vec3 flat = v - n * glm::dot(n, v);
            const float length = glm::length(flat);
            return length > 0 ? flat / length : Vec3(0);
        };
        const Vec3 next = inPlane(position(cornerOf(t, k + 1)) - position(self));
        const Vec3 previous = inPlane(position(cornerOf(t, k + 2)) - position(self));
        return inPlane(triangles_[t].dPdu) * std::acos(glm::clamp(glm::dot(next, previous), -1.0F, 1.0F));
    }

    /// A triangle without UV area takes what others have at its vertices.
    void copyToDegenerate() {
        std::map<Index, Index> known;
        for (Index t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k)
                if (group(t, k) != kNone) known.try_emplace(vertices_[cornerOf(t, k)], group(t, k));
        for (Index t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                Index &corner = out_.corners[cornerOf(t, k)];
                const auto found = known.find(vertices_[cornerOf(t, k)]);
                if (corner == kNone && found != known.end()) corner = found->second;
            }
    }

    const Mesh &mesh_;
    std::span<const Vec3> positions_, normals_;
    std::vector<Index> vertices_; // [corners] welded
    std::vector<Triangle> triangles_;
    TangentSpace out_;
};

} // namespace

TangentSpace tangentSpace(const Mesh &mesh, std::span<const Vec3> positions, std::span<const Vec3> normals) {
    return TangentBuilder(mesh, positions, normals).build();
}

} // namespace taut
