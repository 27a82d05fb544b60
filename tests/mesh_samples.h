#pragma once
/// Small valid files in memory, of which every number is known, for the tests of the mesh readers.

#include "assets.h"

#include "taut/base/error.h"
#include "taut/formats/gltf.h"
#include "taut/formats/read_mesh.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace taut::test {

/// A sample with one place changed, which must be there.
inline std::string replaced(std::string text, const std::string &from, const std::string &to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::logic_error("no " + from);
    return text.replace(at, from.size(), to);
}

/// Writes `bytes` to a file of this name in the output folder and returns its path.
inline std::string writeFile(const std::string &name, const std::string &bytes) {
    const std::string path = outputFolder("mesh") + "/" + name;
    std::ofstream(path, std::ios::binary | std::ios::trunc).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
}

template <class T> void append(std::string &out, T value, bool bigEndian = false) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (bigEndian) std::reverse(raw, raw + sizeof(T));
    out.append(raw, sizeof(T));
}
template <class T> void appendAll(std::string &out, std::initializer_list<T> values, bool bigEndian = false) {
    for (const T value : values) append(out, value, bigEndian);
}

/// Two quads and a triangle over six vertices; uvs and normals per corner, all index forms.
inline std::string objSample() {
    return "# a comment\n"
           "mtllib none.mtl\n"
           "o thing\n"
           "v 0 0 0\n"
           "v 1 0 0 0.5 0.5 0.5\n"
           "v 1 1 0\n"
           "v 0 1 0\n"
           "v +2.5e0 0 -1.25\n"
           "v 2 1 .5\n"
           "vt 0 0\n"
           "vt 1 0.25 0\n"
           "vt 0.5\n"
           "vn 0 0 4\n"
           "vn 0 -1 0\n"
           "g left\n"
           "usemtl brushed steel\n"
           "s 1\n"
           "f 1/1/1 2/2/1 \\\n"
           "  3/3/2 4/-3/-1\n"
           "usemtl paint\n"
           "f 2//1 5//1 6//2 3//2\n"
           "f -6 -5 -4\n";
}

/// A unit square of two triangles and a pentagon roof; normals, uvs and a property that nobody reads.
inline std::string plyHeader(const std::string &format, const std::string &floatType = "float") {
    std::string header = "ply\nformat " + format + " 1.0\ncomment made by hand\nobj_info element vertex 7\nelement vertex 5\n";
    for (const char *name : {"x", "y", "z"}) header += "property " + floatType + " " + name + "\n";
    header += "property uchar red\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n";
    return header +
           "element face 3\nproperty short flag\nproperty list uchar int vertex_indices\nproperty list uint8 float more\nend_header\n";
}
inline std::string plyAsciiSample() {
    return plyHeader("ascii") +
           "0 0 0 255 0 0 2 0 0\n1 0 0 7 0 0 1 1 0\n1 1 0 8 0 1 0 1 1\n0 1 0 9 0 0 1 0 1\n0.5 1.5 0.25 10 1 0 0 0.5 0.75\n"
           "1 3 0 1 2 0\n-2 3 0 2 3 2 0.5 0.25\n3 5 0 1 2 4 3 0\n";
}
inline std::string plyBinarySample(bool bigEndian) {
    std::string out = plyHeader(bigEndian ? "binary_big_endian" : "binary_little_endian", "double");
    const double positions[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 1.5, 0.25}};
    const float rest[5][5] = {{0, 0, 2, 0, 0}, {0, 0, 1, 1, 0}, {0, 1, 0, 1, 1}, {0, 0, 1, 0, 1}, {1, 0, 0, 0.5F, 0.75F}};
    for (int v = 0; v < 5; ++v) {
        for (const double x : positions[v]) append(out, x, bigEndian);
        append(out, std::uint8_t{200});
        for (const float x : rest[v]) append(out, x, bigEndian);
    }
    const std::vector<std::vector<std::int32_t>> faces{{0, 1, 2}, {0, 2, 3}, {0, 1, 2, 4, 3}};
    for (const auto &face : faces) {
        append(out, std::int16_t{-2}, bigEndian);
        append(out, static_cast<std::uint8_t>(face.size()));
        for (const std::int32_t index : face) append(out, index, bigEndian);
        append(out, std::uint8_t{1});
        append(out, 0.5F, bigEndian);
    }
    return out;
}

