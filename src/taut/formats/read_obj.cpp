/// Wavefront OBJ (Wavefront Advanced Visualizer Manual, appendix B1): polygons with positions, normals and uvs per corner; and
/// the tags `t crease` and `t corner` that subdivision tools write into it (OpenSubdiv's test shapes): counts of integers,
/// numbers and texts, then these, with positions from 0.

#include "taut/formats/read_formats.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace taut {

namespace {

/// Keywords that say nothing about how the polygons look: names of their groups.
constexpr auto kNamesOfGroups = std::to_array<std::string_view>({"o", "g"});

/// How often each keyword that is not read occurs, in the order in which they are met first.
class Unread {
  public:
    void add(std::string_view keyword) {
        constexpr std::size_t kMostNames = 16; // of a file that is no OBJ each line begins with another
        const auto found = std::find_if(counts_.begin(), counts_.end(), [&](const auto &count) { return count.first == keyword; });
        if (found != counts_.end())
            ++found->second;
        else if (counts_.size() < kMostNames)
            counts_.emplace_back(keyword, 1);
        else
            ++others_;
    }
    /// "3 'l', 1 'curv'"; empty where there is none.
    [[nodiscard]] std::string text() const {
        std::string out;
        for (const auto &[keyword, count] : counts_)
            out += (out.empty() ? "" : ", ") + std::to_string(count) + " " + taut::quoted(keyword) +
                   (keyword == "mtllib" ? " (materials come from the scene)" : "");
        return others_ == 0 ? out : out + " and " + std::to_string(others_) + " of other keywords";
    }

  private:
    std::vector<std::pair<std::string, std::size_t>> counts_;
    std::size_t others_ = 0;
};

/// An index larger than the number of elements read so far: right only if the elements come later in the file.
struct ForwardReference {
    int line;
    int column;
    Index index;
    int attribute;
};

constexpr std::array<std::string_view, 3> kAttributeNames{"position (v)", "texture coordinate (vt)", "normal (vn)"};

class ObjReader {
  public:
    ObjReader(std::string_view bytes, const std::string &path, Warnings &warnings)
        : path_(path), warnings_(warnings), scanner_(bytes, path, '#', true) {}

    Mesh read() {
        do {
            const std::string_view keyword = scanner_.word();
            if (!keyword.empty()) readLine(keyword);
        } while (scanner_.nextLine());
        for (const ForwardReference &reference : forward_)
            if (reference.index >= count(reference.attribute))
                failRange({path_, reference.line, reference.column, -1}, std::to_string(std::int64_t{reference.index} + 1),
                          reference.attribute);
        warnOfUnread();
        if (!anyUv_) mesh_.cornerUvs.clear();
        if (!anyNormal_) mesh_.cornerNormals.clear();
        if (mesh_.materialNames.empty()) mesh_.faceMaterials.clear();
        return std::move(mesh_);
    }

  private:
    void readLine(std::string_view keyword) {
        if (keyword == "v") {
            // A weight, or three or four components of a colour, may follow.
            const float x = scanner_.number("a coordinate");
            const float y = scanner_.number("a coordinate");
            const float z = scanner_.number("a coordinate");
            mesh_.positions.emplace_back(x, y, z);
            if (skipNumbers() >= 3) ++colours_;
        } else if (keyword == "vt") {
            const float u = numberOrNan("a texture coordinate");
            const std::string_view v = scanner_.word();
            mesh_.uvs.emplace_back(u, v.empty() ? 0.0F : scanner_.toFloatOrNan(v, "a texture coordinate"));
            skipNumbers();
        } else if (keyword == "vn") {
            const float x = numberOrNan("a normal's component");
            const float y = numberOrNan("a normal's component");
            const float z = numberOrNan("a normal's component");
            mesh_.normals.emplace_back(x, y, z);
            scanner_.endLine();
        } else if (keyword == "f" || keyword == "fo") {
            readFace();
        } else if (keyword == "usemtl") {
            material_ = materialSlot(std::string(scanner_.restOfLine()));
        } else if (keyword == "t") {
            readTag();
        } else if (keyword == "s") {
            ++smoothingGroups_;
        } else if (std::find(kNamesOfGroups.begin(), kNamesOfGroups.end(), keyword) == kNamesOfGroups.end()) {
            unread_.add(keyword);
        }
    }

    /// Smoothing groups matter where no face has normals.
    void warnOfUnread() {
        std::string text = unread_.text();
        const auto add = [&](std::size_t count, const std::string &what) {
            if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
        };
        add(colours_, "vertex colours");
        add(anyNormal_ ? 0 : smoothingGroups_, "'s'");
        if (!text.empty()) warnings_.add(path_ + ": not read: " + text);
    }

    float numberOrNan(std::string_view expected) { return scanner_.toFloatOrNan(scanner_.word(), expected); }

    /// The rest of the line, of numbers; returns how many.
    std::size_t skipNumbers() {
        std::size_t count = 0;
        for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word(), ++count)
            scanner_.toFloatOrNan(word, "a number or the end of the line");
        return count;
    }

    void readFace() {
        std::size_t corners = 0;
        for (std::string_view corner = scanner_.word(); !corner.empty(); corner = scanner_.word(), ++corners) readCorner(corner);
        if (corners < 3)
            failInput(scanner_.where(), "a face of " + std::to_string(corners) + (corners == 1 ? " corner" : " corners"),
                      "at least 3 corners");
        mesh_.faceOffsets.push_back(static_cast<Index>(mesh_.cornerPositions.size()));
        mesh_.faceMaterials.push_back(material_ == kNone ? 0 : material_);
    }

