/// glTF 2.0, section 3.7: vertex attributes, joint sets, morph targets and triangles of one primitive.

#include "taut/formats/gltf_primitive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace taut {

namespace {

/// The vertices of a primitive that are read.
struct Vertices {
    const GltfPrimitive &primitive;
    const std::vector<Index> &wanted;
    std::size_t all = gltfVertexCount(primitive);

    [[nodiscard]] std::size_t count() const { return wanted.size(); }
    /// Every attribute has a value for every vertex.
    void check(const GltfValue &reference) const {
        const std::size_t found = accessorCount(primitive.source, reference);
        if (found != all) reference.fail(std::to_string(found) + " elements", std::to_string(all) + ", the count of POSITION");
    }
};

template <class V> std::vector<V> readVectors(const Vertices &vertices, const GltfValue &reference) {
    const std::vector<float> values = accessorFloats(vertices.primitive.source, reference, V::length(), &vertices.wanted);
    vertices.check(reference);
    std::vector<V> vectors(values.size() / static_cast<std::size_t>(V::length()));
    for (std::size_t i = 0; i < vectors.size(); ++i)
        for (int c = 0; c < V::length(); ++c)
            vectors[i][c] = values[i * static_cast<std::size_t>(V::length()) + static_cast<std::size_t>(c)];
    return vectors;
}

/// An optional vertex attribute; empty where the primitive lacks it.
template <class V> std::vector<V> readAttribute(const Vertices &vertices, std::string_view attribute) {
    const GltfValue reference = vertices.primitive.attributes[attribute];
    return reference.present() ? readVectors<V>(vertices, reference) : std::vector<V>();
}

/// The accessor that an attribute names, whose index has been checked.
GltfValue accessorOf(const GltfSource &source, const GltfValue &reference) {
    const GltfValue accessors = source["accessors"];
    return accessors[reference.index(accessors.size(), "accessors")];
}

constexpr long long kUnsignedByte = 5121;
constexpr long long kUnsignedShort = 5123;

/// Indices that the format keeps for restarting a primitive: the greatest of their type (section 3.7.2.1).
Index restartValue(long long componentType) {
    if (componentType == kUnsignedByte) return std::numeric_limits<std::uint8_t>::max();
    if (componentType == kUnsignedShort) return std::numeric_limits<std::uint16_t>::max();
    return std::numeric_limits<Index>::max();
}

std::vector<Index> readIndices(const GltfPrimitive &primitive, std::size_t positions) {
    const GltfValue reference = primitive.gltf["indices"];
    std::vector<Index> indices;
    if (!reference.present()) {
        indices.resize(positions);
        for (std::size_t i = 0; i < positions; ++i) indices[i] = static_cast<Index>(i);
        return indices;
    }
    indices = accessorIndices(primitive.source, reference, 1);
    const Index restart = restartValue(accessorOf(primitive.source, reference)["componentType"].integer(0));
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (indices[i] == restart)
            reference.fail("vertex index " + std::to_string(indices[i]) + " at place " + std::to_string(i) +
                               ", the value of primitive restart",
                           "indices below it");
        if (indices[i] >= positions)
            reference.fail("vertex index " + std::to_string(indices[i]) + " at place " + std::to_string(i),
                           "0 to " + std::to_string(positions - 1));
    }
    return indices;
}

/// COLOR_0: three or four components, floats or normalised integers; linear, at most 1.
std::vector<Vec4> readColors(const Vertices &vertices) {
    const GltfPrimitive &primitive = vertices.primitive;
    const GltfValue reference = primitive.attributes["COLOR_0"];
    if (!reference.present()) return {};
    const GltfValue accessor = accessorOf(primitive.source, reference);
    std::vector<Vec4> colors;
    if (accessor["type"].text() == "VEC3")
        for (const Vec3 &color : readVectors<Vec3>(vertices, reference)) colors.emplace_back(color, 1);
    else
        colors = readVectors<Vec4>(vertices, reference);
    std::size_t outside = 0;
    for (Vec4 &color : colors) {
        const Vec4 held = glm::clamp(color, Vec4(0), Vec4(1));
        outside += held != color ? 1 : 0;
        color = held;
    }
    if (outside != 0)
        primitive.warnings.add(reference.place() + ": " + std::to_string(outside) + " of " + std::to_string(colors.size()) +
                               " colours are outside 0 to 1 and held there");
    return colors;
}

