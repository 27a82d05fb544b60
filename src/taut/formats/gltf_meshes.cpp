/// glTF 2.0, section 3.7: primitives become meshes, vertex attributes corner attributes, joint sets skin weights.

#include "taut/formats/gltf_accessors.h"
#include "taut/formats/gltf_source.h"
#include "taut/formats/read_formats.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace taut {

namespace {

/// One primitive while it is read.
struct Primitive {
    const GltfSource &source;
    const tinygltf::Primitive &gltf;
    std::string where; ///< meshes[m].primitives[p]
    std::string name;
    Warnings &warnings;

    [[nodiscard]] bool has(const std::string &attribute) const { return gltf.attributes.count(attribute) != 0; }
    [[nodiscard]] std::string attributePath(const std::string &attribute) const { return where + ".attributes." + attribute; }
};

template <class V> std::vector<V> toVectors(const std::vector<float> &values) {
    std::vector<V> vectors(values.size() / static_cast<std::size_t>(V::length()));
    for (std::size_t i = 0; i < vectors.size(); ++i)
        for (int c = 0; c < V::length(); ++c)
            vectors[i][c] = values[i * static_cast<std::size_t>(V::length()) + static_cast<std::size_t>(c)];
    return vectors;
}

void checkVertexCount(const Primitive &primitive, const std::string &where, std::size_t found, std::size_t positions) {
    if (found != positions)
        failGltf(primitive.source.path, where, std::to_string(found) + " elements", std::to_string(positions) + ", the count of POSITION");
}

/// An optional vertex attribute; empty where the primitive lacks it.
template <class V> std::vector<V> readAttribute(const Primitive &primitive, const std::string &attribute, std::size_t positions) {
    if (!primitive.has(attribute)) return {};
    const std::string where = primitive.attributePath(attribute);
    std::vector<V> values = toVectors<V>(accessorFloats(primitive.source, primitive.gltf.attributes.at(attribute), V::length(), where));
    checkVertexCount(primitive, where, values.size(), positions);
    return values;
}

std::vector<Index> readIndices(const Primitive &primitive, std::size_t positions) {
    std::vector<Index> indices;
    if (primitive.gltf.indices < 0) {
        indices.resize(positions);
        for (std::size_t i = 0; i < positions; ++i) indices[i] = static_cast<Index>(i);
        return indices;
    }
    indices = accessorIndices(primitive.source, primitive.gltf.indices, 1, primitive.where + ".indices");
    for (std::size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= positions)
            failGltf(primitive.source.path, primitive.where + ".indices",
                     "vertex index " + std::to_string(indices[i]) + " at place " + std::to_string(i),
                     "0 to " + std::to_string(positions - 1));
    return indices;
}

/// Corners of the triangles of a list, strip or fan; glTF 2.0, section 3.7.2.1 gives the order.
std::vector<Index> triangleCorners(const Primitive &primitive, const std::vector<Index> &indices) {
    const int mode = primitive.gltf.mode;
    const bool isList = mode == TINYGLTF_MODE_TRIANGLES;
    if (indices.size() < 3 || (isList && indices.size() % 3 != 0))
        failGltf(primitive.source.path, primitive.where,
                 std::to_string(indices.size()) + (primitive.gltf.indices < 0 ? " vertices" : " indices"),
                 isList ? "a multiple of three, at least three" : "at least three");
    if (isList) return indices;
    std::vector<Index> corners;
    corners.reserve((indices.size() - 2) * 3);
    for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
        const bool isStrip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
        const std::array<std::size_t, 3> strip{i, i + 1 + i % 2, i + 2 - i % 2};
        const std::array<std::size_t, 3> fan{i + 1, i + 2, 0};
        for (const std::size_t place : isStrip ? strip : fan) corners.push_back(indices[place]);
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
        const std::string joints = "JOINTS_" + number;
        const std::string weights = "WEIGHTS_" + number;
        if (!primitive.has(joints) && !primitive.has(weights)) return sets;
        for (const std::string &needed : {joints, weights})
            if (!primitive.has(needed))
                failGltf(primitive.source.path, primitive.where + ".attributes", "no " + needed, "JOINTS_n and WEIGHTS_n in pairs");
        InfluenceSet set;
        set.joints = accessorIndices(primitive.source, primitive.gltf.attributes.at(joints), 4, primitive.attributePath(joints));
        set.weights = accessorFloats(primitive.source, primitive.gltf.attributes.at(weights), 4, primitive.attributePath(weights));
        checkVertexCount(primitive, primitive.attributePath(joints), set.joints.size() / 4, positions);
        checkVertexCount(primitive, primitive.attributePath(weights), set.weights.size() / 4, positions);
        for (std::size_t i = 0; i < set.weights.size(); ++i)
            if (set.weights[i] < 0)
                failGltf(primitive.source.path, primitive.attributePath(weights),
                         "weight " + std::to_string(set.weights[i]) + " in element " + std::to_string(i / 4), "weights from 0 to 1");
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
    const std::string prefix = primitive.source.path + ": " + primitive.where + " (" + taut::quoted(primitive.name) + "): ";
    const std::string of = " of " + std::to_string(positions) + " vertices";
    if (unweighted != 0) primitive.warnings.add(prefix + std::to_string(unweighted) + of + " have no skin weight and follow no joint");
    if (rescaled != 0)
        primitive.warnings.add(prefix + "the skin weights of " + std::to_string(rescaled) + of + " did not sum to 1 and were rescaled");
    return skin;
}

// --- morph targets ---------------------------------------------------------------------------------------------------

std::vector<std::string> morphNames(const GltfSource &source, std::size_t mesh, std::size_t count) {
    std::vector<std::string> names(count);
    const nlohmann::json &gltf = source.json["meshes"][mesh];
    const nlohmann::json extras = gltf.value("extras", nlohmann::json::object());
    const nlohmann::json listed = extras.is_object() ? extras.value("targetNames", nlohmann::json()) : nlohmann::json();
    for (std::size_t t = 0; t < count; ++t) {
        const bool named = listed.is_array() && t < listed.size() && listed[t].is_string();
        names[t] = nameOr(named ? listed[t].get<std::string>() : std::string(), "morph", t);
    }
    return names;
}

std::vector<MorphTarget> readMorphs(const Primitive &primitive, const std::vector<std::string> &names, std::size_t positions) {
    std::vector<MorphTarget> morphs;
    for (std::size_t t = 0; t < primitive.gltf.targets.size(); ++t) {
        MorphTarget morph;
        morph.name = names[t];
        const auto position = primitive.gltf.targets[t].find("POSITION");
        const std::string where = jsonPath(primitive.where + ".targets", t) + ".POSITION";
        if (position == primitive.gltf.targets[t].end())
            morph.positionDeltas.assign(positions, Vec3(0));
        else
            morph.positionDeltas = toVectors<Vec3>(accessorFloats(primitive.source, position->second, 3, where));
        checkVertexCount(primitive, where, morph.positionDeltas.size(), positions);
        morphs.push_back(std::move(morph));
    }
    return morphs;
}

// --- primitives ------------------------------------------------------------------------------------------------------

/// M at every vertex, of a file that `taut export` wrote; empty where there is none, or no frame for it.
std::vector<Vec3> readStoredM(const Primitive &primitive, std::size_t positions) {
    std::vector<Vec3> m = readAttribute<Vec3>(primitive, "_TAUT_M", positions);
    const std::string where = primitive.attributePath("_TAUT_M");
    for (std::size_t v = 0; v < m.size(); ++v)
        if (!(m[v].x > 0 && m[v].z > 0))
            failGltf(primitive.source.path, where,
                     std::to_string(m[v].x) + " and " + std::to_string(m[v].z) + " on the diagonal in element " + std::to_string(v),
                     "numbers above 0");
    if (!m.empty() && !(primitive.has("NORMAL") && primitive.has("TANGENT"))) {
        primitive.warnings.add(primitive.source.path + ": " + where + " is left out: it needs NORMAL and TANGENT");
        return {};
    }
    const std::vector<Vec2> lean = m.empty() ? std::vector<Vec2>() : readAttribute<Vec2>(primitive, "_TAUT_LEAN", positions);
    if (std::any_of(lean.begin(), lean.end(), [](const Vec2 &l) { return l != Vec2(0); }))
        primitive.warnings.add(primitive.source.path + ": " + primitive.attributePath("_TAUT_LEAN") + ": a stored M is taken as upright");
    return m;
}

Mesh readPrimitive(const Primitive &primitive, const std::vector<std::string> &targetNames) {
    const GltfSource &source = primitive.source;
    Mesh mesh;
    mesh.name = primitive.name;
    if (!primitive.has("POSITION")) failGltf(source.path, primitive.where + ".attributes", "no POSITION", "'POSITION'");
    mesh.positions =
        toVectors<Vec3>(accessorFloats(source, primitive.gltf.attributes.at("POSITION"), 3, primitive.attributePath("POSITION")));
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
    dropDegenerateFaces(mesh, source.path + ": " + primitive.where, primitive.warnings);
    normaliseNormals(mesh);
    return mesh;
}

/// The primitive's mesh in file.meshes; kNone where it has no triangles.
Index addPrimitive(const Primitive &primitive, const std::vector<std::string> &targetNames, GltfFile &file) {
    const int mode = primitive.gltf.mode;
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN) failGltf(primitive.source.path, primitive.where + ".mode", std::to_string(mode), "0 to 6");
    if (mode < TINYGLTF_MODE_TRIANGLES) {
        primitive.warnings.add(primitive.source.path + ": " + primitive.where + ": points and lines (mode " + std::to_string(mode) +
                               ") are left out");
        return kNone;
    }
    const Index material = primitive.gltf.material < 0 ? kNone
                                                       : checkedIndex(primitive.source, primitive.where + ".material",
                                                                      primitive.gltf.material, file.materials.size(), "materials");
    Mesh mesh = readPrimitive(primitive, targetNames);
    if (mesh.faceCount() == 0) return kNone; // dropDegenerateFaces has said so
    file.meshes.push_back(std::move(mesh));
    file.meshMaterials.push_back(material);
    return static_cast<Index>(file.meshes.size() - 1);
}

} // namespace

