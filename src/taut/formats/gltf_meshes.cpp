/// glTF 2.0, section 3.7: primitives become meshes, vertex attributes corner attributes, joint sets skin weights.

#include "taut/formats/gltf_accessors.h"
#include "taut/formats/read_formats.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace taut {

namespace {

/// The only modes of glTF's 0 to 6 that make triangles.
constexpr long long kTriangles = 4;
constexpr long long kStrip = 5;
constexpr long long kFan = 6;

/// One primitive while it is read.
struct Primitive {
    const GltfSource &source;
    GltfValue gltf; ///< meshes[m].primitives[p]
    std::string name;
    Warnings &warnings;
    GltfValue attributes = gltf["attributes"];
    long long mode = gltf["mode"].integer(kTriangles);
};

template <class V> std::vector<V> readVectors(const GltfSource &source, const GltfValue &reference) {
    const std::vector<float> values = accessorFloats(source, reference, V::length());
    std::vector<V> vectors(values.size() / static_cast<std::size_t>(V::length()));
    for (std::size_t i = 0; i < vectors.size(); ++i)
        for (int c = 0; c < V::length(); ++c)
            vectors[i][c] = values[i * static_cast<std::size_t>(V::length()) + static_cast<std::size_t>(c)];
    return vectors;
}

void checkVertexCount(const GltfValue &reference, std::size_t found, std::size_t positions) {
    if (found != positions) reference.fail(std::to_string(found) + " elements", std::to_string(positions) + ", the count of POSITION");
}

/// An optional vertex attribute; empty where the primitive lacks it.
template <class V> std::vector<V> readAttribute(const Primitive &primitive, std::string_view attribute, std::size_t positions) {
    const GltfValue reference = primitive.attributes[attribute];
    if (!reference.present()) return {};
    std::vector<V> values = readVectors<V>(primitive.source, reference);
    checkVertexCount(reference, values.size(), positions);
    return values;
}

std::vector<Index> readIndices(const Primitive &primitive, std::size_t positions) {
    const GltfValue reference = primitive.gltf["indices"];
    std::vector<Index> indices;
    if (!reference.present()) {
        indices.resize(positions);
        for (std::size_t i = 0; i < positions; ++i) indices[i] = static_cast<Index>(i);
        return indices;
    }
    indices = accessorIndices(primitive.source, reference, 1);
    for (std::size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= positions)
            reference.fail("vertex index " + std::to_string(indices[i]) + " at place " + std::to_string(i),
                           "0 to " + std::to_string(positions - 1));
    return indices;
}

/// Corners of the triangles of a list, strip or fan; glTF 2.0, section 3.7.2.1 gives the order.
std::vector<Index> triangleCorners(const Primitive &primitive, std::vector<Index> indices) {
    const bool isList = primitive.mode == kTriangles;
    if (indices.size() < 3 || (isList && indices.size() % 3 != 0))
        primitive.gltf.fail(std::to_string(indices.size()) + (primitive.gltf.has("indices") ? " indices" : " vertices"),
                            isList ? "a multiple of three, at least three" : "at least three");
    if (isList) return indices;
    std::vector<Index> corners;
    corners.reserve((indices.size() - 2) * 3);
    for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
        const std::array<std::size_t, 3> strip{i, i + 1 + i % 2, i + 2 - i % 2};
        const std::array<std::size_t, 3> fan{i + 1, i + 2, 0};
        for (const std::size_t place : primitive.mode == kStrip ? strip : fan) corners.push_back(indices[place]);
    }
    return corners;
}

// --- skin weights ----------------------------------------------------------------------------------------------------

/// One pair of JOINTS_n and WEIGHTS_n: four influences a vertex.
struct InfluenceSet {
    std::vector<Index> joints;
    std::vector<float> weights;
};

