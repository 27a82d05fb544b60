/// glTF 2.0, sections 3.5 and 3.7.3: the node hierarchy, the default scene, skins.

#include "taut/formats/gltf_accessors.h"

#include <algorithm>

namespace taut {

namespace {

/// The parent of each of glTF's nodes. Throws where a node has two.
std::vector<Index> findParents(const GltfValue &nodes) {
    std::vector<Index> parents(nodes.size(), kNone);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const GltfValue children = nodes[n]["children"];
        for (std::size_t c = 0; c < children.size(); ++c) {
            const Index child = children[c].index(nodes.size(), "nodes");
            if (parents[child] != kNone)
                children[c].fail("node " + std::to_string(child) + ", which is already a child of node " + std::to_string(parents[child]),
                                 "a node without a parent");
            parents[child] = static_cast<Index>(n);
        }
    }
    return parents;
}

/// glTF's nodes with parents before children. Every node has at most one parent, so what no root reaches is a cycle.
std::vector<Index> sortNodes(const GltfValue &nodes, const std::vector<Index> &parents) {
    std::vector<Index> order;
    for (std::size_t n = 0; n < parents.size(); ++n)
        if (parents[n] == kNone) order.push_back(static_cast<Index>(n));
    for (std::size_t next = 0; next < order.size(); ++next) {
        const GltfValue children = nodes[order[next]]["children"];
        for (std::size_t c = 0; c < children.size(); ++c) order.push_back(static_cast<Index>(children[c].integer(0)));
    }
    if (order.size() == parents.size()) return order;
    std::vector<char> reached(parents.size(), 0);
    for (const Index n : order) reached[n] = 1;
    const auto lost = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), 0) - reached.begin());
    nodes[lost].fail("a node that is its own ancestor", "a hierarchy without cycles");
}

/// A member of `size` numbers, or none (absent or an empty array).
std::vector<double> numbersOf(const GltfValue &member, std::size_t size) {
    std::vector<double> values = member.numbers();
    if (!values.empty() && values.size() != size)
        member.fail("an array of " + std::to_string(values.size()) + " numbers", std::to_string(size));
    return values;
}

void readTransform(const GltfValue &gltf, Node &node) {
    if (const auto m = numbersOf(gltf["matrix"], 16); !m.empty()) {
        DMat4 matrix;
        for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
        node.matrix = matrix;
    }
    if (gltf.has("matrix")) return; // it and the others exclude each other
    if (const auto t = numbersOf(gltf["translation"], 3); !t.empty()) node.translation = {t[0], t[1], t[2]};
    if (const auto s = numbersOf(gltf["scale"], 3); !s.empty()) node.scale = {s[0], s[1], s[2]};
    const auto r = numbersOf(gltf["rotation"], 4);
    if (r.empty()) return;
    const DQuat rotation(r[3], r[0], r[1], r[2]);
    const double length = glm::length(rotation);
    if (!(length > 1e-6)) gltf["rotation"].fail("a quaternion of length " + std::to_string(length), "a unit quaternion");
    node.rotation = rotation / length;
}

void readMorphWeights(const GltfSource &source, const GltfValue &gltf, Node &node) {
    const GltfValue mesh = gltfMeshOf(source, gltf);
    const std::size_t morphs = gltfMorphCount(mesh);
    const std::vector<double> own = gltf["weights"].numbers();
    if (!own.empty() && own.size() != morphs)
        gltf["weights"].fail(std::to_string(own.size()) + " weights", std::to_string(morphs) + ", the number of its mesh's morph targets");
    for (const double weight : own.empty() ? mesh["weights"].numbers() : own) node.morphWeights.push_back(static_cast<float>(weight));
}

/// The largest joint that each mesh names; 0 where it names none.
std::vector<Index> largestJoints(const GltfFile &file) {
    std::vector<Index> largest;
    for (const Mesh &mesh : file.meshes) {
        const auto found = std::max_element(mesh.skin.joints.begin(), mesh.skin.joints.end());
        largest.push_back(found == mesh.skin.joints.end() ? 0 : *found);
    }
    return largest;
}

