#include "taut/mesh/topology.h"

#include "taut/mesh/weld.h"

#include <OpenMesh/Core/Mesh/PolyConnectivity.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace taut {

namespace {

using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

/// OpenMesh says on standard error what it refuses.
class QuietOpenMesh {
  public:
    QuietOpenMesh() { omerr().disable(); }
    ~QuietOpenMesh() {
        if (wasEnabled_) omerr().enable();
    }
    QuietOpenMesh(const QuietOpenMesh &) = delete;
    QuietOpenMesh &operator=(const QuietOpenMesh &) = delete;

  private:
    bool wasEnabled_ = omerr().is_enabled();
};

/// Disjoint sets of numbers, with path halving.
class Sets {
  public:
    explicit Sets(std::size_t size) : parent_(size), count_(size) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
    void join(Index a, Index b) {
        a = root(a);
        b = root(b);
        if (a == b) return;
        parent_[std::max(a, b)] = std::min(a, b);
        --count_;
    }
    [[nodiscard]] std::size_t count() const { return count_; }

  private:
    Index root(Index a) {
        for (; parent_[a] != a; a = parent_[a]) parent_[a] = parent_[parent_[a]];
        return a;
    }
    std::vector<Index> parent_;
    std::size_t count_;
};

/// OpenMesh looks for an edge among all at one of its ends: a fan of n faces would cost n^2.
constexpr Index kMostFaces = 256;

/// An edge that has one face in OpenMesh's mesh, by the positions at its ends.
struct OpenEdge {
    Index a, b;             ///< a < b
    HalfedgeHandle outside; ///< the half-edge without a face
};

Index number(OpenMesh::BaseHandle handle) {
    return static_cast<Index>(handle.idx());
}

/// OpenMesh takes what is manifold and of one orientation. A face that it refuses, or that hangs on a crowded position, gets
/// vertices of its own; where edges that came apart so have the same ends, they are put together again.
class TopologyCounter {
  public:
    TopologyCounter(const Mesh &mesh, const std::vector<Index> &canonical)
        : positionOf_(mesh.positions.size()), facesAt_(mesh.positions.size()) {
        std::iota(positionOf_.begin(), positionOf_.end(), Index{0});
        for (std::size_t v = 0; v < positionOf_.size(); ++v) edges_.new_vertex();
        for (const Index position : mesh.cornerPositions) ++facesAt_[canonical[position]];
        const QuietOpenMesh quiet;
        std::vector<VertexHandle> corners;
        for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
            corners.clear();
            const Index end = mesh.faceOffsets[f + 1];
            for (Index c = mesh.faceOffsets[f]; c < end; ++c) {
                const Index next = c + 1 < end ? c + 1 : mesh.faceOffsets[f];
                const Index position = canonical[mesh.cornerPositions[c]];
                if (position != canonical[mesh.cornerPositions[next]]) corners.emplace_back(static_cast<int>(position));
            }
            if (corners.size() >= 3) addFace(corners);
        }
    }

    Topology count() {
        Topology topology;
        Sets components(edges_.n_faces());
        for (const auto e : edges_.edges())
            if (!edges_.is_boundary(e)) components.join(faceOf(edges_.halfedge_handle(e, 0)), faceOf(edges_.halfedge_handle(e, 1)));
        const std::vector<OpenEdge> open = openEdges();
        std::vector<OpenEdge> boundary;
        for (std::size_t i = 0, next = 0; i < open.size(); i = next) {
            while (next < open.size() && open[next].a == open[i].a && open[next].b == open[i].b) ++next;
            std::size_t faces = next - i;
            for (std::size_t k = i + 1; k < next; ++k) components.join(insideFace(open[i]), insideFace(open[k]));
            if (const HalfedgeHandle whole = wholeEdge(open[i]); whole.is_valid()) {
                components.join(insideFace(open[i]), faceOf(whole));
                faces += 2;
            }
            if (faces == 1) boundary.push_back(open[i]);
            if (faces > 2) ++topology.complexEdges;
        }
        topology.components = components.count();
        topology.boundaryLoops = countLoops(boundary);
        return topology;
    }

