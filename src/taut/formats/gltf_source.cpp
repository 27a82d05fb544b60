#include "taut/formats/gltf_source.h"

#include "taut/base/file_bytes.h"
#include "taut/formats/raw_number.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>

namespace taut {

namespace {

namespace fs = std::filesystem;

/// The parts of a .glb, or the whole of a .gltf.
struct Container {
    std::string_view json;
    std::size_t jsonOffset = 0;
    bool binary = false;
    std::optional<std::string_view> bin;
};

std::uint32_t readWord(std::string_view bytes, std::size_t offset) {
    return rawNumber<std::uint32_t>(bytes.data() + offset);
}

/// glTF 2.0, section 4.4: a header of 12 bytes, then chunks of length, type and data.
Container openGlb(std::string_view bytes, const std::string &path, Warnings &warnings) {
    constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
    constexpr std::uint32_t kBinChunk = 0x004E4942;
    const auto fail = [&](std::size_t offset, const std::string &found, std::string_view expected) {
        failInput({path, 0, 0, static_cast<std::int64_t>(offset)}, found, expected);
    };
    if (bytes.size() < 4 || bytes.substr(0, 4) != "glTF") fail(0, taut::quoted(bytes.substr(0, 4)), "'glTF'");
    if (bytes.size() < 12) fail(bytes.size(), "the end of the file", "a header of 12 bytes");
    if (readWord(bytes, 4) != 2) fail(4, "version " + std::to_string(readWord(bytes, 4)), "version 2");
    if (readWord(bytes, 8) > bytes.size())
        fail(8, "a length of " + std::to_string(readWord(bytes, 8)) + " bytes", "at most the file's, " + std::to_string(bytes.size()));
    if (readWord(bytes, 8) < bytes.size()) {
        warnings.add(path + ": " + std::to_string(bytes.size() - readWord(bytes, 8)) +
                     " bytes that follow the length in its header were not read");
        bytes = bytes.substr(0, std::max<std::size_t>(readWord(bytes, 8), 12));
    }
    Container container;
    container.binary = true;
    for (std::size_t offset = 12, chunk = 0; offset < bytes.size(); ++chunk) {
        if (bytes.size() - offset < 8 && chunk == 0) fail(offset, "the end of the file", "a chunk's header of 8 bytes");
        if (bytes.size() - offset < 8) {
            warnings.add(path + ": " + std::to_string(bytes.size() - offset) + " bytes that follow the last chunk were not read");
            break;
        }
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

void checkExtensions(const GltfSource &source) {
    const GltfValue required = source["extensionsRequired"];
    for (std::size_t i = 0; i < required.size(); ++i) static_cast<void>(required[i].choice(knownExtensions()));
}

std::vector<unsigned char> readBuffer(const std::string &path, const GltfValue &buffer, bool first, const Container &container) {
    const auto length = static_cast<std::size_t>(buffer["byteLength"].integer(0));
    std::vector<unsigned char> bytes;
    if (buffer.has("uri")) {
        bytes = readUri(path, buffer["uri"]);
    } else {
        if (!first || !container.bin)
            buffer.fail("no 'uri'", container.binary ? "a 'uri', for the file has no BIN chunk for this buffer" : "a 'uri'");
        bytes.assign(container.bin->begin(), container.bin->end());
    }
    if (length > bytes.size())
        buffer["byteLength"].fail(std::to_string(length), "at most " + std::to_string(bytes.size()) + ", the bytes that are there");
    bytes.resize(length);
    return bytes;
}

/// RFC 4648, section 4, up to the first character outside the alphabet. Line breaks and blanks are passed over.
std::vector<unsigned char> decodeBase64(std::string_view text) {
    constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<signed char, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < kAlphabet.size(); ++i) values[static_cast<unsigned char>(kAlphabet[i])] = static_cast<signed char>(i);
    std::vector<unsigned char> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '\n' || c == '\r' || c == ' ' || c == '\t') continue;
        const int value = values[static_cast<unsigned char>(c)];
        if (value < 0) break;
        bits = bits << 6U | static_cast<std::uint32_t>(value);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<unsigned char>(bits >> static_cast<unsigned>(count)));
    }
    return bytes;
}

