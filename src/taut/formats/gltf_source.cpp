#include "taut/formats/gltf_source.h"

#include "taut/base/file_bytes.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <filesystem>

namespace taut {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr auto kKnownExtensions =
    std::to_array<std::string_view>({"KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_ior", "KHR_materials_transmission",
                                     "KHR_materials_emissive_strength", "KHR_texture_transform", "KHR_mesh_quantization"});
/// Deeper nesting than any real file has; tinygltf and the JSON library recurse.
constexpr int kDeepestJson = 96;

/// The parts of a .glb, or the whole of a .gltf.
struct Container {
    std::string_view json;
    std::size_t jsonOffset = 0;
    bool binary = false;
    std::optional<std::string_view> bin;
};

std::uint32_t readWord(std::string_view bytes, std::size_t offset) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, sizeof word);
    return word;
}

/// glTF 2.0, section 4.4: a header of 12 bytes, then chunks of length, type and data.
Container openGlb(std::string_view bytes, const std::string &path) {
    constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
    constexpr std::uint32_t kBinChunk = 0x004E4942;
    const auto fail = [&](std::size_t offset, const std::string &found, std::string_view expected) {
        failInput({path, 0, 0, static_cast<std::int64_t>(offset)}, found, expected);
    };
    if (bytes.size() < 4 || bytes.substr(0, 4) != "glTF") fail(0, taut::quoted(bytes.substr(0, 4)), "'glTF'");
    if (bytes.size() < 12) fail(bytes.size(), "the end of the file", "a header of 12 bytes");
    if (readWord(bytes, 4) != 2) fail(4, "version " + std::to_string(readWord(bytes, 4)), "version 2");
    if (readWord(bytes, 8) != bytes.size())
        fail(8, "a length of " + std::to_string(readWord(bytes, 8)) + " bytes", "the file's, " + std::to_string(bytes.size()));
    Container container;
    container.binary = true;
    for (std::size_t offset = 12, chunk = 0; offset < bytes.size(); ++chunk) {
        if (bytes.size() - offset < 8) fail(offset, "the end of the file", "a chunk's header of 8 bytes");
        const std::size_t length = readWord(bytes, offset);
        const std::uint32_t type = readWord(bytes, offset + 4);
        if (length > bytes.size() - offset - 8)
            fail(offset, "a chunk of " + std::to_string(length) + " bytes",
                 "at most " + std::to_string(bytes.size() - offset - 8) + ", which is what is left of the file");
        if (chunk == 0 && type != kJsonChunk) fail(offset + 4, taut::quoted(bytes.substr(offset + 4, 4)), "'JSON'");
        const std::string_view data = bytes.substr(offset + 8, length);
        if (chunk == 0) {
            container.json = data;
            container.jsonOffset = offset + 8;
        } else if (chunk == 1 && type == kBinChunk) {
            container.bin = data;
        }
        offset += 8 + length;
    }
    if (container.jsonOffset == 0) fail(12, "the end of the file", "a chunk with the JSON");
    return container;
}

/// `offset` bytes into the JSON, as a line and column of a text, or as a byte of a .glb.
Location locate(const Container &container, const std::string &path, std::size_t offset) {
    offset = std::min(offset, container.json.size());
    if (container.binary) return {path, 0, 0, static_cast<std::int64_t>(container.jsonOffset + offset)};
    const std::string_view before = container.json.substr(0, offset);
    const std::size_t lineStart = before.rfind('\n') + 1; // npos + 1 is 0
    return {path, 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')), 1 + static_cast<int>(offset - lineStart), -1};
}

/// Where the token begins that ends before `end`: the JSON library says only where it stopped.
std::size_t lastTokenBegin(std::string_view text, std::size_t end) {
    constexpr std::string_view kStructural = "{}[]:,";
    if (end == 0) return 0;
    std::size_t begin = end - 1;
    if (kStructural.find(text[begin]) != std::string_view::npos) return begin;
    if (text[begin] == '"') {
        while (begin > 0 && text[begin - 1] != '"' && text[begin - 1] != '\n') --begin;
        return begin > 0 ? begin - 1 : 0;
    }
    while (begin > 0 && !std::isspace(static_cast<unsigned char>(text[begin - 1])) &&
           kStructural.find(text[begin - 1]) == std::string_view::npos)
        --begin;
    return begin;
}

json parseJson(const Container &container, const std::string &path) {
    try {
        const auto limitDepth = [&](int depth, json::parse_event_t, json &) {
            if (depth > kDeepestJson)
                failGltf(path, "the JSON", "members nested deeper than " + std::to_string(kDeepestJson) + " levels", "fewer levels");
            return true;
        };
        return json::parse(container.json.begin(), container.json.end(), limitDepth);
    } catch (const json::parse_error &error) {
        // "[json.exception...] parse error at line 1, column 5: syntax error while parsing value - ...; last read: '...'"
        std::string reason = error.what();
        reason = reason.substr(std::min(reason.find(": ") + 2, reason.size()));
        reason = reason.substr(0, reason.find("; last read"));
        const std::size_t end = std::min(error.byte, container.json.size());
        const std::size_t begin = error.byte > end ? end : lastTokenBegin(container.json, end);
        const std::string_view token = container.json.substr(begin, end - begin);
        failInput(locate(container, path, begin), token.empty() ? "the end of the JSON" : taut::quoted(token),
                  "valid JSON (" + reason.substr(0, 200) + ")");
    } catch (const json::exception &error) {
        failGltf(path, "the JSON", std::string(error.what()).substr(0, 200), "valid JSON");
    }
}

void checkExtensions(const std::string &path, const json &file, Warnings &warnings) {
    const auto known = [](std::string_view name) {
        return std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) != kKnownExtensions.end();
    };
    const json required = file.value("extensionsRequired", json::array());
    for (std::size_t i = 0; i < required.size(); ++i)
        if (const auto name = required[i].get<std::string>(); !known(name))
            failUnknownName({path + ": " + jsonPath("extensionsRequired", i), 0, 0, -1}, name, kKnownExtensions);
    for (const json &used : file.value("extensionsUsed", json::array()))
        if (const auto name = used.get<std::string>(); !known(name))
            warnings.add(path + ": extension " + taut::quoted(name) + " is not read");
}

