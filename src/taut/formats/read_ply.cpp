/// PLY, after G. Turk, "The PLY Polygon File Format" (1994): a header that describes elements, then their values.

#include "taut/formats/raw_number.h"
#include "taut/formats/read_formats.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace taut {

namespace {

struct ScalarType {
    std::array<std::string_view, 2> names;
    std::size_t bytes;
    double (*read)(const void *);
    bool integer = true;
};
constexpr auto kTypes = std::to_array<ScalarType>({{{"char", "int8"}, 1, rawAsDouble<std::int8_t>},
                                                   {{"uchar", "uint8"}, 1, rawAsDouble<std::uint8_t>},
                                                   {{"short", "int16"}, 2, rawAsDouble<std::int16_t>},
                                                   {{"ushort", "uint16"}, 2, rawAsDouble<std::uint16_t>},
                                                   {{"int", "int32"}, 4, rawAsDouble<std::int32_t>},
                                                   {{"uint", "uint32"}, 4, rawAsDouble<std::uint32_t>},
                                                   {{"float", "float32"}, 4, rawAsDouble<float>, false},
                                                   {{"double", "float64"}, 8, rawAsDouble<double>, false}});

/// Roles of properties: x y z nx ny nz s t of a vertex; then what a mesh that `taut export` wrote has: M_x M_y M_z, tangent_x
/// tangent_y tangent_z, tangent_sign_x, M_p_x M_q_x.
constexpr std::size_t kFirstNormal = 3;
constexpr std::size_t kFirstUv = 6;
constexpr std::size_t kFirstM = 8;
constexpr std::size_t kFirstTangent = 11;
constexpr std::size_t kTangentSign = 14;
constexpr std::size_t kFirstLean = 15;
constexpr std::size_t kVertexIndices = 17;
constexpr std::size_t kUnread = 18;

struct Property {
    std::string name;
    const ScalarType *type = nullptr;
    const ScalarType *countType = nullptr; ///< of a list, else null
    std::size_t role = kUnread;
};

struct Element {
    std::string name;
    std::int64_t count = 0;
    Location where;
    std::vector<Property> properties;

