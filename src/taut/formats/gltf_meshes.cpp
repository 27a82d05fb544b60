/// glTF 2.0, section 3.7: the primitives of a glTF mesh become one mesh with a material slot for each material.

#include "taut/formats/gltf_primitive.h"
#include "taut/formats/read_formats.h"

#include <algorithm>
#include <map>

namespace taut {

namespace {

std::vector<std::string> morphNames(const GltfValue &mesh, std::size_t count) {
    std::vector<std::string> names(count);
    const GltfValue listed = mesh["extras"]["targetNames"];
    for (std::size_t t = 0; t < count; ++t) {
        const std::string &name = listed[t].text();
        names[t] = name.empty() ? "morph" + std::to_string(t) : name;
    }
    return names;
}

/// Appends `part` to an array of a value for each vertex, of which there were `before`: those that lacked it get `nothing`, and so do
/// these where they lack it.
template <class T>
void appendValues(std::vector<T> &whole, std::vector<T> &&part, std::size_t before, std::size_t count, const T &nothing) {
    if (whole.empty() && part.empty()) return;
    whole.resize(before, nothing);
    if (before == 0)
        whole = std::move(part);
    else
        whole.insert(whole.end(), part.begin(), part.end());
    whole.resize(before + count, nothing);
}

void appendSkin(SkinWeights &whole, SkinWeights &&part, std::size_t before, std::size_t count) {
    if (whole.empty() && part.empty()) return;
    if (whole.empty()) whole.offsets.assign(before + 1, 0);
    const auto influences = static_cast<Index>(whole.joints.size());
    for (std::size_t v = 1; v <= count; ++v) whole.offsets.push_back(influences + (part.empty() ? 0 : part.offsets[v]));
    whole.joints.insert(whole.joints.end(), part.joints.begin(), part.joints.end());
    whole.weights.insert(whole.weights.end(), part.weights.begin(), part.weights.end());
}

/// Puts primitives together. Those over the same attributes share their vertices, which are read once.
class MeshJoiner {
  public:
    explicit MeshJoiner(Mesh &mesh) : mesh_(mesh) {}

    void add(const GltfPrimitive &primitive, const std::vector<std::string> &targetNames, Index slot) {
        const std::string key = primitive.attributes.dump() + primitive.gltf["targets"].dump();
        auto found = groups_.find(key);
        if (found == groups_.end()) found = groups_.emplace(key, append(readGltfVertices(primitive, targetNames))).first;
        const Group &group = found->second;
        for (const Index corner : readGltfTriangles(primitive, group.count)) {
            const Index vertex = group.first + corner;
            mesh_.cornerPositions.push_back(vertex);
            normals_.push_back(group.hasNormals ? vertex : kNone);
            tangents_.push_back(group.hasTangents ? vertex : kNone);
        }
        lacksNormals_ |= !group.hasNormals;
        lacksStoredM_ |= !group.hasStoredM;
        while (mesh_.faceOffsets.back() < mesh_.cornerPositions.size()) {
            mesh_.faceOffsets.push_back(mesh_.faceOffsets.back() + 3);
            mesh_.faceMaterials.push_back(slot);
        }
    }

    /// Whether a primitive had no normals of its own.
    [[nodiscard]] bool lacksNormals() const { return lacksNormals_; }

    void finish(const std::string &place, std::size_t slots, Warnings &warnings) {
        if (!mesh_.normals.empty()) mesh_.cornerNormals = std::move(normals_);
        if (!mesh_.tangents.empty()) mesh_.cornerTangents = std::move(tangents_);
        // Every corner has UVs and a colour where any has, so that subdivision can carry them: at (0, 0), white.
        if (!mesh_.uvs.empty()) mesh_.cornerUvs = mesh_.cornerPositions;
        if (!mesh_.colors.empty()) mesh_.cornerColors = mesh_.cornerPositions;
        if (slots < 2) mesh_.faceMaterials.clear();
        if (!mesh_.storedM.empty() && lacksStoredM_) {
            warnings.add(place + ": _TAUT_M is left out: some of its primitives lack it");
            mesh_.storedM.clear();
        }
        dropDegenerateFaces(mesh_, place, warnings);
        dropUnusedVertices();
        normaliseNormals(mesh_);
        shrinkToFit(mesh_);
    }

