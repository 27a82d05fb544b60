/// OFF (Geomview's object file format, ASCII) and STL (ASCII and binary).

#include "taut/formats/canonical_ply.h"
#include "taut/formats/mesh_guard.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace taut {

namespace {

constexpr auto kOffKeywords = std::to_array<std::string_view>({"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"});

/// The numbers of this line: `least` at least and `most` at most.
void readNumbers(TextScanner &scanner, std::size_t least, std::size_t most, std::vector<float> &out) {
    out.clear();
    for (std::string_view word = scanner.word(); !word.empty() || out.size() < least; word = scanner.word()) {
        if (out.size() == most) failInput(scanner.where(), taut::quoted(word), "the end of the line");
        out.push_back(scanner.toFloat(word, "a number"));
    }
}

struct OffHeader {
    bool hasNormals = false;
    bool hasColours = false;
    bool hasUvs = false;
    std::int64_t vertices = 0;
    std::int64_t faces = 0;
};

/// Leaves the scanner on the line of the counts, which may be that of the keyword.
OffHeader readOffHeader(TextScanner &scanner) {
    OffHeader header;
    const std::string_view keyword = scanner.wordAcrossLines();
    if (std::find(kOffKeywords.begin(), kOffKeywords.end(), keyword) == kOffKeywords.end())
        failUnknownName(scanner.where(), keyword, kOffKeywords);
    const std::string_view prefix = keyword.substr(0, keyword.size() - 3);
    header.hasUvs = prefix.substr(0, 2) == "ST";
    header.hasColours = prefix.find('C') != std::string_view::npos;
    header.hasNormals = prefix.find('N') != std::string_view::npos;
    const std::string_view vertices = scanner.wordAcrossLines();
    if (vertices == "BINARY") failInput(scanner.where(), "a binary OFF file", "an ASCII one");
    header.vertices = scanner.toInteger(vertices, "the number of vertices");
    checkCount(header.vertices, 6, scanner.remaining(), "vertices", scanner.where());
    header.faces = scanner.integer("the number of faces");
    checkCount(header.faces, 8, scanner.remaining() + 1, "faces", scanner.where());
    if (const std::string_view edges = scanner.word(); !edges.empty()) scanner.toInteger(edges, "the number of edges");
    scanner.endLine();
    return header;
}

void beginOffLine(TextScanner &scanner) {
    scanner.nextLine();
    scanner.skipEmptyLines();
}

/// x y z [nx ny nz] [colour] [s t]: the colour has a free number of components.
void readOffVertex(TextScanner &scanner, const OffHeader &header, std::vector<float> &numbers, CanonicalPly &out) {
    const std::size_t uvs = header.hasUvs ? 2 : 0;
    const std::size_t leading = header.hasNormals ? 6 : 3;
    beginOffLine(scanner);
    readNumbers(scanner, leading + uvs, leading + uvs + (header.hasColours ? 4 : 0), numbers);
    float values[8] = {};
    std::copy_n(numbers.begin(), leading, values);
    std::copy_n(numbers.end() - static_cast<std::ptrdiff_t>(uvs), uvs, values + 6);
    out.addVertex(values);
}

void readOffFace(TextScanner &scanner, const OffHeader &header, std::vector<float> &numbers, CanonicalPly &out) {
    beginOffLine(scanner);
    const std::int64_t corners = scanner.integer("the number of corners of a face");
    checkCornerCount(corners, scanner.where());
    checkCount(corners, 2, scanner.remaining() + 1, "corners", scanner.where());
    out.beginFace(static_cast<std::int32_t>(corners));
    for (std::int64_t i = 0; i < corners; ++i) {
        const std::int64_t index = scanner.integer("a vertex index");
        checkVertexIndex(index, static_cast<std::size_t>(header.vertices), scanner.where());
        out.addCorner(static_cast<std::int32_t>(index));
    }
    readNumbers(scanner, 0, 4, numbers); // the colour
}

// --- STL --------------------------------------------------------------------------------------------------------------

constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

std::uint32_t stlTriangles(std::string_view bytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    return count;
}

CheckedFile checkBinaryStl(std::string_view bytes, const std::string &path) {
    const std::uint32_t triangles = stlTriangles(bytes);
    for (std::size_t t = 0; t < triangles; ++t)
        for (std::size_t i = 0; i < 9; ++i) {
            // Behind the normal, which nobody reads: exporters write NaN there for slivers.
            const std::size_t offset = kStlHeader + t * kStlTriangle + 12 + i * 4;
            float value = 0;
            std::memcpy(&value, bytes.data() + offset, sizeof value);
            if (!std::isfinite(value))
                failInput({path, 0, 0, static_cast<std::int64_t>(offset)}, "a coordinate that is not finite", "a finite number");
        }
    return {std::string(bytes), triangles, false, false};
}

char lowerCase(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
}

bool equalIgnoringCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lowerCase(x) == lowerCase(y); });
}