    /// The fewest bytes that one element takes.
    [[nodiscard]] std::size_t leastBytes(bool ascii) const {
        std::size_t bytes = 0;
        for (const Property &p : properties) bytes += ascii ? 2 : (p.countType != nullptr ? p.countType : p.type)->bytes;
        return bytes;
    }
    [[nodiscard]] const Property *find(std::string_view property) const {
        const auto found = std::find_if(properties.begin(), properties.end(), [&](const Property &p) { return p.name == property; });
        return found == properties.end() ? nullptr : &*found;
    }
};

struct Header {
    bool ascii = true;
    bool bigEndian = false;
    std::vector<Element> elements;
};

const ScalarType &readType(TextScanner &scanner, std::string_view word, bool integer) {
    std::vector<std::string_view> names;
    for (const ScalarType &type : kTypes) {
        if (integer && !type.integer) continue;
        for (const std::string_view name : type.names) {
            if (name == word) return type;
            names.push_back(name);
        }
    }
    failUnknownName(scanner.where(), word, names);
}

void readProperty(TextScanner &scanner, Header &header) {
    if (header.elements.empty()) failInput(scanner.where(), "a property", "an element before its properties");
    Element &element = header.elements.back();
    Property property;
    std::string_view type = scanner.word();
    if (type == "list") {
        property.countType = &readType(scanner, scanner.word(), true);
        type = scanner.word();
    }
    property.type = &readType(scanner, type, false);
    property.name = scanner.word();
    if (property.name.empty()) scanner.fail({}, "the name of the property");
    if (element.find(property.name) != nullptr)
        failInput(scanner.where(), "a second property " + taut::quoted(property.name), "each property once");
    element.properties.push_back(property);
}

void readFormat(TextScanner &scanner, Header &header) {
    constexpr auto kFormats = std::to_array<std::string_view>({"ascii", "binary_little_endian", "binary_big_endian"});
    const std::string_view format = scanner.word();
    if (std::find(kFormats.begin(), kFormats.end(), format) == kFormats.end()) failUnknownName(scanner.where(), format, kFormats);
    header.ascii = format == kFormats[0];
    header.bigEndian = format == kFormats[2];
    const std::string_view version = scanner.word();
    if (version != "1.0") scanner.fail(version, "version 1.0");
}

/// Leaves the scanner behind the line "end_header".
Header readHeader(TextScanner &scanner) {
    constexpr auto kKeywords = std::to_array<std::string_view>({"format", "comment", "obj_info", "element", "property", "end_header"});
    Header header;
    bool formatSeen = false;
    if (const std::string_view magic = scanner.word(); magic != "ply" && magic != "PLY") scanner.fail(magic, "'ply'");
    scanner.endLine();
    while (true) {
        const bool more = scanner.nextLine();
        const std::string_view keyword = scanner.word();
        if (!more) scanner.fail({}, "'end_header'");
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
        if (!formatSeen && keyword != "format") scanner.fail(keyword, "'format'; did you mean 'format'?");
        if (keyword == "end_header") break;
        if (keyword == "format") {
            readFormat(scanner, header);
            formatSeen = true;
        } else if (keyword == "element") {
            Element element;
            element.name = scanner.word();
            if (element.name.empty()) scanner.fail({}, "the name of the element");
            element.count = scanner.integer("the number of elements");
            element.where = scanner.where();
            header.elements.push_back(element);
        } else if (keyword == "property") {
            readProperty(scanner, header);
        } else {
            failUnknownName(scanner.where(), keyword, kKeywords);
        }
        scanner.endLine();
    }
    scanner.endLine();
    scanner.nextLine();
    return header;
}

Element &requireElement(Header &header, std::string_view name, const TextScanner &scanner) {
    std::vector<std::string_view> names;
    Element *found = nullptr;
    for (Element &element : header.elements) {
        names.push_back(element.name);
        if (element.name != name) continue;
        if (found != nullptr) failInput(element.where, "a second element " + taut::quoted(name), "one");
        found = &element;
    }
    if (found != nullptr) return *found;
    const std::string_view nearest = nearestName(name, names);
    failInput(scanner.where(),
              nearest.empty() ? "no element" : "no element " + taut::quoted(name) + " (the nearest is " + taut::quoted(nearest) + ")",
              "'element " + std::string(name) + "' in the header");
}

/// Gives the properties of an element their roles where all the names are there, as scalars.
bool assignRoles(Element &element, std::size_t firstRole, std::initializer_list<std::string_view> names) {
    const auto isScalar = [&](std::string_view name) {
        const Property *property = element.find(name);
        return property != nullptr && property->countType == nullptr;
    };
    if (!std::all_of(names.begin(), names.end(), isScalar)) return false;
    for (const std::string_view name : names)
        std::find_if(element.properties.begin(), element.properties.end(), [&](const Property &p) { return p.name == name; })->role =
            firstRole++;
    return true;
}

/// The values of the body, ASCII or binary, one after the other.
class Body {
  public:
    Body(std::string_view bytes, const Header &header, TextScanner scanner, std::string path)
        : bytes_(bytes), header_(header), scanner_(std::move(scanner)), path_(std::move(path)), pos_(scanner_.position()) {}

    /// ASCII elements stand on lines of their own; blank lines between them are skipped.
    void beginElement() {
        if (!header_.ascii) return;
        if (!firstLine_) scanner_.nextLine();
        firstLine_ = false;
        scanner_.skipEmptyLines();
    }
    void endElement() {
        if (header_.ascii) scanner_.endLine();
    }