/// Corners of the triangles of a list, strip or fan; glTF 2.0, section 3.7.2.1 gives the order.
std::vector<Index> triangleCorners(const GltfPrimitive &primitive, std::vector<Index> indices) {
    const bool isList = primitive.mode == kGltfTriangles;
    if (indices.size() < 3 || (isList && indices.size() % 3 != 0))
        primitive.gltf.fail(std::to_string(indices.size()) + (primitive.gltf.has("indices") ? " indices" : " vertices"),
                            isList ? "a multiple of three, at least three" : "at least three");
    // Three arrays of the mesh hold its corners, and this one.
    constexpr double kBytesPerTriangle = 3 * 4 * sizeof(Index) + 2 * sizeof(Index);
    const std::size_t triangles = isList ? indices.size() / 3 : indices.size() - 2;
    primitive.source.budget.take(kBytesPerTriangle * static_cast<double>(triangles), primitive.gltf.place(),
                                 std::to_string(triangles) + " triangles");
    if (isList) return indices;
    std::vector<Index> corners;
    corners.reserve((indices.size() - 2) * 3);
    for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
        const std::array<std::size_t, 3> strip{i, i + 1 + i % 2, i + 2 - i % 2};
        const std::array<std::size_t, 3> fan{i + 1, i + 2, 0};
        for (const std::size_t place : primitive.mode == kGltfStrip ? strip : fan) corners.push_back(indices[place]);
    }
    return corners;
}

// --- skin weights ----------------------------------------------------------------------------------------------------

/// One pair of JOINTS_n and WEIGHTS_n: four influences a vertex.
struct InfluenceSet {
    std::vector<Index> joints;
    std::vector<float> weights;
};

std::vector<InfluenceSet> readInfluenceSets(const Vertices &vertices) {
    const GltfPrimitive &primitive = vertices.primitive;
    std::vector<InfluenceSet> sets;
    while (true) {
        const std::string number = std::to_string(sets.size());
        const GltfValue joints = primitive.attributes["JOINTS_" + number];
        const GltfValue weights = primitive.attributes["WEIGHTS_" + number];
        if (!joints.present() && !weights.present()) return sets;
        if (!joints.present() || !weights.present())
            primitive.attributes.fail("no " + std::string(joints.present() ? "WEIGHTS_" : "JOINTS_") + number,
                                      "JOINTS_n and WEIGHTS_n in pairs");
        InfluenceSet set;
        set.joints = accessorIndices(primitive.source, joints, 4, &vertices.wanted);
        set.weights = accessorFloats(primitive.source, weights, 4, &vertices.wanted);
        vertices.check(joints);
        vertices.check(weights);
        for (std::size_t i = 0; i < set.weights.size(); ++i)
            if (set.weights[i] < 0)
                weights.fail("weight " + std::to_string(set.weights[i]) + " in element " + std::to_string(vertices.wanted[i / 4]),
                             "weights from 0 to 1");
        sets.push_back(std::move(set));
    }
}

SkinWeights readSkinWeights(const Vertices &vertices) {
    const GltfPrimitive &primitive = vertices.primitive;
    const std::vector<InfluenceSet> sets = readInfluenceSets(vertices);
    SkinWeights skin;
    if (sets.empty()) return skin;
    std::size_t unweighted = 0;
    std::size_t rescaled = 0;
    skin.offsets.push_back(0);
    for (std::size_t v = 0; v < vertices.count(); ++v) {
        double sum = 0;
        for (const InfluenceSet &set : sets)
            for (std::size_t i = 4 * v; i < 4 * v + 4; ++i) sum += static_cast<double>(set.weights[i]);
        for (const InfluenceSet &set : sets)
            for (std::size_t i = 4 * v; i < 4 * v + 4; ++i) {
                if (!(set.weights[i] > 0)) continue;
                skin.joints.push_back(set.joints[i]);
                skin.weights.push_back(static_cast<float>(static_cast<double>(set.weights[i]) / sum));
            }
        skin.offsets.push_back(static_cast<Index>(skin.joints.size()));
        if (!(sum > 0))
            ++unweighted;
        else if (std::fabs(sum - 1) > 1e-2)
            ++rescaled;
    }
    const std::string prefix = primitive.gltf.place() + " (" + taut::quoted(primitive.name) + "): ";
    const std::string of = " of " + std::to_string(vertices.count()) + " vertices";
    if (unweighted != 0) primitive.warnings.add(prefix + std::to_string(unweighted) + of + " have no skin weight and follow no joint");
    if (rescaled != 0)
        primitive.warnings.add(prefix + "the skin weights of " + std::to_string(rescaled) + of + " did not sum to 1 and were rescaled");
    return skin;
}

// --- morph targets ---------------------------------------------------------------------------------------------------