class NodeReader {
  public:
    NodeReader(const GltfSource &source, const GltfFile &file, const std::vector<Index> &meshOf)
        : source_(source), file_(file), meshOf_(meshOf), largestJoints_(largestJoints(file)), skins_(source["skins"]) {}

    Node read(const GltfValue &gltf, std::size_t number, GltfNode &attached) const {
        Node node;
        node.name = gltf.nameOr("node", number);
        readTransform(gltf, node);
        if (gltf.has("mesh")) attached.mesh = meshOf_[gltf["mesh"].index(meshOf_.size(), "meshes")];
        readMorphWeights(source_, gltf, node);
        if (gltf.has("camera")) attached.camera = gltf["camera"].index(file_.cameras.size(), "cameras");
        if (gltf.has("skin")) {
            node.skin = gltf["skin"].index(skins_.size(), "skins");
            checkJoints(gltf["skin"], skins_[node.skin], attached);
        }
        const GltfValue light = gltf["extensions"]["KHR_lights_punctual"]["light"];
        if (light.present()) attached.light = light.index(file_.lights.size(), "lights");
        return node;
    }

  private:
    /// Every joint that the meshes of a skinned node name must be one of the skin's.
    void checkJoints(const GltfValue &reference, const GltfValue &skin, const GltfNode &attached) const {
        const std::size_t joints = skin["joints"].size();
        const Index mesh = attached.mesh;
        if (mesh != kNone && !file_.meshes[mesh].skin.joints.empty() && largestJoints_[mesh] >= joints)
            reference.fail("joint " + std::to_string(largestJoints_[mesh]) + " in mesh " + taut::quoted(file_.meshes[mesh].name),
                           "0 to " + std::to_string(joints - 1) + ", the joints of " + skin.path());
    }

    const GltfSource &source_;
    const GltfFile &file_;
    const std::vector<Index> &meshOf_;
    std::vector<Index> largestJoints_;
    GltfValue skins_;
};

/// What another node like it takes, with its place in a pose.
double bytesOf(const Node &node) {
    return sizeof(Node) + sizeof(GltfNode) + 2 * sizeof(DMat4) + static_cast<double>(node.name.size() + sizeof(float) * node.morphWeights.size());
}

/// EXT_mesh_gpu_instancing: the mesh of a node in several places. Each becomes a child of the node, which keeps no mesh of its own.
void addInstances(const GltfSource &source, const GltfValue &gltf, Index parent, GltfFile &file) {
    const GltfValue attributes = gltf["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    if (!attributes.present() || file.attached[parent].mesh == kNone) return;
    std::size_t count = 0;
    const auto read = [&](const char *name, int components) {
        const GltfValue reference = attributes[name];
        if (!reference.present()) return std::vector<float>{};
        std::vector<float> values = accessorFloats(source, reference, components);
        const std::size_t found = values.size() / static_cast<std::size_t>(components);
        if (count != 0 && found != count) reference.fail(std::to_string(found) + " elements", std::to_string(count) + " as in the others");
        count = found;
        return values;
    };
    const std::vector<float> translations = read("TRANSLATION", 3);
    const std::vector<float> rotations = read("ROTATION", 4);
    const std::vector<float> scales = read("SCALE", 3);
    for (const std::string &name : attributes.keys())
        if (name != "TRANSLATION" && name != "ROTATION" && name != "SCALE") file.leftOut.add("instance attribute " + name);
    if (count == 0) return;
    const Node &pattern = file.rig.nodes[parent];
    source.budget.take(static_cast<double>(count) * bytesOf(pattern), gltf.place(), std::to_string(count) + " instances");
    for (std::size_t i = 0; i < count; ++i) {
        Node node;
        node.name = file.rig.nodes[parent].name + "." + std::to_string(i);
        node.parent = parent;
        node.morphWeights = file.rig.nodes[parent].morphWeights;
        if (!translations.empty()) node.translation = {translations[3 * i], translations[3 * i + 1], translations[3 * i + 2]};
        if (!scales.empty()) node.scale = {scales[3 * i], scales[3 * i + 1], scales[3 * i + 2]};
        if (!rotations.empty()) {
            const DQuat q(rotations[4 * i + 3], rotations[4 * i], rotations[4 * i + 1], rotations[4 * i + 2]);
            if (const double length = glm::length(q); length > 1e-6) node.rotation = q / length;
        }
        file.rig.nodes.push_back(std::move(node));
        file.attached.push_back({file.attached[parent].mesh, kNone, kNone});
    }
    file.attached[parent].mesh = kNone;
}

/// Marks the roots of the default scene, then what hangs from them; without scenes, everything.
void readScene(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf) {
    const GltfValue scenes = source["scenes"];
    std::vector<char> shown(file.rig.nodes.size(), scenes.size() == 0 ? 1 : 0);
    if (scenes.size() != 0) {
        const GltfValue scene = source["scene"];
        const GltfValue roots = scenes[scene.present() ? scene.index(scenes.size(), "scenes") : 0]["nodes"];
        for (std::size_t i = 0; i < roots.size(); ++i) shown[nodeOf[roots[i].index(nodeOf.size(), "nodes")]] = 1;
    }
    for (std::size_t n = 0; n < file.rig.nodes.size(); ++n) {
        if (file.rig.nodes[n].parent != kNone && shown[file.rig.nodes[n].parent] != 0) shown[n] = 1;
        if (shown[n] != 0) file.sceneNodes.push_back(static_cast<Index>(n));
    }
}

} // namespace