inline std::string offSample() {
    return "STNOFF # with normals and uvs\n# a comment\n5 2 0\n\n0 0 0  0 0 1  0 0\n1 0 0  0 0 1  1 0\n1 1 0  0 0 3  1 1\n0 1 0  0 0 1  0 "
           "1\n0.5 1.5 0.25 1 0 0 0.5 0.75\n"
           "4 0 1 2 3 255 0 0\n3 3 2 4\n";
}

/// A tetrahedron: four triangles, twelve corners, four positions once welded. The name holds words of the grammar.
inline const float (&stlTriangles())[4][3][3] {
    static const float triangles[4][3][3] = {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                             {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                             {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                             {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    return triangles;
}
inline std::string stlAsciiSample() {
    std::string out = "solid router facet normal\n";
    for (const auto &triangle : stlTriangles()) {
        out += "  facet normal nan 0 1\n    outer loop\n";
        for (const auto &p : triangle)
            out += "      vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
        out += "    endloop\n  endfacet\n";
    }
    return out + "endsolid router\n";
}
inline std::string stlBinarySample() {
    std::string out = "solid, says a binary file";
    out.resize(80, ' ');
    append(out, std::uint32_t{4});
    for (const auto &triangle : stlTriangles()) {
        for (int i = 0; i < 3; ++i) append(out, 0.0F);
        for (const auto &p : triangle)
            for (const float x : p) append(out, x);
        append(out, std::uint16_t{0});
    }
    return out;
}

// --- glTF ------------------------------------------------------------------------------------------------------------

/// A glTF under construction: JSON and one buffer.
struct GltfBuilder {
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
    std::string bin;

    /// A buffer view over new bytes; returns its index.
    int addView(const std::string &bytes) {
        bin.resize((bin.size() + 3) / 4 * 4, '\0');
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}});
        bin += bytes;
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }
    /// An accessor over a new buffer view; `type` such as VEC3; returns its index.
    template <class T> int add(const std::string &type, int componentType, const std::vector<T> &values, bool normalized = false) {
        std::string bytes;
        for (const T value : values) append(bytes, value);
        const std::size_t components = type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
        json["accessors"].push_back(
            {{"bufferView", addView(bytes)}, {"componentType", componentType}, {"count", values.size() / components}, {"type", type}});
        if (normalized) json["accessors"].back()["normalized"] = true;
        return static_cast<int>(json["accessors"].size()) - 1;
    }
    int addFloats(const std::string &type, const std::vector<float> &values) { return add(type, 5126, values); }

    /// The whole as a .glb.
    [[nodiscard]] std::string glb() const {
        nlohmann::json file = json;
        file["buffers"] = {{{"byteLength", bin.size()}}};
        return container(file.dump(), bin);
    }
    /// The whole as a .gltf with the buffer in a data: URI.
    [[nodiscard]] std::string gltf() const {
        nlohmann::json file = json;
        file["buffers"] = {{{"byteLength", bin.size()}, {"uri", "data:application/octet-stream;base64," + base64(bin)}}};
        return file.dump(1);
    }
    static std::string container(std::string text, std::string data) {
        text.resize((text.size() + 3) / 4 * 4, ' ');
        data.resize((data.size() + 3) / 4 * 4, '\0');
        std::string out = "glTF";
        appendAll<std::uint32_t>(out, {2, static_cast<std::uint32_t>(12 + 8 + text.size() + (data.empty() ? 0 : 8 + data.size())),
                                       static_cast<std::uint32_t>(text.size())});
        out += "JSON" + text;
        if (data.empty()) return out;
        append(out, static_cast<std::uint32_t>(data.size()));
        return out + std::string("BIN\0", 4) + data;
    }
    static std::string base64(const std::string &bytes) {
        constexpr const char *kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string out;
        for (std::size_t i = 0; i < bytes.size(); i += 3) {
            std::uint32_t word = 0;
            for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
            for (std::size_t k = 0; k < 4; ++k)
                out += k <= bytes.size() - i || bytes.size() - i >= 3 ? kDigits[word >> (18 - 6 * k) & 63] : '=';
        }
        return out;
    }
};

/// A skinned square with two morph targets, three clips' worth of channels in one clip, a camera, a light, a material.
/// The child "tip" comes before its parent "root" in the file.
inline GltfBuilder gltfSample() {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0});                        // 0
    const int normals = b.addFloats("VEC3", {0, 0, 2, 0, 0, 1, 0, 0, 1, 0, 0, 1});                          // 1
    const int uvs = b.add<std::uint16_t>("VEC2", 5123, {0, 0, 65535, 0, 65535, 65535, 0, 13107}, true);     // 2
    const int tangents = b.addFloats("VEC4", {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, 1, 1, 0, 0, 1});           // 3
    const int joints = b.add<std::uint8_t>("VEC4", 5121, {1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}); // 4
    const int weights = b.addFloats("VEC4", {1, 0, 0, 0, 0.25F, 0.75F, 0, 0, 1, 3, 0, 0, 0, 0, 0, 0});      // 5
    const int indices = b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3, 1, 1, 2});                  // 6
    const int sparseIndices = b.addView(std::string("\x02", 1));
    std::string delta;
    appendAll(delta, {0.0F, 0.5F, 1.0F});
    const int sparseValues = b.addView(delta);
    b.json["accessors"].push_back({{"componentType", 5126},
                                   {"count", 4},
                                   {"type", "VEC3"},
                                   {"sparse",
                                    {{"count", 1},
                                     {"indices", {{"bufferView", sparseIndices}, {"componentType", 5121}}},
                                     {"values", {{"bufferView", sparseValues}}}}}});
    const int morph = static_cast<int>(b.json["accessors"].size()) - 1; // 7
    std::vector<float> matrices(32, 0.0F);
    for (int i = 0; i < 4; ++i) matrices[static_cast<std::size_t>(i * 5)] = matrices[static_cast<std::size_t>(16 + i * 5)] = 1;
    matrices[16 + 13] = -2;                                // the second joint's: translation (0, -2, 0)
    const int inverseBind = b.addFloats("MAT4", matrices); // 8
    const int times = b.addFloats("SCALAR", {0, 0.5F, 2}); // 9
    const int turns = b.add<std::int16_t>("VEC4", 5122, {0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, -32768, 0}, true); // 10
    const int morphKeys = b.addFloats("SCALAR", {0, 0, 1, 0.5F, 0.25F, 0.125F});                                  // 11
    const int cubicTimes = b.addFloats("SCALAR", {0, 1});                                                         // 12
    const int cubicKeys = b.addFloats("VEC3", {0, 0, 0, 1, 2, 3, 0, 0, 1, 0, 0, 2, 4, 5, 6, 0, 0, 3});            // 13
    b.json["meshes"] = {{{"name", "square"},
                         {"weights", {0.25, 0.5}},
                         {"extras", {{"targetNames", {"bulge", "still"}}}},
                         {"primitives",
                          {{{"attributes",
                             {{"POSITION", positions},
                              {"NORMAL", normals},
                              {"TEXCOORD_0", uvs},
                              {"TANGENT", tangents},
                              {"JOINTS_0", joints},
                              {"WEIGHTS_0", weights}}},
                            {"indices", indices},
                            {"material", 0},
                            {"targets", {{{"POSITION", morph}}, {{"NORMAL", normals}}}}}}}}};
    b.json["nodes"] = {{{"name", "tip"}, {"translation", {0, 2, 0}}},
                       {{"name", "root"}, {"children", {0, 2}}, {"rotation", {0, 0, 2, 0}}, {"scale", {1, 2, 3}}},
                       {{"name", "body"}, {"mesh", 0}, {"skin", 0}},
                       {{"camera", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}},
                       {{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
    b.json["scenes"] = {{{"nodes", {4}}}, {{"nodes", {1, 3}}}};
    b.json["scene"] = 1;
    b.json["skins"] = {{{"joints", {1, 0}}, {"inverseBindMatrices", inverseBind}}};
    b.json["animations"] = {{{"channels",
                              {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}},
                               {{"sampler", 1}, {"target", {{"node", 2}, {"path", "weights"}}}},
                               {{"sampler", 2}, {"target", {{"node", 1}, {"path", "translation"}}}}}},
                             {"samplers",
                              {{{"input", times}, {"output", turns}},
                               {{"input", times}, {"output", morphKeys}, {"interpolation", "STEP"}},
                               {{"input", cubicTimes}, {"output", cubicKeys}, {"interpolation", "CUBICSPLINE"}}}}}};
    b.json["materials"] = {
        {{"name", "steel"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.5, 0.25, 0.125, 1}},
           {"metallicFactor", 0.75},
           {"roughnessFactor", 0.5},
           {"baseColorTexture", {{"index", 0}}}}},
         {"emissiveFactor", {1, 0.5, 0}},
         {"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}},
           {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 0.25}, {"anisotropyTexture", {{"index", 0}}}}},
           {"KHR_materials_ior", {{"ior", 1.75}}},
           {"KHR_materials_transmission", {{"transmissionFactor", 0.125}}}}},
         {"doubleSided", true}}};
    b.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
    b.json["samplers"] = {{{"wrapS", 33071}}};
    b.json["images"] = {{{"bufferView", b.addView("not decoded")}, {"mimeType", "image/png"}}, {{"uri", "a%20b+c.png"}}};
    b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.1}}}}};
    b.json["extensions"] = {{"KHR_lights_punctual",
                             {{"lights",
                               {{{"type", "spot"},
                                 {"intensity", 20},
                                 {"color", {1, 0.5, 0.25}},
                                 {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}}}}}};
    b.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_ior", "KHR_materials_transmission",
                                "KHR_materials_emissive_strength"};
    return b;
}