    /// "crease n/m/0 v0 .. vn-1 s0 .. sm-1": a chain of edges, one sharpness for all or one for each; "corner" likewise, of
    /// single positions. Other tags are about things that are not read.
    void readTag() {
        const std::string_view tag = scanner_.word();
        if (tag != "crease" && tag != "corner") return;
        const std::string_view counts = scanner_.word();
        std::size_t integers = 0;
        std::size_t numbers = 0;
        const char *end = counts.data() + counts.size();
        const auto first = std::from_chars(counts.data(), end, integers);
        const bool slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
        const auto second = slash ? std::from_chars(first.ptr + 1, end, numbers) : first;
        if (!slash || second.ec != std::errc() || integers > 1U << 20U || numbers > integers)
            failInput(scanner_.where(), taut::quoted(counts), "the counts of a tag, such as 2/1/0");
        std::vector<Index> positions;
        for (std::size_t i = 0; i < integers; ++i) {
            const std::string_view digits = scanner_.word();
            Index position = 0;
            const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), position);
            if (error != std::errc() || stop != digits.data() + digits.size() || position >= mesh_.positions.size())
                failInput(scanner_.where(), taut::quoted(digits),
                          "a position, 0 to " + std::to_string(mesh_.positions.size()) + " excluded");
            positions.push_back(position);
        }
        const std::size_t features = tag == "corner" ? integers : integers - std::min<std::size_t>(integers, 1);
        float sharpness = kInfinitelySharp;
        for (std::size_t i = 0; i < features; ++i) {
            if (i < numbers) sharpness = scanner_.number("a sharpness");
            if (!(sharpness >= 0)) failInput(scanner_.where(), std::to_string(sharpness), "a sharpness, at least 0");
            if (tag == "corner")
                mesh_.corners.push_back({positions[i], sharpness});
            else
                mesh_.creases.push_back({positions[i], positions[i + 1], sharpness});
        }
    }

    /// v, v/t, v//n or v/t/n.
    void readCorner(std::string_view corner) {
        std::array<Index, 3> index{kNone, kNone, kNone};
        std::size_t begin = 0;
        for (int attribute = 0; attribute < 3 && begin <= corner.size(); ++attribute) {
            const std::size_t end = std::min(corner.find('/', begin), corner.size());
            const std::string_view digits = corner.substr(begin, end - begin);
            // Only the middle one of three may be left out ("1//3"); a slash at the end ("1/2/") is tolerated too.
            if (!digits.empty() || attribute == 0) index[static_cast<std::size_t>(attribute)] = readIndex(corner, digits, begin, attribute);
            begin = end + 1;
        }
        if (begin <= corner.size())
            failInput(scanner_.where(begin - 1), taut::quoted(corner.substr(begin - 1)), "at most three indices (v/vt/vn)");
        mesh_.cornerPositions.push_back(index[0]);
        mesh_.cornerUvs.push_back(index[1]);
        mesh_.cornerNormals.push_back(index[2]);
        anyUv_ |= index[1] != kNone;
        anyNormal_ |= index[2] != kNone;
    }

    Index readIndex(std::string_view corner, std::string_view digits, std::size_t offset, int attribute) {
        std::int64_t index = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
        if (error != std::errc() || end != digits.data() + digits.size())
            failInput(scanner_.where(offset), taut::quoted(corner), "a corner such as 1, 1/2, 1//3 or 1/2/3");
        const auto known = static_cast<std::int64_t>(count(attribute));
        if (index == 0 || index < -known || index > std::int64_t{0xfffffffe})
            failRange(scanner_.where(offset), std::string(digits), attribute);
        const auto result = static_cast<Index>(index > 0 ? index - 1 : known + index);
        if (index > known) {
            const Location where = scanner_.where(offset);
            forward_.push_back({where.line, where.column, result, attribute});
        }
        return result;
    }

    [[nodiscard]] std::size_t count(int attribute) const {
        return attribute == 0 ? mesh_.positions.size() : attribute == 1 ? mesh_.uvs.size() : mesh_.normals.size();
    }

    [[noreturn]] void failRange(const Location &where, const std::string &index, int attribute) const {
        const std::string known = std::to_string(count(attribute));
        failInput(where, "index " + taut::quoted(index) + " of a " + std::string(kAttributeNames[static_cast<std::size_t>(attribute)]),
                  count(attribute) == 0 ? "none, for the file has none" : "1 to " + known + " or -" + known + " to -1");
    }

    /// The slot of a material's name. Faces before the first usemtl are in a slot without a name.
    Index materialSlot(const std::string &name) {
        if (mesh_.materialNames.empty() && mesh_.faceCount() > 0) {
            mesh_.materialNames.emplace_back();
            slots_.emplace(std::string(), 0);
        }
        const auto [slot, isNew] = slots_.emplace(name, static_cast<Index>(mesh_.materialNames.size()));
        if (isNew) mesh_.materialNames.push_back(name);
        return slot->second;
    }

    std::string path_;
    Warnings &warnings_;
    TextScanner scanner_;
    Mesh mesh_;
    std::unordered_map<std::string, Index> slots_;
    std::vector<ForwardReference> forward_;
    Index material_ = kNone;
    bool anyUv_ = false;
    bool anyNormal_ = false;
    Unread unread_;
    std::size_t colours_ = 0;
    std::size_t smoothingGroups_ = 0;
};

} // namespace

Mesh readObj(std::string_view bytes, const std::string &path, Warnings &warnings) {
    return ObjReader(bytes, path, warnings).read();
}

} // namespace taut
