#pragma once
/// glTF 2.0 (.gltf, .glb): the file's contents as plain data, checked. What the data mean for rendering is decided by
/// `scene/`; how they move, by `deform/`.
///
/// Every accessor, index and range is checked before it is used. A glTF mesh becomes one Mesh; its primitives of mode TRIANGLES /
/// TRIANGLE_STRIP / TRIANGLE_FAN are material slots of it, so that the surface does not break where materials meet. Vertices that no
/// face uses are left out. Sparse accessors and normalised integers are resolved. glTF's v axis points down: uvs are stored v up.
///
/// What a file holds and nothing of this reads is counted by name (GltfFile::leftOut) and said in one line.

#include "taut/base/budget.h"
#include "taut/base/error.h"
#include "taut/deform/rig.h"
#include "taut/formats/texture_sampler.h"
#include "taut/mesh/mesh.h"

#include <array>
#include <string>
#include <vector>

namespace taut {

/// A reference to a texture of a glTF material.
struct GltfTextureRef {
    bool given = false;     ///< the material names a texture, whether or not there is an image that can be read
    Index image = kNone;    ///< the one to take where the image library reads it
    Index fallback = kNone; ///< else this one
    TextureSampler sampler; ///< with KHR_texture_transform
};

/// An image: bytes of an image file held in memory (buffer view, data URI) or a path beside the .gltf.
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
    GltfTextureRef normalTexture;
    float normalScale = 1;
    Vec3 emissive{0};                        ///< with KHR_materials_emissive_strength applied
    GltfTextureRef emissiveTexture;
    float anisotropyStrength = 0;     ///< KHR_materials_anisotropy
    float anisotropyRotation = 0;     ///< radians, counter-clockwise from the tangent
    GltfTextureRef anisotropyTexture; ///< RG = direction, B = strength
    float ior = 1.5F;                 ///< KHR_materials_ior
    bool doubleSided = false;
    std::string alphaMode = "OPAQUE"; ///< or "MASK", "BLEND"
    float alphaCutoff = 0.5F;
    bool unlit = false; ///< KHR_materials_unlit

    float transmission = 0; ///< KHR_materials_transmission
    GltfTextureRef transmissionTexture;
    float thickness = 0; ///< KHR_materials_volume: 0 is thin-walled
    float attenuationDistance = kInfinity;
    Vec3 attenuationColor{1};
    float specular = 1;             ///< KHR_materials_specular
    GltfTextureRef specularTexture; ///< A
    Vec3 specularColor{1};
    GltfTextureRef specularColorTexture;
    float clearcoat = 0;             ///< KHR_materials_clearcoat
    GltfTextureRef clearcoatTexture; ///< R
    float clearcoatRoughness = 0;
    GltfTextureRef clearcoatRoughnessTexture; ///< G
    GltfTextureRef clearcoatNormalTexture;
    float clearcoatNormalScale = 1;
    Vec3 sheenColor{0};                       ///< KHR_materials_sheen
    GltfTextureRef sheenColorTexture;
    float sheenRoughness = 0;
    GltfTextureRef sheenRoughnessTexture; ///< A
    float iridescence = 0;                ///< KHR_materials_iridescence
    GltfTextureRef iridescenceTexture;    ///< R
    float iridescenceIor = 1.3F;
    float iridescenceMin = 100; ///< nanometres
    float iridescenceMax = 400;
    GltfTextureRef iridescenceThicknessTexture; ///< G
};

struct GltfCamera {
    std::string name;
    bool perspective = true;
    float yFov = 0.8F; ///< radians
    float yMag = 1;    ///< orthographic: half the visible height
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
    Index mesh = kNone; ///< into GltfFile::meshes
    Index camera = kNone;
    Index light = kNone;
};

/// A material slot of a mesh.
struct GltfSlot {
    Index material = kNone;      ///< kNone: the default material
    std::vector<Index> variants; ///< [GltfFile::variants] the material under each (KHR_materials_variants); empty: always `material`
    bool operator==(const GltfSlot &) const = default;
};

/// Counts by name, in the order of first mention.
struct Tally {
    std::vector<std::pair<std::string, std::size_t>> counts;
    void add(const std::string &name, std::size_t count = 1);
    [[nodiscard]] std::string text() const; ///< "normalTexture (3), lines (1)"
};

struct GltfFile {
    std::string path;
    std::vector<std::string> bufferPaths;     ///< of the files beside it that it was read from
    Rig rig;                                  ///< nodes, skins and animations
    std::vector<GltfNode> attached;           ///< [rig.nodes]
    std::vector<Index> sceneNodes;            ///< nodes of the default scene (all descendants included), in the order of the nodes
    std::vector<Mesh> meshes;                 ///< corner attribute indices equal the position index, or are kNone where a corner lacks it
    std::vector<std::vector<GltfSlot>> slots; ///< [meshes][material slots of their faces]
    std::vector<unsigned char> flat;          ///< [meshes] primitives without NORMAL: faceted, as glTF 2.0, section 3.7.2.1 wants
    std::vector<std::string> variants;        ///< names, KHR_materials_variants
    std::vector<GltfMaterial> materials;
    std::vector<GltfImage> images;
    std::vector<GltfCamera> cameras;
    std::vector<GltfLight> lights;
    Tally leftOut; ///< what the file uses and the picture does not show
};

/// Reads a .gltf or .glb. Throws InputError naming the file and the JSON path (`meshes[0].primitives[1]...`) or the byte
/// offset where it is malformed. Extensions that are required but unknown are errors; what is used and not shown is one warning.
/// `budget` is asked before memory is: null: one of its own.
GltfFile readGltf(const std::string &path, Warnings &warnings, Budget *budget = nullptr);

bool isGltfPath(const std::string &path);

} // namespace taut
