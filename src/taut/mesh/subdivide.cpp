#include "taut/mesh/subdivide.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/mesh/limit_rows.h"
#include "taut/mesh/triangulate.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>

namespace taut {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

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
    throw InputError("can't subdivide mesh " + quoted(cage.name) + ": " + reason);
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
    if (level < 0 || level > kReferenceLevel)
        fail(cage, "found level " + std::to_string(level) + ", expected 0 to " + std::to_string(kReferenceLevel));
    const auto maxIndex = static_cast<std::size_t>(std::numeric_limits<int>::max());
    if (level > 0 && (cage.positions.size() > maxIndex || cage.uvs.size() > maxIndex || predictedWeights(cage, level) > kMaxWeights))
        fail(cage, std::to_string(cage.faceCount()) + " faces (or their valences) are too many for level " + std::to_string(level));
}

bool everyCornerHas(const std::vector<Index> &indices, const Mesh &mesh) {
    return !indices.empty() && indices.size() == mesh.cornerCount() && std::find(indices.begin(), indices.end(), kNone) == indices.end();
}

/// The cage's faces as OpenSubdiv takes them: it asserts where a face holds a position twice.
struct CageFaces {
    std::vector<int> sizes;
    std::vector<int> corners;
    std::vector<int> uvs;    ///< empty: no channel
    std::vector<int> colors; ///< the same
    std::vector<Index> materials;
};