  private:
    void addFace(std::vector<VertexHandle> &corners) {
        std::vector<VertexHandle> sorted = corners;
        std::sort(sorted.begin(), sorted.end());
        const bool comesBack = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
        const bool crowded = std::any_of(corners.begin(), corners.end(), [&](VertexHandle v) { return facesAt_[number(v)] > kMostFaces; });
        if (!comesBack && !crowded && edges_.add_face(corners).is_valid()) return;
        anyApart_ = true;
        for (VertexHandle &corner : corners) {
            positionOf_.push_back(number(corner));
            corner = edges_.new_vertex();
        }
        edges_.add_face(corners);
    }

    [[nodiscard]] Index faceOf(HalfedgeHandle h) const { return number(edges_.face_handle(h)); }
    [[nodiscard]] Index insideFace(const OpenEdge &edge) const { return faceOf(edges_.opposite_halfedge_handle(edge.outside)); }
    [[nodiscard]] Index from(HalfedgeHandle h) const { return positionOf_[number(edges_.from_vertex_handle(h))]; }
    [[nodiscard]] Index to(HalfedgeHandle h) const { return positionOf_[number(edges_.to_vertex_handle(h))]; }

    /// Sorted by their ends.
    [[nodiscard]] std::vector<OpenEdge> openEdges() const {
        std::vector<OpenEdge> open;
        for (const auto h : edges_.halfedges())
            if (edges_.is_boundary(h)) open.push_back({std::min(from(h), to(h)), std::max(from(h), to(h)), h});
        std::sort(open.begin(), open.end(),
                  [](const OpenEdge &x, const OpenEdge &y) { return std::tie(x.a, x.b, x.outside) < std::tie(y.a, y.b, y.outside); });
        return open;
    }

    /// The edge of two faces between the same positions as that of a face set apart.
    [[nodiscard]] HalfedgeHandle wholeEdge(const OpenEdge &open) const {
        if (!anyApart_) return HalfedgeHandle();
        const HalfedgeHandle h = edges_.find_halfedge(VertexHandle(static_cast<int>(open.a)), VertexHandle(static_cast<int>(open.b)));
        return h.is_valid() && !edges_.is_boundary(edges_.edge_handle(h)) ? h : HalfedgeHandle();
    }

    static std::size_t countLoops(const std::vector<OpenEdge> &boundary) {
        std::vector<std::pair<Index, Index>> ends; // position, number of the edge
        for (std::size_t i = 0; i < boundary.size(); ++i)
            for (const Index position : {boundary[i].a, boundary[i].b}) ends.emplace_back(position, static_cast<Index>(i));
        std::sort(ends.begin(), ends.end());
        Sets loops(boundary.size());
        for (std::size_t i = 1; i < ends.size(); ++i)
            if (ends[i].first == ends[i - 1].first) loops.join(ends[i].second, ends[i - 1].second);
        return loops.count();
    }

    OpenMesh::PolyConnectivity edges_;
    std::vector<Index> positionOf_; ///< of each of OpenMesh's vertices
    std::vector<Index> facesAt_;    ///< [positions]
    bool anyApart_ = false;
};

} // namespace

Topology topologyOf(const Mesh &mesh, bool weld) {
    return TopologyCounter(mesh, weldPositions(mesh, weld)).count();
}

std::vector<Vec3> pointsOfFaces(const Mesh &mesh, const std::vector<Vec3> &positions) {
    std::vector<unsigned char> used(positions.size(), 0);
    for (const Index position : mesh.cornerPositions) used[position] = 1;
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (used[i] != 0) points.push_back(positions[i]);
    return points;
}

} // namespace taut
