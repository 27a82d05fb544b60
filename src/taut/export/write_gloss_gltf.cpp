/// glTF 2.0 with application attributes: every number of a GlossMesh under a name that starts with _TAUT_.

#include "taut/base/error.h"
#include "taut/base/utf8.h"
#include "taut/export/block_writer.h"
#include "taut/export/write_gloss.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>

namespace taut {

namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

/// Bytes of the binary buffer, each made when it is written.
struct Chunk {
    std::size_t rows;
    std::size_t rowBytes;
    std::function<void(std::size_t begin, std::size_t end, char *out)> fill;
};

class GltfBuilder {
  public:
    Json json{{"asset", {{"version", "2.0"}, {"generator", "taut " TAUT_VERSION}}}, {"scene", 0}};
    std::vector<Chunk> chunks;

    /// An accessor over rows of floats or indices; returns its number.
    std::size_t add(const char *type, int component, int target, std::size_t rows, std::size_t rowBytes, std::size_t scalarsPerRow,
                    decltype(Chunk::fill) fill) {
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", rows * rowBytes}, {"target", target}});
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"count", rows * scalarsPerRow},
                                     {"type", type}});
        chunks.push_back({rows, rowBytes, std::move(fill)});
        bytes_ += rows * rowBytes; // every scalar has four bytes, so all stays aligned
        return json["accessors"].size() - 1;
    }
    /// Vectors that stand together in memory.
    template <class V> std::size_t addVectors(const std::vector<V> &values) {
        static constexpr const char *kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
        return add(kTypes[V::length() - 1], kFloat, kArrayBuffer, values.size(), sizeof(V), 1,
                   [&values](std::size_t begin, std::size_t end, char *out) {
                       std::memcpy(out, values.data() + begin, (end - begin) * sizeof(V));
                   });
    }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  private:
    std::uint64_t bytes_ = 0;
};

std::string upperCase(std::string_view text) {
    std::string out(text);
    for (char &c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}

Json numbers(const Vec3 &v) {
    return {v.x, v.y, v.z};
}

Json attributesOf(GltfBuilder &builder, const GlossMesh &mesh) {
    Json attributes;
    const std::size_t position = builder.addVectors(mesh.positions);
    const Bounds bounds = boundsOf(mesh.positions);
    builder.json["accessors"][position]["min"] = numbers(bounds.lower);
    builder.json["accessors"][position]["max"] = numbers(bounds.upper);
    attributes["POSITION"] = position;
    attributes["NORMAL"] = builder.addVectors(mesh.normals);
    attributes["TANGENT"] = builder.addVectors(mesh.tangents);
    if (!mesh.uvs.empty())
        attributes["TEXCOORD_0"] = builder.add("VEC2", kFloat, kArrayBuffer, mesh.uvs.size(), sizeof(Vec2), 1,
                                               [&mesh](std::size_t begin, std::size_t end, char *out) {
                                                   for (std::size_t v = begin; v < end; ++v, out += sizeof(Vec2)) {
                                                       const Vec2 uv(mesh.uvs[v].x, 1 - mesh.uvs[v].y); // glTF: v down
                                                       std::memcpy(out, &uv, sizeof uv);
                                                   }
                                               });
    attributes["_TAUT_M"] = builder.addVectors(mesh.m);
    attributes["_TAUT_LEAN"] = builder.addVectors(mesh.lean);
    attributes["_TAUT_DS"] = builder.addVectors(mesh.ds);
    attributes["_TAUT_DT"] = builder.addVectors(mesh.dt);
    attributes["_TAUT_STRETCH"] = builder.addVectors(mesh.stretch);
    attributes["_TAUT_STRETCH_DIR"] = builder.addVectors(mesh.stretchDirection);
    attributes["_TAUT_ALPHA"] = builder.addVectors(mesh.alpha);
    attributes["_TAUT_ALPHA_DIR"] = builder.addVectors(mesh.alphaDirection);
    attributes["_TAUT_PREF"] = builder.addVectors(mesh.restPositions);
    if (mesh.convention != nullptr) attributes["_TAUT_" + upperCase(mesh.convention->name)] = builder.addVectors(mesh.conventionValues);
    return attributes;
}

/// Triangles of one material; kept alive until they are written.
struct PrimitiveIndices {
    std::vector<Index3> triangles;
};

Json materialOf(const GlossMaterial &material, const MeanGloss &mean, bool &clipped) {
    const ConventionValues khr = toConvention(Convention::Khr, mean.alpha);
    clipped = khr.clipped;
    Json out{{"name", validUtf8(material.name)},
             {"doubleSided", true},
             {"pbrMetallicRoughness",
              {{"baseColorFactor",
                {glm::clamp(material.color.x, 0.0F, 1.0F), glm::clamp(material.color.y, 0.0F, 1.0F),
                 glm::clamp(material.color.z, 0.0F, 1.0F), 1.0F}},
               {"metallicFactor", material.metal ? 1 : 0},
               {"roughnessFactor", khr.roughness}}}};
    if (khr.anisotropy > 1e-3F)
        out["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", khr.anisotropy}, {"anisotropyRotation", khr.rotation}};
    return out;
}