/// A target's NORMAL adds to the primitive's own, where it has one; tangents go with the surface, whatever a target says of them.
std::vector<MorphTarget> readMorphs(const Vertices &vertices, const std::vector<std::string> &names, bool hasNormals) {
    const GltfPrimitive &primitive = vertices.primitive;
    const GltfValue targets = primitive.gltf["targets"];
    std::vector<MorphTarget> morphs;
    for (std::size_t t = 0; t < targets.size(); ++t) {
        const GltfValue position = targets[t]["POSITION"];
        const GltfValue normal = targets[t]["NORMAL"];
        for (const char *unused : {"TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"})
            if (targets[t].has(unused)) primitive.leftOut.add("morph target " + std::string(unused));
        if (normal.present() && !hasNormals) primitive.leftOut.add("morph target NORMAL");
        primitive.source.budget.take(sizeof(MorphTarget) + static_cast<double>(names[t].size()) +
                                         (position.present() ? 0.0 : static_cast<double>(vertices.count()) * sizeof(Vec3)),
                                     targets.place(), std::to_string(targets.size()) + " morph targets");
        MorphTarget morph;
        morph.name = names[t];
        if (position.present())
            morph.positionDeltas = readVectors<Vec3>(vertices, position);
        else
            morph.positionDeltas.assign(vertices.count(), Vec3(0));
        if (normal.present() && hasNormals) morph.normalDeltas = readVectors<Vec3>(vertices, normal);
        morphs.push_back(std::move(morph));
    }
    return morphs;
}

// --- what `taut export` wrote ------------------------------------------------------------------------------------------

/// M at every vertex, of a file that `taut export` wrote; empty where there is none, or no frame for it.
std::vector<Vec3> readStoredM(const Vertices &vertices) {
    const GltfPrimitive &primitive = vertices.primitive;
    const GltfValue stored = primitive.attributes["_TAUT_M"];
    std::vector<Vec3> m = readAttribute<Vec3>(vertices, "_TAUT_M");
    for (std::size_t v = 0; v < m.size(); ++v)
        if (!(m[v].x > 0 && m[v].z > 0))
            stored.fail(std::to_string(m[v].x) + " and " + std::to_string(m[v].z) + " on the diagonal in element " +
                            std::to_string(vertices.wanted[v]),
                        "numbers above 0");
    if (m.empty()) return m;
    if (!(primitive.attributes.has("NORMAL") && primitive.attributes.has("TANGENT"))) {
        primitive.warnings.add(stored.place() + " is left out: it needs NORMAL and TANGENT");
        return {};
    }
    const std::vector<Vec2> lean = readAttribute<Vec2>(vertices, "_TAUT_LEAN");
    if (std::any_of(lean.begin(), lean.end(), [](const Vec2 &l) { return l != Vec2(0); }))
        primitive.warnings.add(primitive.attributes["_TAUT_LEAN"].place() + ": a stored M is taken as upright");
    return m;
}

bool isRead(std::string_view attribute) {
    for (const std::string_view known : {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "_TAUT_M", "_TAUT_LEAN"})
        if (attribute == known) return true;
    return attribute.substr(0, 7) == "JOINTS_" || attribute.substr(0, 8) == "WEIGHTS_";
}

/// Counts the attributes that nothing reads.
void tallyAttributes(const GltfPrimitive &primitive) {
    for (const std::string &name : primitive.attributes.keys())
        if (!isRead(name) && name.substr(0, 6) != "_TAUT_") primitive.leftOut.add(name);
}

} // namespace

std::size_t gltfVertexCount(const GltfPrimitive &primitive) {
    const GltfValue position = primitive.attributes["POSITION"];
    if (!position.present()) primitive.attributes.fail("no POSITION", "'POSITION'");
    return accessorCount(primitive.source, position);
}

Mesh readGltfVertices(const GltfPrimitive &primitive, const std::vector<Index> &wanted, const std::vector<std::string> &targetNames) {
    const Vertices vertices{primitive, wanted};
    Mesh mesh;
    mesh.positions = readVectors<Vec3>(vertices, primitive.attributes["POSITION"]);
    mesh.normals = readAttribute<Vec3>(vertices, "NORMAL");
    mesh.tangents = readAttribute<Vec4>(vertices, "TANGENT");
    mesh.uvs = readAttribute<Vec2>(vertices, "TEXCOORD_0");
    mesh.uvs1 = readAttribute<Vec2>(vertices, "TEXCOORD_1");
    if (mesh.uvs.empty()) mesh.uvs = mesh.uvs1; // tangents follow the only set
    for (std::vector<Vec2> *uvs : {&mesh.uvs, &mesh.uvs1})
        for (Vec2 &uv : *uvs) uv.y = 1 - uv.y;
    mesh.colors = readColors(vertices);
    mesh.storedM = readStoredM(vertices);
    mesh.morphs = readMorphs(vertices, targetNames, !mesh.normals.empty());
    mesh.skin = readSkinWeights(vertices);
    tallyAttributes(primitive);
    return mesh;
}

std::vector<Index> readGltfTriangles(const GltfPrimitive &primitive) {
    return triangleCorners(primitive, readIndices(primitive, gltfVertexCount(primitive)));
}

} // namespace taut
