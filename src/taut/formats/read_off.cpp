/// OFF: Geomview's object file format, ASCII.

#include "taut/formats/read_formats.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <array>
#include <vector>

namespace taut {

namespace {

constexpr auto kOffKeywords = std::to_array<std::string_view>({"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"});

/// The numbers of this line: `least` at least and `most` at most. The first `finite` of them are finite.
void readNumbers(TextScanner &scanner, std::size_t least, std::size_t most, std::size_t finite, std::vector<float> &out) {
    out.clear();
    for (std::string_view word = scanner.word(); !word.empty() || out.size() < least; word = scanner.word()) {
        if (out.size() == most) failInput(scanner.where(), taut::quoted(word), "the end of the line");
        out.push_back(out.size() < finite ? scanner.toFloat(word, "a number") : scanner.toFloatOrNan(word, "a number"));
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
    const std::string_view first = scanner.wordAcrossLines();
    // Widespread files have the first count at the end of the keyword: OFF490 518 0.
    const std::string_view keyword = first.substr(0, first.find_first_of("0123456789"));
    if (std::find(kOffKeywords.begin(), kOffKeywords.end(), keyword) == kOffKeywords.end())
        failUnknownName(scanner.where(), first, kOffKeywords);
    const std::string_view prefix = keyword.substr(0, keyword.size() - 3);
    header.hasUvs = prefix.substr(0, 2) == "ST";
    header.hasColours = prefix.find('C') != std::string_view::npos;
    header.hasNormals = prefix.find('N') != std::string_view::npos;
    const std::string_view vertices = keyword != first ? first.substr(keyword.size()) : scanner.wordAcrossLines();
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
void readOffVertex(TextScanner &scanner, const OffHeader &header, std::vector<float> &numbers, Mesh &mesh) {
    const std::size_t uvs = header.hasUvs ? 2 : 0;
    const std::size_t leading = header.hasNormals ? 6 : 3;
    beginOffLine(scanner);
    readNumbers(scanner, leading + uvs, leading + uvs + (header.hasColours ? 4 : 0), 3, numbers);
    mesh.positions.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (header.hasNormals) mesh.normals.emplace_back(numbers[3], numbers[4], numbers[5]);
    if (header.hasUvs) mesh.uvs.emplace_back(numbers[numbers.size() - 2], numbers.back());
}

/// True where the face has a colour.
bool readOffFace(TextScanner &scanner, std::vector<float> &numbers, Mesh &mesh) {
    beginOffLine(scanner);
    const std::int64_t corners = scanner.integer("the number of corners of a face");
    checkCornerCount(corners, scanner.where());
    checkCount(corners, 2, scanner.remaining() + 1, "corners", scanner.where());
    for (std::int64_t i = 0; i < corners; ++i) {
        const std::int64_t index = scanner.integer("a vertex index");
        mesh.cornerPositions.push_back(checkedVertex(index, mesh.positions.size(), scanner.where()));
    }
    mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    readNumbers(scanner, 0, 4, 0, numbers); // the colour
    return !numbers.empty();
}

} // namespace

Mesh readOff(std::string_view bytes, const std::string &path, Warnings &warnings) {
    TextScanner scanner(bytes, path, '#');
    const OffHeader header = readOffHeader(scanner);
    Mesh mesh;
    std::vector<float> numbers;
    for (std::int64_t i = 0; i < header.vertices; ++i) readOffVertex(scanner, header, numbers, mesh);
    std::int64_t faceColours = 0;
    for (std::int64_t i = 0; i < header.faces; ++i) faceColours += readOffFace(scanner, numbers, mesh) ? 1 : 0;
    if (header.hasColours || faceColours > 0)
        warnings.add(path + ": not read: " + std::to_string(header.hasColours ? header.vertices : 0) + " vertex colours, " +
                     std::to_string(faceColours) + " face colours");
    if (!scanner.wordAcrossLines().empty()) warnings.add(path + ": what follows the last face of the header's count was not read");
    if (header.hasNormals) mesh.cornerNormals = mesh.cornerPositions;
    if (header.hasUvs) mesh.cornerUvs = mesh.cornerPositions;
    return mesh;
}

} // namespace taut
