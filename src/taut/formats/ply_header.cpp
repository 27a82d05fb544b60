#include "taut/formats/ply_header.h"

#include "taut/formats/raw_number.h"

namespace taut {

namespace {

constexpr auto kTypes = std::to_array<PlyType>({{{"char", "int8"}, 1, rawAsDouble<std::int8_t>},
                                                {{"uchar", "uint8"}, 1, rawAsDouble<std::uint8_t>},
                                                {{"short", "int16"}, 2, rawAsDouble<std::int16_t>},
                                                {{"ushort", "uint16"}, 2, rawAsDouble<std::uint16_t>},
                                                {{"int", "int32"}, 4, rawAsDouble<std::int32_t>},
                                                {{"uint", "uint32"}, 4, rawAsDouble<std::uint32_t>},
                                                {{"float", "float32"}, 4, rawAsDouble<float>, false},
                                                {{"double", "float64"}, 8, rawAsDouble<double>, false}});

const PlyType &readType(TextScanner &scanner, std::string_view word, bool integer) {
    std::vector<std::string_view> names;
    for (const PlyType &type : kTypes) {
        if (integer && !type.integer) continue;
        for (const std::string_view name : type.names) {
            if (name == word) return type;
            names.push_back(name);
        }
    }
    failUnknownName(scanner.where(), word, names);
}

void readProperty(TextScanner &scanner, PlyHeader &header) {
    if (header.elements.empty()) failInput(scanner.where(), "a property", "an element before its properties");
    PlyElement &element = header.elements.back();
    PlyProperty property;
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

void readFormat(TextScanner &scanner, PlyHeader &header) {
    constexpr auto kFormats = std::to_array<std::string_view>({"ascii", "binary_little_endian", "binary_big_endian"});
    const std::string_view format = scanner.word();
    if (std::find(kFormats.begin(), kFormats.end(), format) == kFormats.end()) failUnknownName(scanner.where(), format, kFormats);
    header.ascii = format == kFormats[0];
    header.bigEndian = format == kFormats[2];
    const std::string_view version = scanner.word();
    if (version != "1.0") scanner.fail(version, "version 1.0");
}

} // namespace

PlyHeader readPlyHeader(TextScanner &scanner) {
    constexpr auto kKeywords = std::to_array<std::string_view>({"format", "comment", "obj_info", "element", "property", "end_header"});
    PlyHeader header;
    bool formatSeen = false;
    if (const std::string_view magic = scanner.word(); magic != "ply" && magic != "PLY") scanner.fail(magic, "'ply'");
    scanner.endLine();
    const bool endsInCr = scanner.atLoneCr();
    while (true) {
        const bool more = scanner.nextLine();
        const std::string_view keyword = scanner.word();
        if (!more) scanner.fail({}, "'end_header'");
        if (keyword == "comment" && scanner.word() == "TextureFile") header.textureFiles.emplace_back(scanner.restOfLine());
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
        if (!formatSeen && keyword != "format") scanner.fail(keyword, "'format'; did you mean 'format'?");
        if (keyword == "end_header") break;
        if (keyword == "format") {
            readFormat(scanner, header);
            formatSeen = true;
        } else if (keyword == "element") {
            PlyElement element;
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
    // Where lines end in CR alone, a LF behind the last one is already a byte of the first element.
    scanner.nextLine(endsInCr);
    return header;
}

PlyElement *findElement(PlyHeader &header, std::string_view name) {
    PlyElement *found = nullptr;
    for (PlyElement &element : header.elements) {
        if (element.name != name) continue;
        if (found != nullptr) failInput(element.where, "a second element " + taut::quoted(name), "one");
        found = &element;
    }
    return found;
}

PlyElement &requireElement(PlyHeader &header, std::string_view name, const TextScanner &scanner) {
    if (PlyElement *found = findElement(header, name)) return *found;
    std::vector<std::string_view> names;
    for (const PlyElement &element : header.elements) names.push_back(element.name);
    const std::string_view nearest = nearestName(name, names);
    failInput(scanner.where(),
              nearest.empty() ? "no element" : "no element " + taut::quoted(name) + " (the nearest is " + taut::quoted(nearest) + ")",
              "'element " + std::string(name) + "' in the header");
}

bool assignRoles(PlyElement &element, std::size_t firstRole, std::initializer_list<std::string_view> names) {
    const auto isScalar = [&](std::string_view name) {
        const PlyProperty *property = element.find(name);
        return property != nullptr && property->countType == nullptr;
    };
    if (!std::all_of(names.begin(), names.end(), isScalar)) return false;
    for (const std::string_view name : names)
        std::find_if(element.properties.begin(), element.properties.end(), [&](const PlyProperty &p) { return p.name == name; })->role =
            firstRole++;
    return true;
}

} // namespace taut