std::vector<InfluenceSet> readInfluenceSets(const Primitive &primitive, std::size_t positions) {
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
        set.joints = accessorIndices(primitive.source, joints, 4);
        set.weights = accessorFloats(primitive.source, weights, 4);
        checkVertexCount(joints, set.joints.size() / 4, positions);
        checkVertexCount(weights, set.weights.size() / 4, positions);
        for (std::size_t i = 0; i < set.weights.size(); ++i)
            if (set.weights[i] < 0)
                weights.fail("weight " + std::to_string(set.weights[i]) + " in element " + std::to_string(i / 4), "weights from 0 to 1");
        sets.push_back(std::move(set));
    }
}

SkinWeights readSkinWeights(const Primitive &primitive, std::size_t positions) {
    const std::vector<InfluenceSet> sets = readInfluenceSets(primitive, positions);
    SkinWeights skin;
    if (sets.empty()) return skin;
    std::size_t unweighted = 0;
    std::size_t rescaled = 0;
    skin.offsets.push_back(0);
    for (std::size_t v = 0; v < positions; ++v) {
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
    const std::string of = " of " + std::to_string(positions) + " vertices";
    if (unweighted != 0) primitive.warnings.add(prefix + std::to_string(unweighted) + of + " have no skin weight and follow no joint");
    if (rescaled != 0)
        primitive.warnings.add(prefix + "the skin weights of " + std::to_string(rescaled) + of + " did not sum to 1 and were rescaled");
    return skin;
}

// --- morph targets ---------------------------------------------------------------------------------------------------

std::vector<std::string> morphNames(const GltfValue &mesh, std::size_t count) {
    std::vector<std::string> names(count);
    const GltfValue listed = mesh["extras"]["targetNames"];
    for (std::size_t t = 0; t < count; ++t) {
        const std::string &name = listed[t].text();
        names[t] = name.empty() ? "morph" + std::to_string(t) : name;
    }
    return names;
}

std::vector<MorphTarget> readMorphs(const Primitive &primitive, const std::vector<std::string> &names, std::size_t positions) {
    const GltfValue targets = primitive.gltf["targets"];
    std::vector<MorphTarget> morphs;
    for (std::size_t t = 0; t < targets.size(); ++t) {
        const GltfValue position = targets[t]["POSITION"];
        MorphTarget morph;
        morph.name = names[t];
        if (position.present())
            morph.positionDeltas = readVectors<Vec3>(primitive.source, position);
        else
            morph.positionDeltas.assign(positions, Vec3(0));
        checkVertexCount(position, morph.positionDeltas.size(), positions);
        morphs.push_back(std::move(morph));
    }
    return morphs;
}

// --- primitives ------------------------------------------------------------------------------------------------------

/// M at every vertex, of a file that `taut export` wrote; empty where there is none, or no frame for it.
std::vector<Vec3> readStoredM(const Primitive &primitive, std::size_t positions) {
    const GltfValue stored = primitive.attributes["_TAUT_M"];
    std::vector<Vec3> m = readAttribute<Vec3>(primitive, "_TAUT_M", positions);
    for (std::size_t v = 0; v < m.size(); ++v)
        if (!(m[v].x > 0 && m[v].z > 0))
            stored.fail(std::to_string(m[v].x) + " and " + std::to_string(m[v].z) + " on the diagonal in element " + std::to_string(v),
                        "numbers above 0");
    if (m.empty()) return m;
    if (!(primitive.attributes.has("NORMAL") && primitive.attributes.has("TANGENT"))) {
        primitive.warnings.add(stored.place() + " is left out: it needs NORMAL and TANGENT");
        return {};
    }
    const std::vector<Vec2> lean = readAttribute<Vec2>(primitive, "_TAUT_LEAN", positions);
    if (std::any_of(lean.begin(), lean.end(), [](const Vec2 &l) { return l != Vec2(0); }))
        primitive.warnings.add(primitive.attributes["_TAUT_LEAN"].place() + ": a stored M is taken as upright");
    return m;
}

Mesh readPrimitive(const Primitive &primitive, const std::vector<std::string> &targetNames) {
    Mesh mesh;
    mesh.name = primitive.name;
    const GltfValue position = primitive.attributes["POSITION"];
    if (!position.present()) primitive.attributes.fail("no POSITION", "'POSITION'");
    mesh.positions = readVectors<Vec3>(primitive.source, position);
    const std::size_t positions = mesh.positions.size();
    mesh.normals = readAttribute<Vec3>(primitive, "NORMAL", positions);
    mesh.tangents = readAttribute<Vec4>(primitive, "TANGENT", positions);
    mesh.uvs = readAttribute<Vec2>(primitive, "TEXCOORD_0", positions);
    for (Vec2 &uv : mesh.uvs) uv.y = 1 - uv.y;
    mesh.storedM = readStoredM(primitive, positions);

    mesh.cornerPositions = triangleCorners(primitive, readIndices(primitive, positions));
    for (std::size_t corner = 3; corner <= mesh.cornerPositions.size(); corner += 3) mesh.faceOffsets.push_back(static_cast<Index>(corner));
    if (!mesh.normals.empty()) mesh.cornerNormals = mesh.cornerPositions;
    if (!mesh.tangents.empty()) mesh.cornerTangents = mesh.cornerPositions;
    if (!mesh.uvs.empty()) mesh.cornerUvs = mesh.cornerPositions;
    mesh.morphs = readMorphs(primitive, targetNames, positions);
    mesh.skin = readSkinWeights(primitive, positions);
    dropDegenerateFaces(mesh, primitive.gltf.place(), primitive.warnings);
    normaliseNormals(mesh);
    return mesh;
}

/// The primitive's mesh in file.meshes; kNone where it has no triangles.
Index addPrimitive(const Primitive &primitive, const std::vector<std::string> &targetNames, GltfFile &file) {
    if (primitive.mode > kFan) primitive.gltf["mode"].fail(std::to_string(primitive.mode), "0 to 6");
    if (primitive.mode < kTriangles) {
        primitive.warnings.add(primitive.gltf.place() + ": points and lines (mode " + std::to_string(primitive.mode) + ") are left out");
        return kNone;
    }
    const GltfValue material = primitive.gltf["material"];
    const Index slot = material.present() ? material.index(file.materials.size(), "materials") : kNone;
    Mesh mesh = readPrimitive(primitive, targetNames);
    if (mesh.faceCount() == 0) return kNone; // dropDegenerateFaces has said so
    file.meshes.push_back(std::move(mesh));
    file.meshMaterials.push_back(slot);
    return static_cast<Index>(file.meshes.size() - 1);
}

} // namespace

