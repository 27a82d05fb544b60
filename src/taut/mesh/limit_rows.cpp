#include "taut/mesh/limit_rows.h"

#include "taut/base/error.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/sdc/catmarkScheme.h>
#include <opensubdiv/sdc/loopScheme.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <numeric>

namespace taut {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// Weights are products of up to six masks: kept in double until the finished row is rounded once.
using RefinedTable = Far::StencilTableReal<double>;
using RefinedTableFactory = Far::StencilTableFactoryReal<double>;
using PrimvarRefiner = Far::PrimvarRefinerReal<double>;

/// Tangents whose sine is less than this span no plane.
constexpr double kLeastSine = 1e-5;
/// A corner whose edges' plane stands steeper on its faces than this cosine is nearly straight: the plane is that of chance.
constexpr double kLeastFacing = 0.25;

/// A sparse row of weights of the cage's points under construction, as a sum over refined vertices.
template <std::size_t N> class Row {
  public:
    using Weights = std::array<double, N>;

    explicit Row(const RefinedTable &refined)
        : refined_(refined), weights_(static_cast<std::size_t>(refined.GetNumControlVertices())), used_(weights_.size(), false) {}

    void add(int vertex, const Weights &weights) {
        const auto row = refined_.GetStencil(vertex);
        for (int k = 0; k < row.GetSize(); ++k) {
            if (row.GetWeights()[k] == 0) continue;
            const auto index = static_cast<Index>(row.GetVertexIndices()[k]);
            if (!used_[index]) indices_.push_back(index);
            used_[index] = true;
            for (std::size_t i = 0; i < N; ++i) weights_[index][i] += weights[i] * row.GetWeights()[k];
        }
    }
    /// Calls f(index, weights) in order of the indices and starts anew.
    template <class F> void take(const F &f) {
        std::sort(indices_.begin(), indices_.end()); // neighbouring points are read in order
        for (const Index index : indices_) {
            if (weights_[index] != Weights{}) f(index, weights_[index]);
            weights_[index] = {};
            used_[index] = false;
        }
        indices_.clear();
    }

  private:
    const RefinedTable &refined_;
    std::vector<Weights> weights_; ///< [control points], zero but at indices_
    std::vector<bool> used_;
    std::vector<Index> indices_;
};

void endRow(const std::vector<Index> &indices, std::vector<Index> &offsets) {
    if (indices.size() > std::numeric_limits<Index>::max()) throw RunError("a subdivided mesh has too many stencil weights");
    offsets.push_back(static_cast<Index>(indices.size()));
}

/// Source and destination of PrimvarRefiner::Limit: a refined vertex stands for itself, and rows are taken in order.
struct VertexNumbers {
    int operator[](int vertex) const { return vertex; }
};
struct PositionRow {
    Row<1> &row;
    void Clear() {}
    void AddWithWeight(int vertex, double weight) { row.add(vertex, {weight}); }
};
class PositionRows {
  public:
    PositionRows(const RefinedTable &refined, StencilTable &table) : row_(refined), table_(table) {}
    PositionRow operator[](int vertex) {
        if (vertex != current_) finish();
        current_ = vertex;
        return {row_};
    }
    void finish() {
        if (current_ < 0) return;
        row_.take([&](Index index, const std::array<double, 1> &weight) {
            table_.indices.push_back(index);
            table_.weights.push_back(static_cast<float>(weight[0]));
        });
        endRow(table_.indices, table_.offsets);
    }

