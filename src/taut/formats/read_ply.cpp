/// PLY, after G. Turk, "The PLY Polygon File Format" (1994): a header that describes elements, then their values.

#include "taut/formats/ply_header.h"
#include "taut/formats/read_formats.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace taut {

namespace {

/// Roles of properties: x y z nx ny nz s t of a vertex; then what a mesh that `taut export` wrote has: M_x M_y M_z, tangent_x
/// tangent_y tangent_z, tangent_sign_x, M_p_x M_q_x; then the lists of a face.
constexpr std::size_t kFirstNormal = 3;
constexpr std::size_t kFirstUv = 6;
constexpr std::size_t kFirstM = 8;
constexpr std::size_t kFirstTangent = 11;
constexpr std::size_t kTangentSign = 14;
constexpr std::size_t kFirstLean = 15;
constexpr std::size_t kVertexIndices = 17;
constexpr std::size_t kWedgeUvs = 18;     ///< u, v of each corner of a face
constexpr std::size_t kStripIndices = 19; ///< triangle strips one after the other, -1 between them

/// How an ASCII body is read: an element a line, or words wherever they stand.
enum class BodyLayout { Lines, Words };

/// The values of the body, ASCII or binary, one after the other.
class Body {
  public:
    Body(std::string_view bytes, const PlyHeader &header, TextScanner scanner, std::string path, BodyLayout layout)
        : bytes_(bytes), header_(header), scanner_(std::move(scanner)), path_(std::move(path)), lines_(layout == BodyLayout::Lines),
          pos_(scanner_.position()) {}

    /// Elements stand on lines of their own; blank lines between them are skipped.
    void beginElement() {
        if (!header_.ascii || !lines_) return;
        if (!firstLine_) scanner_.nextLine();
        firstLine_ = false;
        scanner_.skipEmptyLines();
    }
    void endElement() {
        if (header_.ascii && lines_) scanner_.endLine();
    }

    /// Normals and texture coordinates may be not-a-number; else the value is finite.
    float number(const PlyProperty &p) {
        const bool mayBeNan = (p.role >= kFirstNormal && p.role < kFirstM) || p.role == kWedgeUvs;
        if (header_.ascii) {
            const std::string expected = "the value of property " + taut::quoted(p.name);
            const std::string_view token = word();
            return mayBeNan ? scanner_.toFloatOrNan(token, expected) : scanner_.toFloat(token, expected);
        }
        const double value = binary(*p.type);
        if (!(std::fabs(value) <= std::numeric_limits<float>::max())) {
            if (mayBeNan) return std::numeric_limits<float>::quiet_NaN();
            failInput(where(), "a value of property " + taut::quoted(p.name) + " that is not finite",
                      "a finite number within float's range");
        }
        return static_cast<float>(value);
    }
    std::int64_t integer(const PlyType &type, const std::string &what) {
        if (header_.ascii) return scanner_.toInteger(word(), what);
        const double value = binary(type);
        if (std::floor(value) != value || std::fabs(value) > 9e15) failInput(where(), "a number that is not an integer", what);
        return static_cast<std::int64_t>(value);
    }
    /// A value that nobody reads: only its extent matters.
    void skip(const PlyType &type, const std::string &name) {
        if (!header_.ascii) {
            binary(type);
        } else if (const std::string_view skipped = word(); skipped.empty()) {
            scanner_.fail(skipped, "the value of property " + taut::quoted(name));
        }
    }
    [[nodiscard]] Location where() const {
        return header_.ascii ? scanner_.where() : Location{path_, 0, 0, static_cast<std::int64_t>(valueStart_)};
    }
    [[nodiscard]] std::size_t leastBytes(const PlyType &type) const { return header_.ascii ? 1 : type.bytes; }
    [[nodiscard]] std::size_t bytesLeft() const { return header_.ascii ? scanner_.remaining() : bytes_.size() - pos_; }
    [[nodiscard]] bool onlyBlanksLeft() {
        return header_.ascii ? scanner_.wordAcrossLines().empty() : bytes_.find_first_not_of(" \t\r\n", pos_) == std::string_view::npos;
    }

  private:
    std::string_view word() { return lines_ ? scanner_.word() : scanner_.wordAcrossLines(); }