/// Throws std::logic_error where an index of the mesh points nowhere or a number is not finite: what no reader may let
/// through.
inline void requireValid(const Mesh &mesh) {
    const auto require = [](bool holds, const char *what) {
        if (!holds) throw std::logic_error(what);
    };
    const auto below = [&](const std::vector<Index> &indices, std::size_t count, bool noneAllowed) {
        return std::all_of(indices.begin(), indices.end(), [&](Index i) { return i < count || (noneAllowed && i == kNone); });
    };
    const std::size_t corners = mesh.cornerCount();
    require(!mesh.faceOffsets.empty() && mesh.faceOffsets.front() == 0 && mesh.faceOffsets.back() == corners, "face offsets");
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) require(mesh.faceOffsets[f + 1] >= mesh.faceOffsets[f] + 3, "face size");
    require(below(mesh.cornerPositions, mesh.positions.size(), false), "corner positions");
    for (const auto &[indices, count] :
         {std::pair(&mesh.cornerNormals, mesh.normals.size()), std::pair(&mesh.cornerUvs, mesh.uvs.size()),
          std::pair(&mesh.cornerTangents, mesh.tangents.size()), std::pair(&mesh.cornerColors, mesh.colors.size())}) {
        require(indices->empty() || indices->size() == corners, "corner attribute count");
        require(below(*indices, count, true), "corner attribute index");
    }
    require(std::all_of(mesh.positions.begin(), mesh.positions.end(), isFinite), "positions");
    for (const Index corner : mesh.cornerNormals)
        if (corner != kNone) require(std::fabs(glm::length(mesh.normals[corner]) - 1) < 1e-4F, "normals");
    require(mesh.faceMaterials.empty() ||
                (mesh.faceMaterials.size() == mesh.faceCount() && below(mesh.faceMaterials, mesh.materialNames.size(), false)),
            "materials");
    for (const MorphTarget &morph : mesh.morphs) require(morph.positionDeltas.size() == mesh.positions.size(), "morphs");
    require(mesh.skin.empty() ||
                (mesh.skin.offsets.size() == mesh.positions.size() + 1 && mesh.skin.offsets.back() == mesh.skin.joints.size()),
            "skin");
}

/// Reads a mesh or a glTF file and checks what it gives.
inline void readAny(const std::string &path) {
    Warnings warnings;
    if (!isGltfPath(path)) {
        requireValid(readMesh(path, warnings));
        return;
    }
    for (const Mesh &mesh : readGltf(path, warnings).meshes) requireValid(mesh);
}

/// The error that a file of these bytes gives; empty where it loads.
inline std::string errorOf(const std::string &name, const std::string &bytes) {
    try {
        readAny(writeFile(name, bytes));
        return {};
    } catch (const InputError &error) {
        return error.what();
    }
}

} // namespace taut::test