    float number(const Property &p) {
        if (header_.ascii) return scanner_.number("the value of property " + taut::quoted(p.name));
        const double value = binary(*p.type);
        if (!(std::fabs(value) <= std::numeric_limits<float>::max()))
            failInput(where(), "a value of property " + taut::quoted(p.name) + " that is not finite",
                      "a finite number within float's range");
        return static_cast<float>(value);
    }
    std::int64_t integer(const ScalarType &type, const std::string &what) {
        if (header_.ascii) return scanner_.integer(what);
        const double value = binary(type);
        if (std::floor(value) != value || std::fabs(value) > 9e15) failInput(where(), "a number that is not an integer", what);
        return static_cast<std::int64_t>(value);
    }
    /// A value that nobody reads: only its extent matters.
    void skip(const ScalarType &type, const std::string &name) {
        if (!header_.ascii) {
            binary(type);
        } else if (const std::string_view word = scanner_.word(); word.empty()) {
            scanner_.fail(word, "the value of property " + taut::quoted(name));
        }
    }
    [[nodiscard]] Location where() const {
        return header_.ascii ? scanner_.where() : Location{path_, 0, 0, static_cast<std::int64_t>(valueStart_)};
    }
    [[nodiscard]] std::size_t leastBytes(const ScalarType &type) const { return header_.ascii ? 1 : type.bytes; }
    [[nodiscard]] std::size_t bytesLeft() const { return header_.ascii ? scanner_.remaining() : bytes_.size() - pos_; }
    [[nodiscard]] bool onlyBlanksLeft() {
        return header_.ascii ? scanner_.wordAcrossLines().empty() : bytes_.find_first_not_of(" \t\r\n", pos_) == std::string_view::npos;
    }

  private:
    double binary(const ScalarType &type) {
        valueStart_ = pos_;
        if (bytes_.size() - pos_ < type.bytes)
            failInput(where(), "the end of the file", "a value of " + std::to_string(type.bytes) + " bytes");
        unsigned char raw[8] = {};
        std::memcpy(raw, bytes_.data() + pos_, type.bytes);
        pos_ += type.bytes;
        if (header_.bigEndian) std::reverse(raw, raw + type.bytes);
        return type.read(raw);
    }