    double binary(const PlyType &type) {
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
    const PlyHeader &header_;
    TextScanner scanner_;
    std::string path_;
    bool lines_;
    std::size_t pos_;
    std::size_t valueStart_ = 0;
    bool firstLine_ = true;
};

/// What a vertex has beside its position.
struct VertexParts {
    bool normals = false;
    bool uvs = false;
    bool gloss = false; ///< M and its frame, of a mesh that `taut export` wrote
};

VertexParts assignVertexRoles(PlyElement &vertex) {
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

/// The list of vertex indices of a face or of a strip.
void assignIndexRole(PlyElement &element, std::size_t role) {
    const auto isIndexList = [](const PlyProperty &p) {
        return p.countType != nullptr && p.type->integer && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    const auto indices = std::find_if(element.properties.begin(), element.properties.end(), isIndexList);
    if (indices == element.properties.end())
        failInput(element.where, "an element " + element.name + " without a list of integers vertex_indices",
                  "'property list uchar int vertex_indices'");
    indices->role = role;
}

/// MeshLab's list of two numbers a corner, where the map has seams at shared vertices.
bool assignWedgeRole(PlyElement &face) {
    for (PlyProperty &p : face.properties)
        if (p.countType != nullptr && !p.type->integer && p.name == "texcoord") {
            p.role = kWedgeUvs;
            return true;
        }
    return false;
}

/// A mesh that grows element by element.
class PlyMesh {
  public:
    PlyMesh(const PlyHeader &header, const VertexParts &parts, bool wedgeUvs, std::size_t vertices)
        : header_(&header), parts_(parts), wedgeUvs_(wedgeUvs), vertices_(vertices) {}

    /// All elements of the body.
    void read(Body &body) {
        for (const PlyElement &element : header_->elements)
            for (std::int64_t i = 0; i < element.count; ++i) readElement(body, element);
    }

    Mesh finish(const std::string &path, Warnings &warnings) {
        if (leaning_ > 0) warnings.add(path + ": M leans at " + std::to_string(leaning_) + " vertices; a stored M is taken as upright");
        if (oddWedges_ > 0)
            warnings.add(path + ": " + std::to_string(oddWedges_) +
                         " faces have a list texcoord of another length than two numbers a corner; they have no texture coordinates");
        if (parts_.normals) mesh_.cornerNormals = mesh_.cornerPositions;
        if (wedgeUvs_)
            mesh_.cornerUvs.resize(mesh_.cornerPositions.size(), kNone);
        else if (parts_.uvs)
            mesh_.cornerUvs = mesh_.cornerPositions;
        if (parts_.gloss) mesh_.cornerTangents = mesh_.cornerPositions;
        return std::move(mesh_);
    }

  private:
    /// One element of any kind: its line or bytes are checked, and the mesh takes from it what it keeps.
    void readElement(Body &body, const PlyElement &element) {
        float values[kVertexIndices] = {};
        wedge_.clear();
        const std::size_t corners = mesh_.cornerPositions.size();
        body.beginElement();
        for (const PlyProperty &p : element.properties) {
            if (p.countType != nullptr)
                readList(body, p);
            else if (p.role < kVertexIndices)
                values[p.role] = body.number(p);
            else
                body.skip(*p.type, p.name);
        }
        if (element.name == "vertex") addVertex(values, body.where());
        if (wedgeUvs_ && element.name == "face") addWedge(mesh_.cornerPositions.size() - corners);
        body.endElement();
    }

    void readList(Body &body, const PlyProperty &p) {
        const std::int64_t length = body.integer(*p.countType, "the length of list " + taut::quoted(p.name));
        if (p.role == kVertexIndices) checkCornerCount(length, body.where());
        checkCount(length, body.leastBytes(*p.type), body.bytesLeft(), "items in list " + taut::quoted(p.name), body.where());
        strip_.clear();
        for (std::int64_t i = 0; i < length; ++i) {
            if (p.role == kWedgeUvs) {
                wedge_.push_back(body.number(p));
            } else if (p.role == kVertexIndices || p.role == kStripIndices) {
                const std::int64_t index = body.integer(*p.type, "a vertex index");
                if (p.role == kVertexIndices)
                    mesh_.cornerPositions.push_back(checkedVertex(index, vertices_, body.where()));
                else
                    addToStrip(index, body.where());
            } else {
                body.skip(*p.type, p.name);
            }
        }
        if (p.role == kVertexIndices) mesh_.faceOffsets.push_back(static_cast<Index>(mesh_.cornerPositions.size()));
    }

    /// Each index after the second of a strip makes a triangle with the two before it; every other one is turned over. Where two of
    /// the three are the same the strip only goes on elsewhere.
    void addToStrip(std::int64_t index, const Location &where) {
        if (index == -1) {
            strip_.clear();
            return;
        }
        strip_.push_back(checkedVertex(index, vertices_, where));
        const std::size_t n = strip_.size();
        if (n < 3) return;
        Index a = strip_[n - 3];
        Index b = strip_[n - 2];
        const Index c = strip_[n - 1];
        if (a == b || b == c || a == c) return;
        if (n % 2 == 0) std::swap(a, b);
        for (const Index corner : {a, b, c}) mesh_.cornerPositions.push_back(corner);
        mesh_.faceOffsets.push_back(static_cast<Index>(mesh_.cornerPositions.size()));
    }

    void addVertex(const float (&values)[kVertexIndices], const Location &where) {
        const auto triple = [&](std::size_t first) { return Vec3(values[first], values[first + 1], values[first + 2]); };
        mesh_.positions.push_back(triple(0));
        if (parts_.normals) mesh_.normals.push_back(triple(kFirstNormal));
        if (parts_.uvs && !wedgeUvs_) mesh_.uvs.emplace_back(values[kFirstUv], values[kFirstUv + 1]);
        if (!parts_.gloss) return;
        const Vec3 m = triple(kFirstM);
        if (!(m.x > 0 && m.z > 0))
            failInput(where, "M with " + std::to_string(m.x) + " and " + std::to_string(m.z) + " on its diagonal", "M_x and M_z above 0");
        mesh_.storedM.push_back(m);
        mesh_.tangents.emplace_back(triple(kFirstTangent), values[kTangentSign] < 0 ? -1.0F : 1.0F);
        if (values[kFirstLean] != 0 || values[kFirstLean + 1] != 0) ++leaning_;
    }

    void addWedge(std::size_t corners) {
        const bool fits = wedge_.size() == 2 * corners;
        if (!fits && !wedge_.empty()) ++oddWedges_;
        mesh_.cornerUvs.resize(mesh_.cornerPositions.size() - corners, kNone); // of strips
        for (std::size_t i = 0; i < corners; ++i) {
            mesh_.cornerUvs.push_back(fits ? static_cast<Index>(mesh_.uvs.size()) : kNone);
            if (fits) mesh_.uvs.emplace_back(wedge_[2 * i], wedge_[2 * i + 1]);
        }
    }

    const PlyHeader *header_;
    VertexParts parts_;
    bool wedgeUvs_;
    std::size_t vertices_;
    Mesh mesh_;
    std::vector<float> wedge_; ///< of this face
    std::vector<Index> strip_;
    std::size_t leaning_ = 0;
    std::size_t oddWedges_ = 0;
};

/// What the file has and the mesh does not, in one line. Our own exports hold many properties that M is worth.
void warnOfUnread(const PlyHeader &header, bool ownExport, const std::string &path, Warnings &warnings) {
    std::string unread;
    const auto add = [&](const std::string &what) { unread += (unread.empty() ? "" : "; ") + what; };
    for (const PlyElement &element : header.elements) {
        const auto isUnread = [](const PlyProperty &p) { return p.role == kUnreadRole; };
        const auto count = std::count_if(element.properties.begin(), element.properties.end(), isUnread);
        if (element.count <= 0 || count == 0) continue;
        if (static_cast<std::size_t>(count) == element.properties.size()) {
            add(std::to_string(element.count) + " of element " + taut::quoted(element.name));
        } else if (!ownExport) {
            std::string names;
            for (const PlyProperty &p : element.properties)
                if (isUnread(p)) names += (names.empty() ? "" : ", ") + taut::quoted(p.name);
            add("properties of element " + taut::quoted(element.name) + ": " + names);
        }
    }
    for (const std::string &file : header.textureFiles) add("texture " + taut::quoted(file) + " of a comment");
    if (!unread.empty()) warnings.add(path + ": not read: " + unread);
}

} // namespace

Mesh readPly(std::string_view bytes, const std::string &path, Warnings &warnings) {
    TextScanner scanner(bytes, path);
    PlyHeader header = readPlyHeader(scanner);
    PlyElement &vertex = requireElement(header, "vertex", scanner);
    PlyElement *strips = findElement(header, "tristrips");
    PlyElement *face = strips == nullptr ? &requireElement(header, "face", scanner) : findElement(header, "face");
    const VertexParts parts = assignVertexRoles(vertex);
    if (strips != nullptr) assignIndexRole(*strips, kStripIndices);
    if (face != nullptr) assignIndexRole(*face, kVertexIndices);
    const bool wedgeUvs = face != nullptr && assignWedgeRole(*face);

    for (const PlyElement &element : header.elements) {
        const std::size_t least = element.leastBytes(header.ascii);
        if (least == 0 && element.count != 0)
            failInput(element.where, "an element " + taut::quoted(element.name) + " without properties", "at least one property");
        // The last line of a text may lack its end.
        if (least != 0)
            checkCount(element.count, least, scanner.remaining() + (header.ascii ? 1 : 0), "elements " + taut::quoted(element.name),
                       element.where);
    }
    PlyMesh mesh(header, parts, wedgeUvs, static_cast<std::size_t>(vertex.count));
    Body lines(bytes, header, scanner, path, BodyLayout::Lines);
    try {
        mesh.read(lines);
        if (!lines.onlyBlanksLeft()) warnings.add(path + ": what follows the last element of the header was not read");
    } catch (const InputError &) {
        // Some writers wrap lines, or write several elements on one. The same words are such a file if not one is too many or too few.
        if (!header.ascii) throw;
        PlyMesh again(header, parts, wedgeUvs, static_cast<std::size_t>(vertex.count));
        Body words(bytes, header, scanner, path, BodyLayout::Words);
        bool fits = true;
        try {
            again.read(words);
            fits = words.onlyBlanksLeft();
        } catch (const InputError &) {
            fits = false;
        }
        if (!fits) throw;
        mesh = std::move(again);
    }
    warnOfUnread(header, parts.gloss, path, warnings);
    return mesh.finish(path, warnings);
}

} // namespace taut
