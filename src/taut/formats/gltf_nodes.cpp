/// glTF 2.0, sections 3.5 and 3.7.3: the node hierarchy, the default scene, skins.

#include "taut/formats/gltf_accessors.h"
#include "taut/formats/gltf_source.h"

#include <algorithm>

namespace taut {

namespace {

/// The parent of each of glTF's nodes. Throws where a node has two.
std::vector<Index> findParents(const GltfSource &source) {
    const auto &nodes = source.model.nodes;
    std::vector<Index> parents(nodes.size(), kNone);
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (std::size_t c = 0; c < nodes[n].children.size(); ++c) {
            const std::string where = jsonPath(jsonPath("nodes", n) + ".children", c);
            const Index child = checkedIndex(source, where, nodes[n].children[c], nodes.size(), "nodes");
            if (parents[child] != kNone)
                failGltf(source.path, where,
                         "node " + std::to_string(child) + ", which is already a child of node " + std::to_string(parents[child]),
                         "a node without a parent");
            parents[child] = static_cast<Index>(n);
        }
    return parents;
}

/// glTF's nodes with parents before children. Every node has at most one parent, so what no root reaches is a cycle.
std::vector<Index> sortNodes(const GltfSource &source, const std::vector<Index> &parents) {
    std::vector<Index> order;
    for (std::size_t n = 0; n < parents.size(); ++n)
        if (parents[n] == kNone) order.push_back(static_cast<Index>(n));
    for (std::size_t next = 0; next < order.size(); ++next)
        for (const int child : source.model.nodes[order[next]].children) order.push_back(static_cast<Index>(child));
    if (order.size() == parents.size()) return order;
    std::vector<char> reached(parents.size(), 0);
    for (const Index n : order) reached[n] = 1;
    const auto lost = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), 0) - reached.begin());
    failGltf(source.path, jsonPath("nodes", lost), "a node that is its own ancestor", "a hierarchy without cycles");
}

/// A member of 0 (absent) or `size` numbers.
bool given(const GltfSource &source, const std::vector<double> &values, std::size_t size, const std::string &where) {
    if (values.empty()) return false;
    if (values.size() != size)
        failGltf(source.path, where, "an array of " + std::to_string(values.size()) + " numbers", std::to_string(size));
    return true;
}

void readTransform(const GltfSource &source, const tinygltf::Node &gltf, const std::string &where, Node &node) {
    if (given(source, gltf.matrix, 16, where + ".matrix")) {
        DMat4 matrix;
        for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = gltf.matrix[static_cast<std::size_t>(i)];
        node.matrix = matrix;
    }
    if (given(source, gltf.translation, 3, where + ".translation"))
        node.translation = {gltf.translation[0], gltf.translation[1], gltf.translation[2]};
    if (given(source, gltf.scale, 3, where + ".scale")) node.scale = {gltf.scale[0], gltf.scale[1], gltf.scale[2]};
    if (!given(source, gltf.rotation, 4, where + ".rotation")) return;
    const DQuat rotation(gltf.rotation[3], gltf.rotation[0], gltf.rotation[1], gltf.rotation[2]);
    const double length = glm::length(rotation);
    if (!(length > 1e-6))
        failGltf(source.path, where + ".rotation", "a quaternion of length " + std::to_string(length), "a unit quaternion");
    node.rotation = rotation / length;
}

void readMorphWeights(const GltfSource &source, const tinygltf::Node &gltf, const std::string &where, Node &node) {
    const std::size_t morphs = gltfMorphCount(source, gltf.mesh);
    if (!gltf.weights.empty() && gltf.weights.size() != morphs)
        failGltf(source.path, where + ".weights", std::to_string(gltf.weights.size()) + " weights",
                 std::to_string(morphs) + ", the number of its mesh's morph targets");
    const std::vector<double> none;
    const std::vector<double> &meshWeights = gltf.mesh < 0 ? none : source.model.meshes[static_cast<std::size_t>(gltf.mesh)].weights;
    const std::vector<double> &weights = gltf.weights.empty() ? meshWeights : gltf.weights;
    for (const double weight : weights) node.morphWeights.push_back(static_cast<float>(weight));
}

/// Every joint that the meshes of a skinned node name must be one of the skin's.
void checkJoints(const GltfSource &source, const GltfFile &file, Index skin, const GltfNode &attached, const std::string &where) {
    const std::size_t joints = source.model.skins[skin].joints.size();
    for (const Index mesh : attached.meshes) {
        const std::vector<Index> &used = file.meshes[mesh].skin.joints;
        const auto largest = std::max_element(used.begin(), used.end());
        if (largest != used.end() && *largest >= joints)
            failGltf(source.path, where + ".skin", "joint " + std::to_string(*largest) + " in mesh " + taut::quoted(file.meshes[mesh].name),
                     "0 to " + std::to_string(joints - 1) + ", the joints of " + jsonPath("skins", skin));
    }
}