  private:
    Row<1> row_;
    StencilTable &table_;
    int current_ = -1;
};

/// The faces around a vertex between two sharp edges, or all of them: a smooth piece of surface with one tangent plane. Edges and
/// faces are counter-clockwise, face i after edge i; with ends, one edge more than faces.
struct Sector {
    std::vector<int> edges, faces; ///< numbers in the vertex's own lists
    bool hasEnds = false;
};

std::vector<Sector> sectorsAt(const Far::TopologyLevel &level, int vertex) {
    const int faceCount = level.GetVertexFaces(vertex).size();
    const auto edges = level.GetVertexEdges(vertex);
    const int edgeCount = edges.size();
    const auto isSharp = [&](int i) { return level.IsEdgeBoundary(edges[i]) || level.GetEdgeSharpness(edges[i]) > 0; };
    std::vector<int> sharp;
    for (int i = 0; i < edgeCount; ++i)
        if (isSharp(i)) sharp.push_back(i);
    std::vector<Sector> sectors;
    if (sharp.size() < 2) { // smooth or a dart: the whole ring
        Sector all;
        for (int i = 0; i < edgeCount; ++i) all.edges.push_back(i);
        for (int i = 0; i < faceCount; ++i) all.faces.push_back(i);
        sectors.push_back(std::move(all));
        return sectors;
    }
    for (std::size_t s = 0; s < sharp.size(); ++s) {
        Sector sector;
        sector.hasEnds = true;
        const int last = sharp[(s + 1) % sharp.size()];
        int i = sharp[s];
        for (; i != last || sector.edges.empty(); i = (i + 1) % edgeCount) {
            if (i >= faceCount) break; // beyond a boundary there is no face
            sector.edges.push_back(i);
            sector.faces.push_back(i);
        }
        if (i != last) continue;
        sector.edges.push_back(last);
        sectors.push_back(std::move(sector));
    }
    return sectors;
}

/// A vertex as Sdc::Scheme wants it: this sector alone, its ends infinitely sharp.
struct SectorVertex {
    const Sector &sector;
    [[nodiscard]] int GetNumEdges() const { return static_cast<int>(sector.edges.size()); }
    [[nodiscard]] int GetNumFaces() const { return static_cast<int>(sector.faces.size()); }
    void GetSharpnessPerEdge(float *sharpness) const {
        std::fill(sharpness, sharpness + sector.edges.size(), 0.0F);
        if (sector.hasEnds) sharpness[0] = sharpness[sector.edges.size() - 1] = Sdc::Crease::SHARPNESS_INFINITE;
    }
};

/// Weights that Sdc::Scheme assigns.
class Mask {
  public:
    using Weight = double;
    explicit Mask(const Sector &sector) : edges_(sector.edges.size() + 1), faces_(sector.edges.size() + 1) {}
    [[nodiscard]] int GetNumVertexWeights() const { return vertexCount_; }
    [[nodiscard]] int GetNumEdgeWeights() const { return edgeCount_; }
    [[nodiscard]] int GetNumFaceWeights() const { return faceCount_; }
    void SetNumVertexWeights(int count) { vertexCount_ = count; }
    void SetNumEdgeWeights(int count) { edgeCount_ = count; }
    void SetNumFaceWeights(int count) { faceCount_ = count; }
    [[nodiscard]] const Weight &VertexWeight(int) const { return vertex_; }
    [[nodiscard]] const Weight &EdgeWeight(int i) const { return edges_[static_cast<std::size_t>(i)]; }
    [[nodiscard]] const Weight &FaceWeight(int i) const { return faces_[static_cast<std::size_t>(i)]; }
    Weight &VertexWeight(int) { return vertex_; }
    Weight &EdgeWeight(int i) { return edges_[static_cast<std::size_t>(i)]; }
    Weight &FaceWeight(int i) { return faces_[static_cast<std::size_t>(i)]; }
    [[nodiscard]] bool AreFaceWeightsForFaceCenters() const { return false; }
    void SetFaceWeightsForFaceCenters(bool) {}