  private:
    /// Vertices of one set of attributes.
    struct Group {
        Index first = 0;
        std::size_t count = 0;
        bool hasNormals = false, hasTangents = false, hasStoredM = false;
    };

    Group append(Mesh &&part) {
        const std::size_t before = mesh_.positions.size();
        const std::size_t count = part.positions.size();
        const Group group{static_cast<Index>(before), count, !part.normals.empty(), !part.tangents.empty(), !part.storedM.empty()};
        if (mesh_.morphs.empty() && before == 0) {
            mesh_.morphs = std::move(part.morphs);
        } else {
            for (std::size_t m = 0; m < mesh_.morphs.size(); ++m) appendMorph(mesh_.morphs[m], std::move(part.morphs[m]), before, count);
        }
        appendValues(mesh_.normals, std::move(part.normals), before, count, Vec3(0));
        appendValues(mesh_.tangents, std::move(part.tangents), before, count, Vec4(1, 0, 0, 1));
        appendValues(mesh_.uvs, std::move(part.uvs), before, count, Vec2(0));
        appendValues(mesh_.uvs1, std::move(part.uvs1), before, count, Vec2(0));
        appendValues(mesh_.colors, std::move(part.colors), before, count, Vec4(1));
        appendValues(mesh_.storedM, std::move(part.storedM), before, count, Vec3(10, 0, 10));
        appendSkin(mesh_.skin, std::move(part.skin), before, count);
        appendValues(mesh_.positions, std::move(part.positions), before, count, Vec3(0));
        return group;
    }

    static void appendMorph(MorphTarget &morph, MorphTarget &&part, std::size_t before, std::size_t count) {
        appendValues(morph.positionDeltas, std::move(part.positionDeltas), before, count, Vec3(0));
        appendValues(morph.normalDeltas, std::move(part.normalDeltas), before, count, Vec3(0));
    }

    /// Files share one pool of vertices among meshes that use a few of them each.
    void dropUnusedVertices() {
        std::vector<Index> to(mesh_.positions.size(), kNone);
        for (const Index v : mesh_.cornerPositions) to[v] = 0;
        Index kept = 0;
        for (Index &v : to)
            if (v != kNone) v = kept++;
        if (kept == to.size()) return;
        const auto keep = [&](auto &values) {
            if (values.empty()) return;
            for (std::size_t v = 0; v < to.size(); ++v)
                if (to[v] != kNone) values[to[v]] = values[v]; // to[v] <= v
            values.resize(kept);
        };
        keep(mesh_.positions);
        keep(mesh_.normals);
        keep(mesh_.tangents);
        keep(mesh_.uvs);
        keep(mesh_.uvs1);
        keep(mesh_.colors);
        keep(mesh_.storedM);
        for (MorphTarget &morph : mesh_.morphs) {
            keep(morph.positionDeltas);
            keep(morph.normalDeltas);
        }
        keepSkinRows(to);
        for (std::vector<Index> *corners :
             {&mesh_.cornerPositions, &mesh_.cornerNormals, &mesh_.cornerTangents, &mesh_.cornerUvs, &mesh_.cornerColors})
            for (Index &corner : *corners)
                if (corner != kNone) corner = to[corner];
    }

    void keepSkinRows(const std::vector<Index> &to) {
        SkinWeights &skin = mesh_.skin;
        if (skin.empty()) return;
        SkinWeights kept;
        kept.offsets.push_back(0);
        for (std::size_t v = 0; v < to.size(); ++v) {
            if (to[v] == kNone) continue;
            kept.joints.insert(kept.joints.end(), skin.joints.begin() + skin.offsets[v], skin.joints.begin() + skin.offsets[v + 1]);
            kept.weights.insert(kept.weights.end(), skin.weights.begin() + skin.offsets[v], skin.weights.begin() + skin.offsets[v + 1]);
            kept.offsets.push_back(static_cast<Index>(kept.joints.size()));
        }
        skin = std::move(kept);
    }

