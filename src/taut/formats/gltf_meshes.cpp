/// glTF 2.0, section 3.7: the primitives of a glTF mesh become one mesh with a material slot for each material.

#include "taut/formats/gltf_primitive.h"
#include "taut/formats/read_formats.h"

#include <algorithm>
#include <map>
#include <utility>

namespace taut {

namespace {

std::vector<std::string> morphNames(const GltfValue &mesh, std::size_t count) {
    std::vector<std::string> names(count);
    const GltfValue listed = mesh["extras"]["targetNames"];
    for (std::size_t t = 0; t < count; ++t) {
        const std::string name = listed[t].text();
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

/// Numbers below `limit`, increasing, each once.
std::vector<Index> sortedOnce(std::vector<Index> numbers, std::size_t limit) {
    if (numbers.size() < limit / 8) { // a small part: in time of its own size
        std::sort(numbers.begin(), numbers.end());
        numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
        return numbers;
    }
    std::vector<char> isThere(limit, 0);
    for (const Index number : numbers) isThere[number] = 1;
    numbers.clear();
    for (std::size_t number = 0; number < limit; ++number)
        if (isThere[number] != 0) numbers.push_back(static_cast<Index>(number));
    return numbers;
}

/// Puts primitives together. Those over the same attributes share their vertices, of which those that triangles use are read, once:
/// files share one pool of vertices among meshes that use a few of them each.
class MeshJoiner {
  public:
    explicit MeshJoiner(Mesh &mesh) : mesh_(mesh) {}

    void add(const GltfPrimitive &primitive, const std::vector<std::string> &targetNames, Index slot) {
        const std::string key = primitive.attributes.dump() + primitive.gltf["targets"].dump();
        const auto [found, isNew] = groupOf_.try_emplace(key, groups_.size());
        if (isNew) {
            checkVertices(primitive, targetNames);
            groups_.push_back({primitive, {}});
        }
        Part part{found->second, slot, readGltfTriangles(primitive)};
        std::vector<Index> &wanted = groups_[part.group].wanted;
        wanted.insert(wanted.end(), part.corners.begin(), part.corners.end());
        parts_.push_back(std::move(part));
    }

    /// Whether a primitive had no normals of its own.
    [[nodiscard]] bool lacksNormals() const { return lacksNormals_; }

    void finish(const std::string &place, const std::vector<std::string> &targetNames, std::size_t slots, Warnings &warnings) {
        for (Group &group : groups_) {
            group.wanted = sortedOnce(std::move(group.wanted), gltfVertexCount(group.primitive));
            append(group, readGltfVertices(group.primitive, group.wanted, targetNames));
        }
        for (const Part &part : parts_) appendTriangles(part);
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
        GltfPrimitive primitive;   ///< the first that has it
        std::vector<Index> wanted; ///< its vertices that triangles use
        Index first = 0;           ///< in the mesh
        bool hasNormals = false, hasTangents = false, hasStoredM = false;
    };
    /// The triangles of one primitive.
    struct Part {
        std::size_t group;
        Index slot;
        std::vector<Index> corners; ///< vertices of the primitive
    };

    /// Fails on vertices that can't be read, before indices into them are looked at.
    static void checkVertices(const GltfPrimitive &primitive, const std::vector<std::string> &targetNames) {
        Warnings later;
        Tally counted;
        readGltfVertices({primitive.source, primitive.gltf, primitive.name, later, counted}, {}, targetNames);
    }

    void append(Group &group, Mesh &&part) {
        const std::size_t before = mesh_.positions.size();
        const std::size_t count = part.positions.size();
        group.first = static_cast<Index>(before);
        group.hasNormals = !part.normals.empty();
        group.hasTangents = !part.tangents.empty();
        group.hasStoredM = !part.storedM.empty();
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
    }

    void appendTriangles(const Part &part) {
        const Group &group = groups_[part.group];
        const std::vector<Index> &wanted = group.wanted;
        const bool all = wanted.size() == wanted.back() + std::size_t{1};
        for (const Index corner : part.corners) {
            const auto place = all ? corner : static_cast<Index>(std::lower_bound(wanted.begin(), wanted.end(), corner) - wanted.begin());
            const Index vertex = group.first + place;
            mesh_.cornerPositions.push_back(vertex);
            normals_.push_back(group.hasNormals ? vertex : kNone);
            tangents_.push_back(group.hasTangents ? vertex : kNone);
        }
        lacksNormals_ |= !group.hasNormals;
        lacksStoredM_ |= !group.hasStoredM;
        while (mesh_.faceOffsets.back() < mesh_.cornerPositions.size()) {
            mesh_.faceOffsets.push_back(mesh_.faceOffsets.back() + 3);
            mesh_.faceMaterials.push_back(part.slot);
        }
    }

    static void appendMorph(MorphTarget &morph, MorphTarget &&part, std::size_t before, std::size_t count) {
        appendValues(morph.positionDeltas, std::move(part.positionDeltas), before, count, Vec3(0));
        appendValues(morph.normalDeltas, std::move(part.normalDeltas), before, count, Vec3(0));
    }

    /// Those of faces that were dropped.
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
    std::vector<Group> groups_;
    std::map<std::string, std::size_t> groupOf_; // by attributes and targets
    std::vector<Part> parts_;
    std::vector<Index> normals_, tangents_; // [corners]
    bool lacksNormals_ = false;
    bool lacksStoredM_ = false;
};

/// The material of a primitive, and under each variant (KHR_materials_variants).
GltfSlot slotOf(const GltfValue &primitive, const GltfFile &file, Budget &budget) {
    GltfSlot slot;
    const auto materialOf = [&](const GltfValue &reference) {
        return reference.present() ? reference.index(file.materials.size(), "materials") : kNone;
    };
    slot.material = materialOf(primitive["material"]);
    const GltfValue mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
    for (std::size_t m = 0; m < mappings.size(); ++m) {
        const GltfValue variants = mappings[m]["variants"];
        for (std::size_t v = 0; v < variants.size(); ++v) {
            if (slot.variants.empty())
                budget.take(static_cast<double>(sizeof(Index) * file.variants.size()), primitive.place(), "materials of its variants");
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
    source.budget.take(static_cast<double>(sizeof(std::string) * morphs), gltf.place(), "names of its morph targets");
    const std::vector<std::string> targetNames = morphNames(gltf, morphs);
    Mesh mesh;
    mesh.name = name;
    MeshJoiner joiner(mesh);
    std::vector<GltfSlot> slots;
    std::map<std::pair<Index, std::vector<Index>>, Index> numbers; // of slots
    for (std::size_t p = 0; p < primitives.size(); ++p) {
        const GltfPrimitive primitive{source, primitives[p], name, warnings, file.leftOut};
        if (const GltfValue targets = primitive.gltf["targets"]; targets.size() != morphs)
            targets.fail(std::to_string(targets.size()) + " morph targets", std::to_string(morphs) + " as in the mesh's first primitive");
        const GltfSlot slot = slotOf(primitive.gltf, file, source.budget);
        if (!hasTriangles(primitive)) continue;
        const auto [known, isNew] = numbers.try_emplace({slot.material, slot.variants}, static_cast<Index>(slots.size()));
        if (isNew) slots.push_back(slot);
        joiner.add(primitive, targetNames, known->second);
    }
    if (slots.empty()) return kNone;
    joiner.finish(primitives.size() == 1 ? primitives[0].place() : gltf.place(), targetNames, slots.size(), warnings);
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