/// A position that follows itself around a face is one corner, a face with fewer than three corners then is none; a
/// position that comes back later in the same face has no surface around it and is refused.
CageFaces facesOf(const Mesh &cage) {
    CageFaces faces;
    faces.sizes.reserve(cage.faceCount());
    faces.corners.reserve(cage.cornerCount());
    const bool hasUvs = everyCornerHas(cage.cornerUvs, cage);
    const bool hasColors = everyCornerHas(cage.cornerColors, cage);
    std::vector<int> sorted;
    for (std::size_t f = 0; f < cage.faceCount(); ++f) {
        const std::size_t start = faces.corners.size();
        const Index end = cage.faceOffsets[f + 1];
        for (Index c = cage.faceOffsets[f]; c < end; ++c) {
            const Index next = c + 1 < end ? c + 1 : cage.faceOffsets[f];
            if (cage.cornerPositions[c] == cage.cornerPositions[next]) continue;
            faces.corners.push_back(static_cast<int>(cage.cornerPositions[c]));
            if (hasUvs) faces.uvs.push_back(static_cast<int>(cage.cornerUvs[c]));
            if (hasColors) faces.colors.push_back(static_cast<int>(cage.cornerColors[c]));
        }
        const std::size_t size = faces.corners.size() - start;
        if (size < 3) {
            faces.corners.resize(start);
            if (hasUvs) faces.uvs.resize(start);
            if (hasColors) faces.colors.resize(start);
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

/// Creases of the mesh, and those of edges whose two faces turn by more than the options' angle, as OpenSubdiv takes them.
struct Features {
    std::vector<int> edges; ///< pairs
    std::vector<float> edgeSharpness;
    std::vector<int> corners;
    std::vector<float> cornerSharpness;
};

Features featuresOf(const Mesh &cage, const CageFaces &faces, float creaseAngle) {
    Features features;
    const auto addEdge = [&](Index a, Index b, float sharpness) {
        features.edges.insert(features.edges.end(), {static_cast<int>(a), static_cast<int>(b)});
        features.edgeSharpness.push_back(sharpness);
    };
    for (const EdgeCrease &crease : cage.creases) addEdge(crease.a, crease.b, crease.sharpness);
    for (const SharpCorner &corner : cage.corners) {
        features.corners.push_back(static_cast<int>(corner.position));
        features.cornerSharpness.push_back(corner.sharpness);
    }
    if (!(creaseAngle < kPi)) return features;
    std::map<std::pair<int, int>, DVec3> firstNormal;
    std::size_t begin = 0;
    for (const int size : faces.sizes) {
        const auto count = static_cast<std::size_t>(size);
        std::vector<Vec3> points;
        for (std::size_t k = 0; k < count; ++k) points.push_back(cage.positions[static_cast<std::size_t>(faces.corners[begin + k])]);
        const DVec3 normal = glm::normalize(DVec3(polygonNormal(points)));
        for (std::size_t k = 0; k < count; ++k) {
            const int a = faces.corners[begin + k];
            const int b = faces.corners[begin + (k + 1) % count];
            const auto [other, isFirst] = firstNormal.try_emplace(std::minmax(a, b), normal);
            if (!isFirst && glm::dot(other->second, normal) < std::cos(static_cast<double>(creaseAngle)))
                addEdge(static_cast<Index>(a), static_cast<Index>(b), kInfinitelySharp);
        }
        begin += count;
    }
    return features;
}

using RefinerPointer = std::unique_ptr<Far::TopologyRefiner>;

RefinerPointer makeRefiner(const Mesh &cage, const CageFaces &faces, const SubdivisionOptions &options) {
    Far::TopologyDescriptor topology;
    topology.numVertices = static_cast<int>(cage.positions.size());
    topology.numFaces = static_cast<int>(faces.sizes.size());
    topology.numVertsPerFace = faces.sizes.data();
    topology.vertIndicesPerFace = faces.corners.data();
    const Features features = featuresOf(cage, faces, options.creaseAngle);
    topology.numCreases = static_cast<int>(features.edgeSharpness.size());
    topology.creaseVertexIndexPairs = features.edges.data();
    topology.creaseWeights = features.edgeSharpness.data();
    topology.numCorners = static_cast<int>(features.cornerSharpness.size());
    topology.cornerVertexIndices = features.corners.data();
    topology.cornerWeights = features.cornerSharpness.data();
    std::vector<Far::TopologyDescriptor::FVarChannel> channels;
    const auto addChannel = [&](std::size_t values, const std::vector<int> &indices) {
        if (indices.empty()) return;
        channels.emplace_back();
        channels.back().numValues = static_cast<int>(values);
        channels.back().valueIndices = indices.data();
    };
    addChannel(cage.uvs.size(), faces.uvs);
    addChannel(cage.colors.size(), faces.colors);
    topology.numFVarChannels = static_cast<int>(channels.size());
    topology.fvarChannels = channels.data();

    Sdc::Options rules;
    rules.SetVtxBoundaryInterpolation(options.boundary == SubdivisionBoundary::EdgeOnly ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                                                        : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    rules.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_ONLY);
    const bool loop = options.scheme == SubdivisionScheme::Loop;
    if (const auto other = std::find_if(faces.sizes.begin(), faces.sizes.end(), [](int size) { return size != 3; });
        loop && other != faces.sizes.end())
        fail(cage, "found a face with " + std::to_string(*other) + " corners, expected triangles for the scheme \"loop\"");
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    const FarMessages messages;
    RefinerPointer refiner(Factory::Create(topology, Factory::Options(loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, rules)));
    if (!refiner) fail(cage, FarMessages::last());
    Far::TopologyRefiner::UniformOptions uniform(options.level);
    uniform.fullTopologyInLastLevel = true; // what limit masks ask for
    refiner->RefineUniform(uniform);
    return refiner;
}

/// A value of corners (texture coordinates, a colour) as PrimvarRefiner wants it.
template <class V> struct CornerValue {
    V value{0};
    void Clear() { value = V(0); }
    void AddWithWeight(const CornerValue &other, double weight) { value += weight * other.value; }
};

/// The values of a face-varying channel on the limit.
template <class Wide, class V> std::vector<V> refinedValues(const Far::TopologyRefiner &refiner, const std::vector<V> &cage, int channel) {
    const PrimvarRefiner primvars(refiner);
    std::vector<CornerValue<Wide>> values(cage.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i].value = Wide(cage[i]);
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        std::vector<CornerValue<Wide>> next(static_cast<std::size_t>(refiner.GetLevel(level).GetNumFVarValues(channel)));
        primvars.InterpolateFaceVarying(level, values, next, channel);
        values = std::move(next);
    }
    std::vector<CornerValue<Wide>> limit(values.size());
    primvars.LimitFaceVarying(values, limit, channel);
    std::vector<V> refined;
    refined.reserve(limit.size());
    for (const CornerValue<Wide> &value : limit) refined.emplace_back(value.value);
    return refined;
}

std::vector<Index> refinedCorners(const Far::TopologyRefiner &refiner, int channel) {
    const Far::TopologyLevel last = refiner.GetLevel(refiner.GetMaxLevel());
    std::vector<Index> corners;
    corners.reserve(static_cast<std::size_t>(last.GetNumFaceVertices()));
    for (int f = 0; f < last.GetNumFaces(); ++f)
        for (const int value : last.GetFaceFVarValues(f, channel)) corners.push_back(static_cast<Index>(value));
    return corners;
}

void refineCornerValues(const Far::TopologyRefiner &refiner, const Mesh &cage, const CageFaces &faces, Mesh &refined) {
    int channel = 0;
    if (!faces.uvs.empty()) {
        refined.uvs = refinedValues<DVec2>(refiner, cage.uvs, channel);
        if (!cage.uvs1.empty()) refined.uvs1 = refinedValues<DVec2>(refiner, cage.uvs1, channel);
        refined.cornerUvs = refinedCorners(refiner, channel++);
    }
    if (faces.colors.empty()) return;
    refined.colors = refinedValues<glm::dvec4>(refiner, cage.colors, channel);
    for (Vec4 &color : refined.colors) color = glm::clamp(color, Vec4(0), Vec4(1)); // of creases and corners, masks may overshoot
    refined.cornerColors = refinedCorners(refiner, channel);
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

double subdivisionBytes(const Mesh &cage, int level) {
    constexpr double kWeight = 16;        // of a row while it is made
    constexpr double kRefinedCorner = 70; // of OpenSubdiv's topology of all levels and of the refined mesh
    if (level <= 0) return 0;
    return kWeight * predictedWeights(cage, level) + kRefinedCorner * static_cast<double>(cage.cornerCount()) * std::pow(4.0, level);
}

void applyStencils(const StencilTable &stencils, const std::vector<Vec3> &in, std::vector<Vec3> &out) {
    out.resize(stencils.rowCount());
    parallelFor(out.size(), kGrain, [&](std::size_t row) {
        Vec3 sum(0);
        for (Index k = stencils.offsets[row]; k < stencils.offsets[row + 1]; ++k) sum += stencils.weights[k] * in[stencils.indices[k]];
        out[row] = sum;
    });
}

Subdivision subdivide(const Mesh &cage, const SubdivisionOptions &options) {
    checkSize(cage, options.level);
    if (options.level == 0) return identity(cage);
    const CageFaces faces = facesOf(cage);
    const RefinerPointer refiner = makeRefiner(cage, faces, options);
    Subdivision result;
    result.mesh = refinedFaces(refiner->GetLevel(options.level));
    result.mesh.name = cage.name;
    result.mesh.materialNames = cage.materialNames;
    result.mesh.faceMaterials = refinedMaterials(*refiner, faces.materials);
    refineCornerValues(*refiner, cage, faces, result.mesh);
    makeLimitRows(*refiner, options.scheme, cage.positions, result);
    return result;
}

} // namespace taut