void readGltfNodes(const GltfSource &source, GltfFile &file, const std::vector<Index> &meshOf, std::vector<Index> &nodeOf) {
    const GltfValue nodes = source["nodes"];
    const std::vector<Index> parents = findParents(nodes);
    const std::vector<Index> order = sortNodes(nodes, parents);
    nodeOf.assign(order.size(), kNone);
    for (std::size_t i = 0; i < order.size(); ++i) nodeOf[order[i]] = static_cast<Index>(i);
    const NodeReader reader(source, file, meshOf);
    for (const Index n : order) {
        file.attached.emplace_back();
        file.rig.nodes.push_back(reader.read(nodes[n], n, file.attached.back()));
        source.budget.take(bytesOf(file.rig.nodes.back()), nodes[n].place(), "a node");
        if (parents[n] != kNone) file.rig.nodes.back().parent = nodeOf[parents[n]];
    }
    for (const Index n : order) addInstances(source, nodes[n], nodeOf[n], file);
    readScene(source, file, nodeOf);
}

void readGltfSkins(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf) {
    const GltfValue skins = source["skins"];
    for (std::size_t s = 0; s < skins.size(); ++s) {
        const GltfValue gltf = skins[s];
        const GltfValue joints = gltf["joints"];
        Skin skin;
        skin.name = gltf.nameOr("skin", s);
        if (joints.size() == 0) joints.fail("no joint", "at least one");
        for (std::size_t j = 0; j < joints.size(); ++j) skin.joints.push_back(nodeOf[joints[j].index(nodeOf.size(), "nodes")]);
        skin.inverseBindMatrix.assign(skin.joints.size(), DMat4(1));
        if (const GltfValue matrices = gltf["inverseBindMatrices"]; matrices.present()) {
            const std::vector<float> values = accessorFloats(source, matrices, 16);
            if (values.size() / 16 < skin.joints.size())
                matrices.fail(std::to_string(values.size() / 16) + " matrices", std::to_string(skin.joints.size()) + ", one a joint");
            for (std::size_t i = 0; i < skin.joints.size() * 16; ++i)
                skin.inverseBindMatrix[i / 16][static_cast<int>(i % 16 / 4)][static_cast<int>(i % 4)] = static_cast<double>(values[i]);
        }
        file.rig.skins.push_back(std::move(skin));
    }
}

} // namespace taut