    std::string_view bytes_;
    const Header &header_;
    TextScanner scanner_;
    std::string path_;
    std::size_t pos_;
    std::size_t valueStart_ = 0;
    bool firstLine_ = true;
};

/// What a vertex has beside its position.
struct VertexParts {
    bool normals = false;
    bool uvs = false;
    bool gloss = false;      ///< M and its frame, of a mesh that `taut export` wrote
    std::size_t leaning = 0; ///< vertices whose M leans
};

VertexParts assignVertexRoles(Element &vertex) {
    if (!assignRoles(vertex, 0, {"x", "y", "z"}))
        failInput(vertex.where, "an element vertex without scalar properties x, y and z", "all three");
    VertexParts parts;
    parts.normals = assignRoles(vertex, kFirstNormal, {"nx", "ny", "nz"});
    parts.uvs = assignRoles(vertex, kFirstUv, {"s", "t"}) || assignRoles(vertex, kFirstUv, {"u", "v"}) ||
                assignRoles(vertex, kFirstUv, {"texture_u", "texture_v"});
    parts.gloss = vertex.find("tangent_x") != nullptr && assignRoles(vertex, kFirstM, {"M_x", "M_y", "M_z"}) &&
                  assignRoles(vertex, kFirstTangent, {"tangent_x", "tangent_y", "tangent_z"});
    if (parts.gloss) {
        assignRoles(vertex, kTangentSign, {"tangent_sign_x"});
        assignRoles(vertex, kFirstLean, {"M_p_x", "M_q_x"});
    }
    return parts;
}

void addVertex(const float (&values)[kVertexIndices], const Location &where, VertexParts &parts, Mesh &mesh) {
    const auto triple = [&](std::size_t first) { return Vec3(values[first], values[first + 1], values[first + 2]); };
    mesh.positions.push_back(triple(0));
    if (parts.normals) mesh.normals.push_back(triple(kFirstNormal));
    if (parts.uvs) mesh.uvs.emplace_back(values[kFirstUv], values[kFirstUv + 1]);
    if (!parts.gloss) return;
    const Vec3 m = triple(kFirstM);
    if (!(m.x > 0 && m.z > 0))
        failInput(where, "M with " + std::to_string(m.x) + " and " + std::to_string(m.z) + " on its diagonal", "M_x and M_z above 0");
    mesh.storedM.push_back(m);
    mesh.tangents.emplace_back(triple(kFirstTangent), values[kTangentSign] < 0 ? -1.0F : 1.0F);
    if (values[kFirstLean] != 0 || values[kFirstLean + 1] != 0) ++parts.leaning;
}

/// One element of any kind: its line or bytes are checked, and the mesh takes from it what it keeps.
void readElement(Body &body, const Element &element, std::size_t vertices, VertexParts &parts, Mesh &mesh) {
    float values[kVertexIndices] = {};
    body.beginElement();
    for (const Property &p : element.properties) {
        if (p.countType == nullptr) {
            if (p.role < kVertexIndices)
                values[p.role] = body.number(p);
            else
                body.skip(*p.type, p.name);
            continue;
        }
        const bool isFace = p.role == kVertexIndices;
        const std::int64_t length = body.integer(*p.countType, "the length of list " + taut::quoted(p.name));
        if (isFace) checkCornerCount(length, body.where());
        checkCount(length, body.leastBytes(*p.type), body.bytesLeft(), "items in list " + taut::quoted(p.name), body.where());
        for (std::int64_t i = 0; i < length; ++i) {
            if (!isFace) {
                body.skip(*p.type, p.name);
                continue;
            }
            const std::int64_t index = body.integer(*p.type, "a vertex index");
            mesh.cornerPositions.push_back(checkedVertex(index, vertices, body.where()));
        }
        if (isFace) mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    if (element.name == "vertex") addVertex(values, body.where(), parts, mesh);
    body.endElement();
}

Property &indexListOf(Element &face) {
    const auto isIndexList = [](const Property &p) {
        return p.countType != nullptr && p.type->integer && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    const auto indices = std::find_if(face.properties.begin(), face.properties.end(), isIndexList);
    if (indices == face.properties.end())
        failInput(face.where, "an element face without a list of integers vertex_indices", "'property list uchar int vertex_indices'");
    return *indices;
}

} // namespace

Mesh readPly(std::string_view bytes, const std::string &path, Warnings &warnings) {
    TextScanner scanner(bytes, path);
    Header header = readHeader(scanner);
    Element &vertex = requireElement(header, "vertex", scanner);
    Element &face = requireElement(header, "face", scanner);
    VertexParts parts = assignVertexRoles(vertex);
    indexListOf(face).role = kVertexIndices;

    Body body(bytes, header, std::move(scanner), path);
    for (const Element &element : header.elements) {
        const std::size_t least = element.leastBytes(header.ascii);
        if (least == 0 && element.count != 0)
            failInput(element.where, "an element " + taut::quoted(element.name) + " without properties", "at least one property");
        // The last line of a text may lack its end.
        if (least != 0)
            checkCount(element.count, least, body.bytesLeft() + (header.ascii ? 1 : 0), "elements " + taut::quoted(element.name),
                       element.where);
    }
    Mesh mesh;
    for (const Element &element : header.elements)
        for (std::int64_t i = 0; i < element.count; ++i) readElement(body, element, static_cast<std::size_t>(vertex.count), parts, mesh);
    if (!body.onlyBlanksLeft()) warnings.add(path + ": what follows the last element of the header was not read");
    if (parts.leaning > 0)
        warnings.add(path + ": M leans at " + std::to_string(parts.leaning) + " vertices; a stored M is taken as upright");
    if (parts.normals) mesh.cornerNormals = mesh.cornerPositions;
    if (parts.uvs) mesh.cornerUvs = mesh.cornerPositions;
    if (parts.gloss) mesh.cornerTangents = mesh.cornerPositions;
    return mesh;
}

} // namespace taut