  private:
    double vertex_ = 0;
    std::vector<double> edges_, faces_;
    int vertexCount_ = 0, edgeCount_ = 0, faceCount_ = 0;
};

template <Sdc::SchemeType kScheme> class TangentRows {
  public:
    TangentRows(const Far::TopologyRefiner &refiner, const RefinedTable &refined, const std::vector<Vec3> &cage, Subdivision &out)
        : scheme_(refiner.GetSchemeOptions()), level_(refiner.GetLevel(refiner.GetMaxLevel())), row_(refined), cage_(cage), out_(out) {}

    void make() {
        out_.mesh.cornerNormals.assign(out_.mesh.cornerCount(), kNone);
        for (int v = 0; v < level_.GetNumVertices(); ++v) {
            if (level_.IsVertexNonManifold(v)) {
                addNonManifold(v);
                continue;
            }
            for (const Sector &sector : sectorsAt(level_, v))
                if (!sector.faces.empty()) addSector(v, sector);
        }
    }

  private:
    /// One normal and one row of tangents, for the corners of a sector.
    void addSector(int v, const Sector &sector) {
        DVec3 faces(0);
        for (const int i : sector.faces) faces += weightedCornerNormal(v, i);
        DVec3 normal(0);
        const bool corner = level_.GetVertexRule(v) == Sdc::Crease::RULE_CORNER;
        // A sharp vertex in the middle of smooth faces is the tip of a cone.
        if (sector.hasEnds || !corner) {
            addTangents(v, sector);
            const std::size_t begin = out_.tangents.indices.size();
            DVec3 t1(0);
            DVec3 t2(0);
            row_.take([&](Index index, const std::array<double, 2> &w) {
                t1 += DVec3(cage_[index]) * w[0];
                t2 += DVec3(cage_[index]) * w[1];
                out_.tangents.indices.push_back(index);
                out_.tangents.weights.emplace_back(static_cast<float>(w[0]), static_cast<float>(w[1]));
            });
            normal = glm::cross(t1, t2);
            bool spans = glm::length(normal) > kLeastSine * glm::length(t1) * glm::length(t2);
            if (corner && spans) spans = turnOutward(faces, begin, normal);
            if (!spans) {
                normal = DVec3(0);
                out_.tangents.indices.resize(begin);
                out_.tangents.weights.resize(begin);
            }
        }
        assignNormal(v, sector.faces, normal == DVec3(0) ? faces : normal);
    }

    /// The tangents of a corner are its two edges, counter-clockwise as long as they enclose less than pi. At a reflex corner they
    /// are clockwise and change places. False where their plane is not that of the faces between them.
    bool turnOutward(const DVec3 &faces, std::size_t begin, DVec3 &normal) {
        const double size = glm::length(faces) * glm::length(normal);
        if (!(size > 0)) return true; // the faces have collapsed
        const double facing = glm::dot(normal, faces) / size;
        if (facing < 0) {
            normal = -normal;
            for (std::size_t k = begin; k < out_.tangents.weights.size(); ++k)
                std::swap(out_.tangents.weights[k].x, out_.tangents.weights[k].y);
        }
        return std::fabs(facing) > kLeastFacing;
    }

    void addTangents(int v, const Sector &sector) {
        Mask position(sector);
        Mask t1(sector);
        Mask t2(sector);
        const bool corner = level_.GetVertexRule(v) == Sdc::Crease::RULE_CORNER;
        Sector ends;
        if (corner) ends.edges = {sector.edges.front(), sector.edges.back()};
        const Sector &masked = corner ? ends : sector;
        const auto rule = corner ? Sdc::Crease::RULE_CORNER : sector.hasEnds ? Sdc::Crease::RULE_CREASE : Sdc::Crease::RULE_SMOOTH;
        scheme_.ComputeVertexLimitMask(SectorVertex{masked}, position, t1, t2, rule);
        const auto edges = level_.GetVertexEdges(v);
        const auto faces = level_.GetVertexFaces(v);
        const auto places = level_.GetVertexFaceLocalIndices(v);
        for (int i = 0; i < t1.GetNumFaceWeights(); ++i) {
            const int number = masked.faces[static_cast<std::size_t>(i)];
            const auto corners = level_.GetFaceVertices(faces[number]);
            row_.add(corners[(places[number] + 2) % corners.size()], {t1.FaceWeight(i), t2.FaceWeight(i)});
        }
        for (int i = 0; i < t1.GetNumEdgeWeights(); ++i) {
            const auto ends2 = level_.GetEdgeVertices(edges[masked.edges[static_cast<std::size_t>(i)]]);
            row_.add(ends2[0] == v ? ends2[1] : ends2[0], {t1.EdgeWeight(i), t2.EdgeWeight(i)});
        }
        row_.add(v, {t1.VertexWeight(0), t2.VertexWeight(0)});
    }

    /// Faces joined by ordinary edges share a normal; there are no tangents.
    void addNonManifold(int v) {
        const auto faces = level_.GetVertexFaces(v);
        std::vector<int> group(static_cast<std::size_t>(faces.size()));
        std::iota(group.begin(), group.end(), 0);
        const auto edges = level_.GetVertexEdges(v);
        for (int i = 0; i < edges.size(); ++i) {
            const auto sides = level_.GetEdgeFaces(edges[i]);
            if (sides.size() != 2 || level_.GetEdgeSharpness(edges[i]) > 0 || level_.IsEdgeNonManifold(edges[i])) continue;
            const int from = group[static_cast<std::size_t>(faces.FindIndex(sides[1]))];
            std::replace(group.begin(), group.end(), from, group[static_cast<std::size_t>(faces.FindIndex(sides[0]))]);
        }
        for (int first = 0; first < faces.size(); ++first) {
            std::vector<int> members;
            DVec3 normal(0);
            for (int i = 0; i < faces.size(); ++i)
                if (group[static_cast<std::size_t>(i)] == first) {
                    members.push_back(i);
                    normal += weightedCornerNormal(v, i);
                }
            if (!members.empty()) assignNormal(v, members, normal);
        }
    }

    /// Ends the row of the tangents and gives its normal to the corners at v of the numbered faces.
    void assignNormal(int v, const std::vector<int> &faceNumbers, const DVec3 &normal) {
        Mesh &mesh = out_.mesh;
        const double length = glm::length(normal);
        const auto index = static_cast<Index>(mesh.normals.size());
        mesh.normals.push_back(length > 0 ? Vec3(normal / length) : Vec3(0, 0, 1));
        endRow(out_.tangents.indices, out_.tangents.offsets);
        for (const int i : faceNumbers) mesh.cornerNormals[cornerOf(v, i)] = index;
    }

    [[nodiscard]] std::size_t cornerOf(int v, int faceNumber) const {
        return out_.mesh.faceOffsets[static_cast<std::size_t>(level_.GetVertexFaces(v)[faceNumber])] +
               level_.GetVertexFaceLocalIndices(v)[faceNumber];
    }

    /// Normal of a face at its corner at v, as long as its angle there; zero where it has collapsed.
    [[nodiscard]] DVec3 weightedCornerNormal(int v, int faceNumber) const {
        const auto corners = level_.GetFaceVertices(level_.GetVertexFaces(v)[faceNumber]);
        const int place = level_.GetVertexFaceLocalIndices(v)[faceNumber];
        const auto point = [&](int k) {
            return DVec3(out_.mesh.positions[static_cast<std::size_t>(corners[(place + k) % corners.size()])]);
        };
        const DVec3 a = point(1) - point(0);
        const DVec3 b = point(corners.size() - 1) - point(0);
        const DVec3 n = glm::cross(a, b);
        const double length = glm::length(n);
        return length > 0 ? n * (std::atan2(length, glm::dot(a, b)) / length) : DVec3(0);
    }

    Sdc::Scheme<kScheme> scheme_;
    const Far::TopologyLevel &level_;
    Row<2> row_;
    const std::vector<Vec3> &cage_;
    Subdivision &out_;
};

} // namespace