/// Reads one of `keywords` and returns its number.
std::size_t readKeyword(TextScanner &scanner, std::initializer_list<std::string_view> keywords) {
    const std::string_view word = scanner.wordAcrossLines();
    const auto found = std::find_if(keywords.begin(), keywords.end(), [&](std::string_view k) { return equalIgnoringCase(word, k); });
    if (found != keywords.end()) return static_cast<std::size_t>(found - keywords.begin());
    if (word.empty()) scanner.fail(word, taut::quoted(*keywords.begin()));
    std::string lower(word.substr(0, 64));
    std::transform(lower.begin(), lower.end(), lower.begin(), lowerCase);
    const std::vector<std::string_view> valid(keywords);
    failInput(scanner.where(), taut::quoted(word), taut::quoted(nearestName(lower, valid)));
}

void readFacet(TextScanner &scanner, std::string &out) {
    readKeyword(scanner, {"normal"});
    for (int i = 0; i < 3; ++i) {
        // Not read: exporters write "nan" or "-nan(ind)" for slivers.
        if (scanner.word().empty()) scanner.fail({}, "three components of the normal");
        appendBinary(out, 0.0F);
    }
    readKeyword(scanner, {"outer"});
    readKeyword(scanner, {"loop"});
    for (int i = 0; i < 3; ++i) {
        readKeyword(scanner, {"vertex"});
        for (int k = 0; k < 3; ++k) appendBinary(out, scanner.number("a coordinate"));
    }
    readKeyword(scanner, {"endloop"});
    readKeyword(scanner, {"endfacet"});
    appendBinary(out, std::uint16_t{0});
}

CheckedFile checkAsciiStl(std::string_view bytes, const std::string &path) {
    TextScanner scanner(bytes, path);
    std::string triangles;
    readKeyword(scanner, {"solid"});
    bool inside = true;
    while (true) {
        if (!inside) {
            if (!scanner.nextLine() || !scanner.skipEmptyLines()) break;
            readKeyword(scanner, {"solid"});
        }
        scanner.restOfLine();
        while (readKeyword(scanner, {"facet", "endsolid"}) == 0) readFacet(scanner, triangles);
        inside = false;
    }
    const auto count = static_cast<std::uint32_t>(triangles.size() / kStlTriangle);
    std::string out(80, ' ');
    appendBinary(out, count);
    return {out + triangles, count, false, false};
}

bool beginsWithSolid(std::string_view bytes) {
    TextScanner scanner(bytes.substr(0, 512), {});
    return equalIgnoringCase(scanner.wordAcrossLines(), "solid");
}

} // namespace

CheckedFile checkOff(std::string_view bytes, const std::string &path, Warnings &warnings) {
    TextScanner scanner(bytes, path, '#');
    const OffHeader header = readOffHeader(scanner);
    CanonicalPly out;
    out.hasNormals = header.hasNormals;
    out.hasUvs = header.hasUvs;
    std::vector<float> numbers;
    for (std::int64_t i = 0; i < header.vertices; ++i) readOffVertex(scanner, header, numbers, out);
    for (std::int64_t i = 0; i < header.faces; ++i) readOffFace(scanner, header, numbers, out);
    if (!scanner.wordAcrossLines().empty()) warnings.add(path + ": what follows the last face of the header's count was not read");
    return out.finish();
}

CheckedFile checkStl(std::string_view bytes, const std::string &path, Warnings &) {
    const bool solid = beginsWithSolid(bytes);
    if (bytes.size() >= kStlHeader) {
        const std::size_t triangles = stlTriangles(bytes);
        if (kStlHeader + triangles * kStlTriangle == bytes.size()) return checkBinaryStl(bytes, path);
        if (!solid)
            failInput({path, 0, 0, 80}, std::to_string(triangles) + " triangles in a file of " + std::to_string(bytes.size()) + " bytes",
                      "a file of " + std::to_string(kStlHeader + triangles * kStlTriangle) +
                          " bytes, or 'solid' at the start of an ASCII one");
    } else if (!solid) {
        failInput({path, 0, 0, static_cast<std::int64_t>(bytes.size())}, "the end of the file",
                  "a header of 84 bytes, or 'solid' at the start of an ASCII file");
    }
    return checkAsciiStl(bytes, path);
}

} // namespace taut