Node readNode(const GltfSource &source, const GltfFile &file, std::size_t n, const std::vector<std::vector<Index>> &meshOfPrimitive,
              GltfNode &attached) {
    const tinygltf::Node &gltf = source.model.nodes[n];
    const std::string where = jsonPath("nodes", n);
    Node node;
    node.name = nameOr(gltf.name, "node", n);
    readTransform(source, gltf, where, node);
    if (gltf.mesh >= 0)
        for (const Index mesh : meshOfPrimitive[checkedIndex(source, where + ".mesh", gltf.mesh, meshOfPrimitive.size(), "meshes")])
            if (mesh != kNone) attached.meshes.push_back(mesh);
    readMorphWeights(source, gltf, where, node);
    if (gltf.camera >= 0) attached.camera = checkedIndex(source, where + ".camera", gltf.camera, file.cameras.size(), "cameras");
    if (gltf.skin >= 0) {
        node.skin = checkedIndex(source, where + ".skin", gltf.skin, source.model.skins.size(), "skins");
        checkJoints(source, file, node.skin, attached, where);
    }
    const auto lights = gltf.extensions.find("KHR_lights_punctual");
    if (lights != gltf.extensions.end() && lights->second.Has("light"))
        attached.light = checkedIndex(source, where + ".extensions.KHR_lights_punctual.light", lights->second.Get("light").GetNumberAsInt(),
                                      file.lights.size(), "lights");
    return node;
}

/// Marks the roots of the default scene, then what hangs from them; without scenes, everything.
void readScene(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf) {
    const auto &scenes = source.model.scenes;
    std::vector<char> shown(file.rig.nodes.size(), scenes.empty() ? 1 : 0);
    if (!scenes.empty()) {
        const Index scene = checkedIndex(source, "scene", std::max(source.model.defaultScene, 0), scenes.size(), "scenes");
        for (std::size_t i = 0; i < scenes[scene].nodes.size(); ++i)
            shown[nodeOf[checkedIndex(source, jsonPath(jsonPath("scenes", scene) + ".nodes", i), scenes[scene].nodes[i], nodeOf.size(),
                                      "nodes")]] = 1;
    }
    for (std::size_t n = 0; n < file.rig.nodes.size(); ++n) {
        if (file.rig.nodes[n].parent != kNone && shown[file.rig.nodes[n].parent] != 0) shown[n] = 1;
        if (shown[n] != 0) file.sceneNodes.push_back(static_cast<Index>(n));
    }
}

} // namespace

void readGltfNodes(const GltfSource &source, GltfFile &file, const std::vector<std::vector<Index>> &meshOfPrimitive,
                   std::vector<Index> &nodeOf) {
    const std::vector<Index> parents = findParents(source);
    const std::vector<Index> order = sortNodes(source, parents);
    nodeOf.assign(order.size(), kNone);
    for (std::size_t i = 0; i < order.size(); ++i) nodeOf[order[i]] = static_cast<Index>(i);
    for (const Index n : order) {
        file.attached.emplace_back();
        file.rig.nodes.push_back(readNode(source, file, n, meshOfPrimitive, file.attached.back()));
        if (parents[n] != kNone) file.rig.nodes.back().parent = nodeOf[parents[n]];
    }
    readScene(source, file, nodeOf);
}

void readGltfSkins(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf) {
    for (std::size_t s = 0; s < source.model.skins.size(); ++s) {
        const tinygltf::Skin &gltf = source.model.skins[s];
        const std::string where = jsonPath("skins", s);
        Skin skin;
        skin.name = nameOr(gltf.name, "skin", s);
        if (gltf.joints.empty()) failGltf(source.path, where + ".joints", "no joint", "at least one");
        for (std::size_t j = 0; j < gltf.joints.size(); ++j)
            skin.joints.push_back(nodeOf[checkedIndex(source, jsonPath(where + ".joints", j), gltf.joints[j], nodeOf.size(), "nodes")]);
        skin.inverseBindMatrix.assign(skin.joints.size(), DMat4(1));
        if (gltf.inverseBindMatrices >= 0) {
            const std::string path = where + ".inverseBindMatrices";
            const std::vector<float> values = accessorFloats(source, gltf.inverseBindMatrices, 16, path);
            if (values.size() / 16 < skin.joints.size())
                failGltf(source.path, path, std::to_string(values.size() / 16) + " matrices",
                         std::to_string(skin.joints.size()) + ", one a joint");
            for (std::size_t i = 0; i < skin.joints.size() * 16; ++i)
                skin.inverseBindMatrix[i / 16][static_cast<int>(i % 16 / 4)][static_cast<int>(i % 4)] = static_cast<double>(values[i]);
        }
        file.rig.skins.push_back(std::move(skin));
    }
}

} // namespace taut