    Mesh &mesh_;
    std::map<std::string, Group> groups_;
    std::vector<Index> normals_, tangents_; // [corners]
    bool lacksNormals_ = false;
    bool lacksStoredM_ = false;
};

/// The material of a primitive, and under each variant (KHR_materials_variants).
GltfSlot slotOf(const GltfValue &primitive, const GltfFile &file) {
    GltfSlot slot;
    const auto materialOf = [&](const GltfValue &reference) {
        return reference.present() ? reference.index(file.materials.size(), "materials") : kNone;
    };
    slot.material = materialOf(primitive["material"]);
    const GltfValue mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
    for (std::size_t m = 0; m < mappings.size(); ++m) {
        const GltfValue variants = mappings[m]["variants"];
        for (std::size_t v = 0; v < variants.size(); ++v) {
            slot.variants.resize(file.variants.size(), slot.material);
            slot.variants[variants[v].index(file.variants.size(), "variants")] = materialOf(mappings[m]["material"]);
        }
    }
    return slot;
}

/// Whether a primitive makes triangles; counts those of points and lines.
bool hasTriangles(const GltfPrimitive &primitive) {
    if (primitive.mode > kGltfFan) primitive.gltf["mode"].fail(std::to_string(primitive.mode), "0 to 6");
    if (primitive.mode >= kGltfTriangles) return true;
    primitive.leftOut.add(primitive.mode == 0 ? "primitive of points" : "primitive of lines");
    return false;
}

/// The mesh in file.meshes; kNone where it has no triangles.
Index readMesh(const GltfSource &source, const GltfValue &gltf, const std::string &name, GltfFile &file, Warnings &warnings) {
    const GltfValue primitives = gltf["primitives"];
    const std::size_t morphs = gltfMorphCount(gltf);
    const std::vector<std::string> targetNames = morphNames(gltf, morphs);
    Mesh mesh;
    mesh.name = name;
    MeshJoiner joiner(mesh);
    std::vector<GltfSlot> slots;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
        const GltfPrimitive primitive{source, primitives[p], name, warnings, file.leftOut};
        if (const GltfValue targets = primitive.gltf["targets"]; targets.size() != morphs)
            targets.fail(std::to_string(targets.size()) + " morph targets", std::to_string(morphs) + " as in the mesh's first primitive");
        const GltfSlot slot = slotOf(primitive.gltf, file);
        if (!hasTriangles(primitive)) continue;
        const auto known = std::find(slots.begin(), slots.end(), slot);
        const auto number = static_cast<Index>(known - slots.begin());
        if (known == slots.end()) slots.push_back(slot);
        joiner.add(primitive, targetNames, number);
    }
    if (slots.empty()) return kNone;
    joiner.finish(primitives.size() == 1 ? primitives[0].place() : gltf.place(), slots.size(), warnings);
    if (mesh.faceCount() == 0) return kNone; // dropDegenerateFaces has said so
    if (slots.size() > 1)
        for (const GltfSlot &slot : slots) mesh.materialNames.push_back(slot.material == kNone ? "" : file.materials[slot.material].name);
    file.meshes.push_back(std::move(mesh));
    file.slots.push_back(std::move(slots));
    file.flat.push_back(joiner.lacksNormals() ? 1 : 0);
    return static_cast<Index>(file.meshes.size() - 1);
}

} // namespace

std::size_t gltfMorphCount(const GltfValue &mesh) {
    return mesh["primitives"][0]["targets"].size();
}

GltfValue gltfMeshOf(const GltfSource &source, const GltfValue &node) {
    return source["meshes"][static_cast<std::size_t>(node["mesh"].integer(-1))]; // no mesh has number -1
}

void readGltfMeshes(const GltfSource &source, GltfFile &file, std::vector<Index> &meshOf, Warnings &warnings) {
    const GltfValue meshes = source["meshes"];
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const std::size_t morphs = gltfMorphCount(meshes[m]);
        if (const std::size_t weights = meshes[m]["weights"].size(); weights != 0 && weights != morphs)
            meshes[m]["weights"].fail(std::to_string(weights) + " weights", std::to_string(morphs) + ", the number of morph targets");
        meshOf.push_back(readMesh(source, meshes[m], meshes[m].nameOr("mesh", m), file, warnings));
    }
}

} // namespace taut
