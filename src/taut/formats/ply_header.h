#pragma once
/// The header of a PLY file (G. Turk, "The PLY Polygon File Format", 1994): elements, their number, and the properties of each.

#include "taut/base/error.h"
#include "taut/formats/text_scanner.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace taut {

inline constexpr std::size_t kUnreadRole = 1000;

/// One of the types of values that a file may name.
struct PlyType {
    std::array<std::string_view, 2> names;
    std::size_t bytes;
    double (*read)(const void *);
    bool integer = true;
};

struct PlyProperty {
    std::string name;
    const PlyType *type = nullptr;
    const PlyType *countType = nullptr; ///< of a list, else null
    std::size_t role = kUnreadRole;     ///< what the reader makes of it
};

struct PlyElement {
    std::string name;
    std::int64_t count = 0;
    Location where;
    std::vector<PlyProperty> properties;

    /// The fewest bytes that one element takes.
    [[nodiscard]] std::size_t leastBytes(bool ascii) const {
        std::size_t bytes = 0;
        for (const PlyProperty &p : properties) bytes += ascii ? 2 : (p.countType != nullptr ? p.countType : p.type)->bytes;
        return bytes;
    }
    [[nodiscard]] const PlyProperty *find(std::string_view property) const {
        const auto found = std::find_if(properties.begin(), properties.end(), [&](const PlyProperty &p) { return p.name == property; });
        return found == properties.end() ? nullptr : &*found;
    }
};

struct PlyHeader {
    bool ascii = true;
    bool bigEndian = false;
    std::vector<PlyElement> elements;
    std::vector<std::string> textureFiles; ///< of comments "TextureFile NAME", as MeshLab writes them
};

/// Leaves the scanner behind the line "end_header".
PlyHeader readPlyHeader(TextScanner &scanner);

/// The element of that name, null where there is none. Fails where there are two.
PlyElement *findElement(PlyHeader &header, std::string_view name);
/// As findElement; fails where there is none.
PlyElement &requireElement(PlyHeader &header, std::string_view name, const TextScanner &scanner);

/// Gives the properties of an element their roles, counted up from `firstRole`, where all the names are there as scalars.
bool assignRoles(PlyElement &element, std::size_t firstRole, std::initializer_list<std::string_view> names);

} // namespace taut
