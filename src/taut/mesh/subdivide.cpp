#include "taut/mesh/subdivide.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>

namespace taut {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// Weights are products of up to six masks: kept in double until the finished row is rounded once.
using RefinedTable = Far::StencilTableReal<double>;
using RefinedTableFactory = Far::StencilTableFactoryReal<double>;
using PrimvarRefiner = Far::PrimvarRefinerReal<double>;

constexpr std::size_t kGrain = 2048;
/// More stencil weights than this do not fit a common machine's memory (20 bytes each while they are made).
constexpr double kMaxWeights = 1 << 28;

/// Far reports through one callback for the whole process and prints by default. While this lives, messages are kept
/// instead; one refiner is built at a time.
class FarMessages {
  public:
    FarMessages() : lock_(mutex()) {
        text().clear();
        Far::SetErrorCallback([](Far::ErrorType, const char *message) { text() = message; });
        Far::SetWarningCallback([](const char *message) { text() = message; });
    }
    ~FarMessages() {
        Far::SetErrorCallback(nullptr);
        Far::SetWarningCallback(nullptr);
    }
    FarMessages(const FarMessages &) = delete;
    FarMessages &operator=(const FarMessages &) = delete;

    /// The last message, on one line.
    [[nodiscard]] static std::string last() {
        std::string line = text();
        std::replace(line.begin(), line.end(), '\n', ' ');
        while (!line.empty() && line.back() == ' ') line.pop_back();
        return line.empty() ? "no reason given" : line;
    }

  private:
    static std::mutex &mutex() {
        static std::mutex one;
        return one;
    }
    static std::string &text() {
        static std::string one;
        return one;
    }
    std::lock_guard<std::mutex> lock_;
};

[[noreturn]] void fail(const Mesh &cage, const std::string &reason) {
    throw RunError("can't subdivide mesh " + quoted(cage.name) + ": " + reason);
}

/// About how many weights the rows will hold. Around a face of n corners some n * 4^(level - 1) refined vertices depend on
/// all n of them; around a vertex in n faces, on some 2 n. Quadratic in n, so a fan of a million triangles must be refused.
double predictedWeights(const Mesh &cage, int level) {
    std::vector<Index> valence(cage.positions.size(), 0);
    for (const Index v : cage.cornerPositions) ++valence[v];
    double weights = 0;
    for (std::size_t f = 0; f < cage.faceCount(); ++f) weights += sqr(static_cast<double>(cage.faceOffsets[f + 1] - cage.faceOffsets[f]));
    for (const Index n : valence) weights += sqr(2.0 * n);
    return weights * std::pow(4.0, level - 1);
}

void checkSize(const Mesh &cage, int level) {
    if (level < 0 || level > kMaxSubdivisionLevel)
        fail(cage, "found level " + std::to_string(level) + ", expected 0 to " + std::to_string(kMaxSubdivisionLevel));
    const auto maxIndex = static_cast<std::size_t>(std::numeric_limits<int>::max());
    if (level > 0 && (cage.positions.size() > maxIndex || cage.uvs.size() > maxIndex || predictedWeights(cage, level) > kMaxWeights))
        fail(cage, std::to_string(cage.faceCount()) + " faces (or their valences) are too many for level " + std::to_string(level));
}

bool everyCornerHasUv(const Mesh &mesh) {
    return !mesh.cornerUvs.empty() && mesh.cornerUvs.size() == mesh.cornerCount() &&
           std::find(mesh.cornerUvs.begin(), mesh.cornerUvs.end(), kNone) == mesh.cornerUvs.end();
}

/// The cage's faces as OpenSubdiv takes them: it asserts where a face holds a position twice.
struct CageFaces {
    std::vector<int> sizes;
    std::vector<int> corners;
    std::vector<int> uvs; ///< empty: no channel
    std::vector<Index> materials;
};

/// A position that follows itself around a face is one corner, a face with fewer than three corners then is none; a
/// position that comes back later in the same face has no surface around it and is refused.
CageFaces facesOf(const Mesh &cage) {
    CageFaces faces;
    faces.sizes.reserve(cage.faceCount());
    faces.corners.reserve(cage.cornerCount());
    const bool hasUvs = everyCornerHasUv(cage);
    std::vector<int> sorted;
    for (std::size_t f = 0; f < cage.faceCount(); ++f) {
        const std::size_t start = faces.corners.size();
        const Index end = cage.faceOffsets[f + 1];
        for (Index c = cage.faceOffsets[f]; c < end; ++c) {
            const Index next = c + 1 < end ? c + 1 : cage.faceOffsets[f];
            if (cage.cornerPositions[c] == cage.cornerPositions[next]) continue;
            faces.corners.push_back(static_cast<int>(cage.cornerPositions[c]));
            if (hasUvs) faces.uvs.push_back(static_cast<int>(cage.cornerUvs[c]));
        }
        const std::size_t size = faces.corners.size() - start;
        if (size < 3) {
            faces.corners.resize(start);
            if (hasUvs) faces.uvs.resize(start);
            continue;
        }
        sorted.assign(faces.corners.begin() + static_cast<std::ptrdiff_t>(start), faces.corners.end());
        std::sort(sorted.begin(), sorted.end());
        const auto repeated = std::adjacent_find(sorted.begin(), sorted.end());
        if (repeated != sorted.end()) fail(cage, "face " + std::to_string(f) + " comes back to its position " + std::to_string(*repeated));
        faces.sizes.push_back(static_cast<int>(size));
        if (!cage.faceMaterials.empty()) faces.materials.push_back(cage.faceMaterials[f]);
    }
    if (faces.sizes.empty()) fail(cage, "it has no faces");
    return faces;
}

using RefinerPointer = std::unique_ptr<Far::TopologyRefiner>;

RefinerPointer makeRefiner(const Mesh &cage, const CageFaces &faces, int level) {
    Far::TopologyDescriptor topology;
    topology.numVertices = static_cast<int>(cage.positions.size());
    topology.numFaces = static_cast<int>(faces.sizes.size());
    topology.numVertsPerFace = faces.sizes.data();
    topology.vertIndicesPerFace = faces.corners.data();
    Far::TopologyDescriptor::FVarChannel uvChannel;
    if (!faces.uvs.empty()) {
        uvChannel.numValues = static_cast<int>(cage.uvs.size());
        uvChannel.valueIndices = faces.uvs.data();
        topology.numFVarChannels = 1;
        topology.fvarChannels = &uvChannel;
    }

    Sdc::Options scheme;
    scheme.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    scheme.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_ONLY);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    const FarMessages messages;
    RefinerPointer refiner(Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, scheme)));
    if (!refiner) fail(cage, FarMessages::last());
    Far::TopologyRefiner::UniformOptions uniform(level);
    uniform.fullTopologyInLastLevel = true; // what limit masks ask for
    refiner->RefineUniform(uniform);
    return refiner;
}

