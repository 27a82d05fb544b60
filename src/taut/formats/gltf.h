#pragma once
/// glTF 2.0 (.gltf, .glb): the file's contents as plain data, checked. What the data mean for rendering is decided by
/// `scene/`; how they move, by `deform/`.
///
/// Every accessor, index and range is checked before it is used. Each primitive of mode TRIANGLES / TRIANGLE_STRIP /
/// TRIANGLE_FAN becomes a Mesh of its own (other modes are left out with a warning). Sparse accessors and normalised integers
/// are resolved. glTF's v axis points down: uvs are stored v up.

#include "taut/base/error.h"
#include "taut/deform/rig.h"
#include "taut/mesh/mesh.h"

#include <array>
#include <string>
#include <vector>

namespace taut {

/// A reference to a texture of a glTF material.
struct GltfTextureRef {
    Index image = kNone;
    int texCoord = 0;
    bool repeatU = true;
    bool repeatV = true;
};

/// An image: bytes of a PNG or JPEG file held in memory (buffer view, data URI) or a path beside the .gltf.
struct GltfImage {
    std::string name;
    std::string path; ///< empty where `bytes` holds the file
    std::vector<unsigned char> bytes;
};

struct GltfMaterial {
    std::string name;
    Vec4 baseColor{1};
    GltfTextureRef baseColorTexture;
    float metallic = 1;
    float roughness = 1;                     ///< glTF's roughness: alpha = roughness^2
    GltfTextureRef metallicRoughnessTexture; ///< G = roughness, B = metallic
    Vec3 emissive{0};                        ///< with KHR_materials_emissive_strength applied
    GltfTextureRef emissiveTexture;
    float anisotropyStrength = 0;     ///< KHR_materials_anisotropy
    float anisotropyRotation = 0;     ///< radians, counter-clockwise from the tangent
    GltfTextureRef anisotropyTexture; ///< RG = direction, B = strength
    float ior = 1.5F;                 ///< KHR_materials_ior
    float transmission = 0;           ///< KHR_materials_transmission
    bool doubleSided = false;
};

struct GltfCamera {
    std::string name;
    bool perspective = true;
    float yFov = 0.8F; ///< radians
};

/// KHR_lights_punctual. Shines along the node's -z.
struct GltfLight {
    std::string type = "point"; ///< or "directional", "spot"
    std::string name;
    Vec3 color{1};
    float intensity = 1; ///< candela (point, spot) or lux (directional)
    float innerConeAngle = 0;
    float outerConeAngle = 0.785398F;
};

/// What hangs from a node beside its skin.
struct GltfNode {
    std::vector<Index> meshes; ///< primitives of the node's mesh, into GltfFile::meshes
    Index camera = kNone;
    Index light = kNone;
};

struct GltfFile {
    std::string path;
    Rig rig;                          ///< nodes, skins and animations
    std::vector<GltfNode> attached;   ///< [rig.nodes]
    std::vector<Index> sceneNodes;    ///< nodes of the default scene (all descendants included), in the order of the nodes
    std::vector<Mesh> meshes;         ///< one a primitive; corner attribute indices equal the position index (a zero normal: kNone)
    std::vector<Index> meshMaterials; ///< [meshes], into materials; kNone: default material
    std::vector<GltfMaterial> materials;
    std::vector<GltfImage> images;
    std::vector<GltfCamera> cameras;
    std::vector<GltfLight> lights;
};

/// Reads a .gltf or .glb. Throws InputError naming the file and the JSON path (`meshes[0].primitives[1]...`) or the byte
/// offset where it is malformed. Extensions that are required but unknown are errors; used but ignored ones are warnings.
GltfFile readGltf(const std::string &path, Warnings &warnings);

bool isGltfPath(const std::string &path);

} // namespace taut
