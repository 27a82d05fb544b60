/// STL, ASCII and binary: a soup of triangles, welded by exact position.

#include "taut/formats/raw_number.h"
#include "taut/formats/read_formats.h"
#include "taut/formats/text_scanner.h"
#include "taut/mesh/weld.h"

#include <algorithm>
#include <vector>

namespace taut {

namespace {

constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

std::uint32_t stlTriangles(std::string_view bytes) {
    return rawNumber<std::uint32_t>(bytes.data() + 80);
}

/// Three positions a triangle.
std::vector<Vec3> readBinaryStl(std::string_view bytes, const std::string &path) {
    const std::size_t triangles = stlTriangles(bytes);
    std::vector<Vec3> soup(triangles * 3);
    for (std::size_t t = 0; t < triangles; ++t)
        for (std::size_t i = 0; i < 9; ++i) {
            // Behind the normal, which nobody reads: exporters write NaN there for slivers.
            const std::size_t offset = kStlHeader + t * kStlTriangle + 12 + i * 4;
            const auto value = rawNumber<float>(bytes.data() + offset);
            if (!std::isfinite(value))
                failInput({path, 0, 0, static_cast<std::int64_t>(offset)}, "a coordinate that is not finite", "a finite number");
            soup[t * 3 + i / 3][static_cast<int>(i % 3)] = value;
        }
    return soup;
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

bool containsVertex(std::string_view text) {
    constexpr std::string_view kVertex = "vertex";
    return std::search(text.begin(), text.end(), kVertex.begin(), kVertex.end(),
                       [](char found, char expected) { return lowerCase(found) == expected; }) != text.end();
}

void readFacet(TextScanner &scanner, std::vector<Vec3> &soup) {
    readKeyword(scanner, {"normal"});
    for (int i = 0; i < 3; ++i) // not read: exporters write "nan" or "-nan(ind)" for slivers
        if (scanner.word().empty()) scanner.fail({}, "three components of the normal");
    readKeyword(scanner, {"outer"});
    readKeyword(scanner, {"loop"});
    for (int i = 0; i < 3; ++i) {
        readKeyword(scanner, {"vertex"});
        Vec3 &p = soup.emplace_back();
        for (int k = 0; k < 3; ++k) p[k] = scanner.number("a coordinate");
    }
    readKeyword(scanner, {"endloop"});
    readKeyword(scanner, {"endfacet"});
}

std::vector<Vec3> readAsciiStl(std::string_view bytes, const std::string &path, Warnings &warnings) {
    TextScanner scanner(bytes, path);
    std::vector<Vec3> soup;
    readKeyword(scanner, {"solid"});
    bool inside = true;
    while (true) {
        if (!inside) {
            if (!scanner.nextLine() || !scanner.skipEmptyLines()) break;
            const std::string_view rest = bytes.substr(scanner.position());
            if (!equalIgnoringCase(scanner.word(), "solid")) {
                // Not a solid: no more than what programs append, unless it holds vertices.
                if (containsVertex(rest)) scanner.fail(rest.substr(0, rest.find_first_of(" \t\r\n")), "'solid'");
                warnings.add(path + ": " + std::to_string(rest.size()) + " bytes that follow the last 'endsolid' were not read");
                break;
            }
        }
        scanner.restOfLine();
        while (readKeyword(scanner, {"facet", "endsolid"}) == 0) readFacet(scanner, soup);
        inside = false;
    }
    return soup;
}

/// Binary headers of 80 bytes may begin with "solid" too, but a text has no zero bytes in them or in the count that follows.
bool isText(std::string_view bytes) {
    TextScanner scanner(bytes.substr(0, 512), {});
    return equalIgnoringCase(scanner.wordAcrossLines(), "solid") && bytes.substr(0, kStlHeader).find('\0') == std::string_view::npos;
}

std::vector<Vec3> readSoup(std::string_view bytes, const std::string &path, Warnings &warnings) {
    const bool solid = isText(bytes);
    if (bytes.size() >= kStlHeader) {
        const std::size_t triangles = stlTriangles(bytes);
        const std::size_t end = kStlHeader + triangles * kStlTriangle;
        if (end <= bytes.size() && (!solid || end == bytes.size())) {
            if (end < bytes.size())
                warnings.add(path + ": " + std::to_string(bytes.size() - end) + " bytes that follow its " + std::to_string(triangles) +
                             " triangles were not read");
            return readBinaryStl(bytes, path);
        }
        if (!solid)
            failInput({path, 0, 0, 80}, std::to_string(triangles) + " triangles in a file of " + std::to_string(bytes.size()) + " bytes",
                      "a file of " + std::to_string(kStlHeader + triangles * kStlTriangle) +
                          " bytes, or 'solid' at the start of an ASCII one");
    } else if (!solid) {
        failInput({path, 0, 0, static_cast<std::int64_t>(bytes.size())}, "the end of the file",
                  "a header of 84 bytes, or 'solid' at the start of an ASCII file");
    }
    return readAsciiStl(bytes, path, warnings);
}

} // namespace

Mesh readStl(std::string_view bytes, const std::string &path, Warnings &warnings) {
    const std::vector<Vec3> soup = readSoup(bytes, path, warnings);
    Mesh compared;
    compared.positions = soup;
    for (Vec3 &p : compared.positions) // what rounding has left of a zero
        for (int k = 0; k < 3; ++k)
            if (std::fabs(p[k]) <= std::numeric_limits<float>::min()) p[k] = 0;
    const std::vector<Index> first = weldPositions(compared, true);
    Mesh mesh;
    std::vector<Index> welded(first.size());
    for (Index corner = 0; corner < first.size(); ++corner) {
        if (first[corner] == corner) {
            welded[corner] = static_cast<Index>(mesh.positions.size());
            mesh.positions.push_back(soup[corner]);
        }
        mesh.cornerPositions.push_back(welded[first[corner]]);
        if (corner % 3 == 2) mesh.faceOffsets.push_back(corner + 1);
    }
    return mesh;
}

} // namespace taut