std::vector<unsigned char> readBuffer(const std::string &path, const json &buffer, std::size_t index, const Container &container) {
    const std::string where = jsonPath("buffers", index);
    const auto length = buffer["byteLength"].get<std::size_t>();
    std::vector<unsigned char> bytes;
    if (buffer.contains("uri")) {
        bytes = readUri(path, where + ".uri", buffer["uri"].get<std::string>());
    } else {
        if (index != 0 || !container.bin)
            failGltf(path, where, "no 'uri'", container.binary ? "a 'uri', for the file has no BIN chunk for this buffer" : "a 'uri'");
        bytes.assign(container.bin->begin(), container.bin->end());
    }
    if (length > bytes.size())
        failGltf(path, where + ".byteLength", std::to_string(length),
                 "at most " + std::to_string(bytes.size()) + ", the bytes that are there");
    bytes.resize(length);
    return bytes;
}

/// Runs tinygltf over the JSON alone: buffers and images are read here, with their own errors and without decoding.
void runTinyGltf(GltfSource &source) {
    json rest = source.json;
    rest.erase("buffers");
    rest.erase("images");
    const std::string text = rest.dump();
    std::string error;
    std::string warning;
    bool loaded = false;
    try {
        tinygltf::TinyGLTF loader;
        loaded = loader.LoadASCIIFromString(&source.model, &error, &warning, text.c_str(), static_cast<unsigned int>(text.size()), "");
    } catch (const std::exception &exception) {
        error = exception.what();
    }
    while (!error.empty() && (error.back() == '\n' || error.back() == ' ')) error.pop_back();
    if (!loaded) failGltf(source.path, "the JSON", "what tinygltf calls " + error.substr(0, 200), "a glTF 2.0 file");
}

} // namespace

void failGltf(const std::string &path, std::string_view where, std::string_view found, std::string_view expected) {
    failInput({path + ": " + std::string(where), 0, 0, -1}, found, expected);
}

std::string jsonPath(std::string_view name, std::size_t index) {
    return std::string(name) + "[" + std::to_string(index) + "]";
}

Index checkedIndex(const GltfSource &source, std::string_view where, long long index, std::size_t count, std::string_view what) {
    if (index < 0 || static_cast<unsigned long long>(index) >= count)
        failGltf(source.path, where, std::to_string(index),
                 count == 0 ? "none, for the file has no " + std::string(what) : "0 to " + std::to_string(count - 1));
    return static_cast<Index>(index);
}

std::string nameOr(const std::string &name, std::string_view kind, std::size_t number) {
    return name.empty() ? std::string(kind) + std::to_string(number) : name;
}

std::string pathOfUri(const std::string &gltfPath, const std::string &where, const std::string &uri) {
    const auto hexDigit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    std::string decoded;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const bool escaped = uri[i] == '%' && i + 2 < uri.size() && hexDigit(uri[i + 1]) >= 0 && hexDigit(uri[i + 2]) >= 0;
        decoded += escaped ? static_cast<char>(hexDigit(uri[i + 1]) * 16 + hexDigit(uri[i + 2])) : uri[i];
        if (escaped) i += 2;
    }
    if (decoded.empty() || decoded.find('\0') != std::string::npos || decoded.find("://") != std::string::npos)
        failGltf(gltfPath, where, taut::quoted(uri), "a data: URI or a path relative to the file");
    return (fs::path(gltfPath).parent_path() / decoded).string();
}

std::vector<unsigned char> readUri(const std::string &gltfPath, const std::string &where, const std::string &uri) {
    if (uri.substr(0, 5) == "data:") {
        std::vector<unsigned char> bytes;
        std::string mimeType;
        if (!tinygltf::DecodeDataURI(&bytes, mimeType, uri, 0, false))
            failGltf(gltfPath, where, taut::quoted(uri),
                     "a data: URI of a known type with bytes in base64 (data:application/octet-stream;base64,...)");
        return bytes;
    }
    const std::string path = pathOfUri(gltfPath, where, uri);
    if (!fs::is_regular_file(path)) failGltf(gltfPath, where, taut::quoted(uri) + ", which is no file", "a file at " + path);
    const std::string bytes = readFileBytes(path);
    return {bytes.begin(), bytes.end()};
}

GltfSource openGltf(const std::string &path, Warnings &warnings) {
    const std::string bytes = readFileBytes(path);
    const bool binary = lowerExtension(path) == "glb" || std::string_view(bytes).substr(0, 4) == "glTF";
    Container container;
    if (binary)
        container = openGlb(bytes, path);
    else
        container.json = bytes;
    GltfSource source;
    source.path = path;
    source.fileBytes = bytes.size();
    source.json = parseJson(container, path);
    checkGltfJson(path, source.json);
    checkExtensions(path, source.json, warnings);
    const json buffers = source.json.value("buffers", json::array());
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        source.buffers.push_back(readBuffer(path, buffers[i], i, container));
        source.fileBytes += source.buffers.back().size();
    }
    runTinyGltf(source);
    return source;
}

} // namespace taut