/// RFC 3986, section 2.1; a percent sign without two hexadecimal digits stands for itself.
std::string percentDecoded(std::string_view text) {
    const auto hexDigit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool escaped = text[i] == '%' && i + 2 < text.size() && hexDigit(text[i + 1]) >= 0 && hexDigit(text[i + 2]) >= 0;
        decoded += escaped ? static_cast<char>(hexDigit(text[i + 1]) * 16 + hexDigit(text[i + 2])) : text[i];
        if (escaped) i += 2;
    }
    return decoded;
}

/// RFC 2397: data:[<type>][;base64],<data>. What the type says is not asked: the bytes tell what they are.
std::vector<unsigned char> decodeDataUri(std::string_view text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos) return {};
    constexpr std::string_view kBase64 = ";base64";
    const std::string_view head = text.substr(0, comma);
    const std::string_view data = text.substr(comma + 1);
    if (head.size() >= kBase64.size() && head.substr(head.size() - kBase64.size()) == kBase64) {
        const bool escaped = data.find('%') != std::string_view::npos;
        return decodeBase64(escaped ? percentDecoded(data) : std::string(data));
    }
    const std::string decoded = percentDecoded(data);
    return {decoded.begin(), decoded.end()};
}

/// 0 where it is none.
std::size_t sizeOfFile(const std::string &gltfPath, const GltfValue &uri) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(pathOfUri(gltfPath, uri), error);
    return error ? 0 : static_cast<std::size_t>(size);
}

} // namespace

bool isDataUri(const GltfValue &uri) {
    return std::string_view(uri.text()).substr(0, 5) == "data:";
}

std::string pathOfUri(const std::string &gltfPath, const GltfValue &uri) {
    const std::string &text = uri.text();
    if (text.empty() || text.find("://") != std::string::npos || percentDecoded(text).find('\0') != std::string::npos)
        uri.fail(taut::quoted(text), "a data: URI or a path relative to the file");
    const fs::path folder = fs::path(gltfPath).parent_path();
    std::string slashes = text;
    std::replace(slashes.begin(), slashes.end(), '\\', '/');
    // A URI is percent-encoded, but many files hold the bare name: the name as it stands, if there is such a file, then its meaning.
    std::error_code error;
    for (const std::string &name : {text, slashes, percentDecoded(text)})
        if (fs::is_regular_file(folder / name, error)) return (folder / name).string();
    return (folder / percentDecoded(slashes)).string();
}

std::vector<unsigned char> readUri(const std::string &gltfPath, const GltfValue &uri) {
    if (isDataUri(uri)) {
        std::vector<unsigned char> bytes = decodeDataUri(std::string_view(uri.text()).substr(5));
        if (bytes.empty()) uri.fail(taut::quoted(uri.text()), "a data: URI with bytes (data:application/octet-stream;base64,...)");
        return bytes;
    }
    const std::string path = pathOfUri(gltfPath, uri);
    std::error_code error; // names that are too long, links in a circle
    if (!fs::is_regular_file(path, error)) uri.fail(taut::quoted(uri.text()) + ", which is no file", "a file at " + path);
    const std::string bytes = readFileBytes(path);
    return {bytes.begin(), bytes.end()};
}

GltfSource openGltf(const std::string &path, Budget &budget, Tally &leftOut, Warnings &warnings) {
    const std::string bytes = readFileBytes(path);
    const bool binary = lowerExtension(path) == "glb" || std::string_view(bytes).substr(0, 4) == "glTF";
    Container container;
    if (binary)
        container = openGlb(bytes, path, warnings);
    else
        container.json = std::string_view(bytes).substr(sizeOfByteOrderMark(bytes));
    GltfSource source{path, {}, {}, {}, bytes.size(), budget};
    budget.addInput(bytes.size());
    source.json = parseGltfJson(container.json, path, [&](std::size_t offset) { return locate(container, path, offset); });
    checkGltfJson(path, *source.json, leftOut);
    checkExtensions(source);
    const GltfValue buffers = source["buffers"];
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const std::size_t inFile = buffers[i].has("uri") && !isDataUri(buffers[i]["uri"]) ? sizeOfFile(path, buffers[i]["uri"]) : 0;
        budget.addInput(inFile);
        budget.take(static_cast<double>(std::max(inFile, buffers[i]["uri"].text().size())), buffers[i].place(), "its bytes");
        source.buffers.push_back(readBuffer(path, buffers[i], i == 0, container));
        source.fileBytes += source.buffers.back().size();
        if (buffers[i].has("uri") && !isDataUri(buffers[i]["uri"])) source.bufferPaths.push_back(pathOfUri(path, buffers[i]["uri"]));
    }
    return source;
}

} // namespace taut