std::string withExtension(const std::string &path, const char *extension) {
    return std::filesystem::path(path).replace_extension(extension).string();
}

/// RFC 3986, section 2.1: every byte but the unreserved ones, so that a name of any script or none is a URI.
std::string escapedUri(const std::string &name) {
    std::string out;
    for (const char c : name) {
        const bool unreserved = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                                std::string_view("-._~").find(c) != std::string_view::npos;
        char escaped[4];
        std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
        out += unreserved ? std::string(1, c) : escaped;
    }
    return out;
}

void writeChunks(OutputFile &out, const std::vector<Chunk> &chunks) {
    for (const Chunk &chunk : chunks)
        writeBlocks(
            chunk.rows, kBinaryRows,
            [&](std::size_t begin, std::size_t end, std::string &bytes) {
                bytes.resize((end - begin) * chunk.rowBytes);
                chunk.fill(begin, end, bytes.data());
            },
            [&](const std::string &bytes) { out.write(bytes); });
}

void writeGlb(const std::string &path, const GltfBuilder &builder) {
    std::string json = builder.json.dump();
    json.append((4 - json.size() % 4) % 4, ' ');
    const std::uint64_t total = 12 + 8 + json.size() + 8 + builder.bytes();
    if (total > kMostBytes32)
        throw RunError(path + ": a .glb of more than 4 GB cannot be written; export fewer vertices or another format");
    OutputFile out(path);
    std::string header = "glTF";
    append32(header, 2);
    append32(header, total);
    append32(header, json.size());
    out.write(header + "JSON");
    out.write(json);
    std::string chunk;
    append32(chunk, builder.bytes());
    out.write(chunk + std::string("BIN\0", 4));
    writeChunks(out, builder.chunks);
    out.finish();
}

void writeSeparate(const std::string &path, GltfBuilder &builder) {
    const std::string binary = withExtension(path, ".bin");
    OutputFile out(binary);
    writeChunks(out, builder.chunks);
    builder.json["buffers"][0]["uri"] = escapedUri(std::filesystem::path(binary).filename().string());
    OutputFile text(path);
    text.write(builder.json.dump(1) + "\n");
    out.flush();
    text.flush();
    out.finish();
    text.finish();
}

} // namespace

std::size_t writeGlossGltf(const std::string &path, std::span<const GlossMesh> meshes, std::span<const std::vector<MeanGloss>> means) {
    GltfBuilder builder;
    std::size_t clippedMaterials = 0;
    bool anisotropic = false;
    std::vector<std::vector<PrimitiveIndices>> primitives(meshes.size());
    Json &json = builder.json;
    // World space, z up, to y up: a quarter turn about x.
    json["nodes"].push_back({{"name", "taut"}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}, {"children", Json::array()}});
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const GlossMesh &mesh = meshes[i];
        const Json attributes = attributesOf(builder, mesh);
        primitives[i].resize(mesh.materials.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            primitives[i][mesh.triangleMaterials[t]].triangles.push_back(mesh.triangles[t]);
        Json list = Json::array();
        for (std::size_t k = 0; k < mesh.materials.size(); ++k) {
            const std::vector<Index3> &triangles = primitives[i][k].triangles;
            if (triangles.empty()) continue;
            bool clipped = false;
            json["materials"].push_back(materialOf(mesh.materials[k], means[i][k], clipped));
            clippedMaterials += clipped ? 1 : 0;
            anisotropic = anisotropic || json["materials"].back().contains("extensions");
            const std::size_t indices = builder.add("SCALAR", kUnsignedInt, kElementArrayBuffer, triangles.size(), sizeof(Index3), 3,
                                                    [&triangles](std::size_t begin, std::size_t end, char *out) {
                                                        std::memcpy(out, triangles.data() + begin, (end - begin) * sizeof(Index3));
                                                    });
            list.push_back({{"attributes", attributes}, {"indices", indices}, {"material", json["materials"].size() - 1}, {"mode", 4}});
        }
        const std::string name = validUtf8(mesh.name);
        json["meshes"].push_back({{"name", name}, {"primitives", list}});
        json["nodes"].push_back({{"name", name}, {"mesh", json["meshes"].size() - 1}});
        json["nodes"][0]["children"].push_back(json["nodes"].size() - 1);
    }
    json["scenes"] = {{{"nodes", {0}}}};
    json["buffers"] = {{{"byteLength", builder.bytes()}}};
    if (anisotropic) json["extensionsUsed"] = {"KHR_materials_anisotropy"};
    if (lowerExtension(path) == "glb")
        writeGlb(path, builder);
    else
        writeSeparate(path, builder);
    return clippedMaterials;
}

} // namespace taut