/// A row of limit weights under construction, fed by PrimvarRefiner as if it were a point.
class Row {
  public:
    explicit Row(const RefinedTable &refined) : refined_(refined), weights_(static_cast<std::size_t>(refined.GetNumControlVertices()), 0) {}

    void Clear() {
        for (const Index index : indices_) weights_[index] = 0;
        indices_.clear();
    }
    /// Adds `weight` times the row of a refined vertex.
    void AddWithWeight(int vertex, double weight) {
        const auto row = refined_.GetStencil(vertex);
        for (int k = 0; k < row.GetSize(); ++k) {
            const double added = weight * row.GetWeights()[k];
            if (added == 0) continue;
            const auto index = static_cast<Index>(row.GetVertexIndices()[k]);
            if (weights_[index] == 0) indices_.push_back(index);
            weights_[index] += added;
        }
    }
    void appendTo(StencilTable &table) {
        std::sort(indices_.begin(), indices_.end()); // neighbouring points are read in order
        for (const Index index : indices_) {
            table.indices.push_back(index);
            table.weights.push_back(static_cast<float>(weights_[index]));
        }
        if (table.indices.size() > std::numeric_limits<Index>::max()) throw RunError("a subdivided mesh has too many stencil weights");
        table.offsets.push_back(static_cast<Index>(table.indices.size()));
    }

  private:
    const RefinedTable &refined_;
    std::vector<double> weights_; ///< [control points], zero but at indices_. Masks hold no negative weight: none cancels
    std::vector<Index> indices_;
};

/// Source of PrimvarRefiner::Limit: a refined vertex stands for itself.
struct VertexNumbers {
    int operator[](int vertex) const { return vertex; }
};

/// Destination of PrimvarRefiner::Limit, which visits the vertices in order: one row is held at a time.
class RowWriter {
  public:
    RowWriter(const RefinedTable &refined, StencilTable &table) : row_(refined), table_(table) {}

    Row &operator[](int vertex) {
        if (vertex != current_) finish();
        current_ = vertex;
        return row_;
    }
    void finish() {
        if (current_ >= 0) row_.appendTo(table_);
    }

  private:
    Row row_;
    StencilTable &table_;
    int current_ = -1;
};