std::size_t gltfMorphCount(const GltfSource &source, int mesh) {
    if (mesh < 0) return 0;
    const auto &primitives = source.model.meshes[static_cast<std::size_t>(mesh)].primitives;
    return primitives.empty() ? 0 : primitives.front().targets.size();
}

void readGltfMeshes(const GltfSource &source, GltfFile &file, std::vector<std::vector<Index>> &meshOfPrimitive, Warnings &warnings) {
    for (std::size_t m = 0; m < source.model.meshes.size(); ++m) {
        const tinygltf::Mesh &gltf = source.model.meshes[m];
        const std::string where = jsonPath("meshes", m);
        const std::string name = nameOr(gltf.name, "mesh", m);
        const std::size_t morphs = gltfMorphCount(source, static_cast<int>(m));
        if (!gltf.weights.empty() && gltf.weights.size() != morphs)
            failGltf(source.path, where + ".weights", std::to_string(gltf.weights.size()) + " weights",
                     std::to_string(morphs) + ", the number of morph targets");
        const std::vector<std::string> targetNames = morphNames(source, m, morphs);
        std::vector<Index> &indices = meshOfPrimitive.emplace_back();
        for (std::size_t p = 0; p < gltf.primitives.size(); ++p) {
            const Primitive primitive{source, gltf.primitives[p], jsonPath(where + ".primitives", p),
                                      gltf.primitives.size() == 1 ? name : name + "." + std::to_string(p), warnings};
            if (primitive.gltf.targets.size() != morphs)
                failGltf(source.path, primitive.where + ".targets", std::to_string(primitive.gltf.targets.size()) + " morph targets",
                         std::to_string(morphs) + " as in the mesh's first primitive");
            indices.push_back(addPrimitive(primitive, targetNames, file));
        }
    }
}

} // namespace taut