std::size_t gltfMorphCount(const GltfValue &mesh) {
    return mesh["primitives"][0]["targets"].size();
}

GltfValue gltfMeshOf(const GltfSource &source, const GltfValue &node) {
    return source["meshes"][static_cast<std::size_t>(node["mesh"].integer(-1))]; // no mesh has number -1
}

void readGltfMeshes(const GltfSource &source, GltfFile &file, std::vector<std::vector<Index>> &meshOfPrimitive, Warnings &warnings) {
    const GltfValue meshes = source["meshes"];
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const GltfValue gltf = meshes[m];
        const GltfValue primitives = gltf["primitives"];
        const std::string name = gltf.nameOr("mesh", m);
        const std::size_t morphs = gltfMorphCount(gltf);
        if (const std::size_t weights = gltf["weights"].size(); weights != 0 && weights != morphs)
            gltf["weights"].fail(std::to_string(weights) + " weights", std::to_string(morphs) + ", the number of morph targets");
        const std::vector<std::string> targetNames = morphNames(gltf, morphs);
        std::vector<Index> &indices = meshOfPrimitive.emplace_back();
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            const Primitive primitive{source, primitives[p], primitives.size() == 1 ? name : name + "." + std::to_string(p), warnings};
            const GltfValue targets = primitive.gltf["targets"];
            if (targets.size() != morphs)
                targets.fail(std::to_string(targets.size()) + " morph targets",
                             std::to_string(morphs) + " as in the mesh's first primitive");
            indices.push_back(addPrimitive(primitive, targetNames, file));
        }
    }
}

} // namespace taut