StencilTable limitStencils(const Far::TopologyRefiner &refiner) {
    RefinedTableFactory::Options options;
    options.generateIntermediateLevels = false;
    options.maxLevel = static_cast<unsigned>(refiner.GetMaxLevel()) & 0xfU;
    const std::unique_ptr<const RefinedTable> refined(RefinedTableFactory::Create(refiner, options));

    StencilTable table;
    table.offsets.reserve(static_cast<std::size_t>(refined->GetNumStencils()) + 1);
    table.indices.reserve(refined->GetControlIndices().size() * 5 / 4);
    table.weights.reserve(table.indices.capacity());
    RowWriter rows(*refined, table);
    PrimvarRefiner(refiner).Limit(VertexNumbers{}, rows);
    rows.finish();
    return table;
}

/// Texture coordinates as PrimvarRefiner wants them.
struct UvValue {
    DVec2 uv{0};
    void Clear() { uv = DVec2(0); }
    void AddWithWeight(const UvValue &other, double weight) { uv += weight * other.uv; }
};

void refineUvs(const Far::TopologyRefiner &refiner, const Mesh &cage, Mesh &refined) {
    const PrimvarRefiner primvars(refiner);
    std::vector<UvValue> values(cage.uvs.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i].uv = cage.uvs[i];
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        std::vector<UvValue> next(static_cast<std::size_t>(refiner.GetLevel(level).GetNumFVarValues(0)));
        primvars.InterpolateFaceVarying(level, values, next, 0);
        values = std::move(next);
    }
    std::vector<UvValue> limit(values.size());
    primvars.LimitFaceVarying(values, limit, 0);

    refined.uvs.reserve(limit.size());
    for (const UvValue &value : limit) refined.uvs.emplace_back(value.uv);
    const Far::TopologyLevel last = refiner.GetLevel(refiner.GetMaxLevel());
    refined.cornerUvs.reserve(refined.cornerCount());
    for (int f = 0; f < last.GetNumFaces(); ++f)
        for (const int value : last.GetFaceFVarValues(f, 0)) refined.cornerUvs.push_back(static_cast<Index>(value));
}

std::vector<Index> refinedMaterials(const Far::TopologyRefiner &refiner, std::vector<Index> materials) {
    if (materials.empty()) return {};
    const PrimvarRefiner primvars(refiner);
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        std::vector<Index> next(static_cast<std::size_t>(refiner.GetLevel(level).GetNumFaces()));
        primvars.InterpolateFaceUniform(level, materials, next);
        materials = std::move(next);
    }
    return materials;
}

Mesh refinedFaces(const Far::TopologyLevel &last) {
    Mesh mesh;
    mesh.faceOffsets.reserve(static_cast<std::size_t>(last.GetNumFaces()) + 1);
    mesh.cornerPositions.reserve(static_cast<std::size_t>(last.GetNumFaceVertices()));
    for (int f = 0; f < last.GetNumFaces(); ++f) {
        for (const int vertex : last.GetFaceVertices(f)) mesh.cornerPositions.push_back(static_cast<Index>(vertex));
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    return mesh;
}

Subdivision identity(const Mesh &cage) {
    Subdivision result;
    result.mesh = cage;
    result.mesh.morphs.clear();
    result.mesh.skin = {};
    result.positions.offsets.resize(cage.positions.size() + 1);
    result.positions.indices.resize(cage.positions.size());
    std::iota(result.positions.offsets.begin(), result.positions.offsets.end(), Index{0});
    std::iota(result.positions.indices.begin(), result.positions.indices.end(), Index{0});
    result.positions.weights.assign(cage.positions.size(), 1.0F);
    return result;
}

} // namespace

void applyStencils(const StencilTable &stencils, const std::vector<Vec3> &in, std::vector<Vec3> &out) {
    out.resize(stencils.rowCount());
    parallelFor(out.size(), kGrain, [&](std::size_t row) {
        Vec3 sum(0);
        for (Index k = stencils.offsets[row]; k < stencils.offsets[row + 1]; ++k) sum += stencils.weights[k] * in[stencils.indices[k]];
        out[row] = sum;
    });
}

Subdivision subdivide(const Mesh &cage, int level) {
    checkSize(cage, level);
    if (level == 0) return identity(cage);
    const CageFaces faces = facesOf(cage);
    const RefinerPointer refiner = makeRefiner(cage, faces, level);
    Subdivision result;
    result.mesh = refinedFaces(refiner->GetLevel(level));
    result.mesh.name = cage.name;
    result.mesh.materialNames = cage.materialNames;
    result.mesh.faceMaterials = refinedMaterials(*refiner, faces.materials);
    if (refiner->GetNumFVarChannels() > 0) refineUvs(*refiner, cage, result.mesh);
    result.positions = limitStencils(*refiner);
    applyStencils(result.positions, cage.positions, result.mesh.positions);
    return result;
}

} // namespace taut