void makeLimitRows(const Far::TopologyRefiner &refiner, SubdivisionScheme scheme, const std::vector<Vec3> &cage, Subdivision &out) {
    RefinedTableFactory::Options options;
    options.generateIntermediateLevels = false;
    options.maxLevel = static_cast<unsigned>(refiner.GetMaxLevel()) & 0xfU;
    const std::unique_ptr<const RefinedTable> refined(RefinedTableFactory::Create(refiner, options));

    StencilTable &table = out.positions;
    table.offsets.reserve(static_cast<std::size_t>(refined->GetNumStencils()) + 1);
    const std::size_t expected = refined->GetControlIndices().size() * 5 / 4;
    table.indices.reserve(expected);
    table.weights.reserve(expected);
    PositionRows positions(*refined, table);
    PrimvarRefiner(refiner).Limit(VertexNumbers{}, positions);
    positions.finish();
    applyStencils(table, cage, out.mesh.positions);

    out.tangents.indices.reserve(expected);
    out.tangents.weights.reserve(expected);
    if (scheme == SubdivisionScheme::Loop)
        TangentRows<Sdc::SCHEME_LOOP>(refiner, *refined, cage, out).make();
    else
        TangentRows<Sdc::SCHEME_CATMARK>(refiner, *refined, cage, out).make();
}

} // namespace taut
