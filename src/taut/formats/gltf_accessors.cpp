#include "taut/formats/gltf_accessors.h"

#include "taut/formats/raw_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace taut {

namespace {

struct ComponentType {
    long long code;
    std::size_t bytes;
    std::string_view name;
    double (*read)(const void *);
    double greatest; ///< what normalising divides by; 0: not normalised

    /// glTF 2.0, section 3.11: c / max, and no less than -1.
    [[nodiscard]] double component(const unsigned char *raw, bool normalized) const {
        return normalized && greatest > 0 ? std::max(read(raw) / greatest, -1.0) : read(raw);
    }
    [[nodiscard]] bool isUnsigned() const { return name.substr(0, 8) == "UNSIGNED"; }
};
constexpr auto kComponentTypes = std::to_array<ComponentType>({{5120, 1, "BYTE", rawAsDouble<std::int8_t>, 127},
                                                               {5121, 1, "UNSIGNED_BYTE", rawAsDouble<std::uint8_t>, 255},
                                                               {5122, 2, "SHORT", rawAsDouble<std::int16_t>, 32767},
                                                               {5123, 2, "UNSIGNED_SHORT", rawAsDouble<std::uint16_t>, 65535},
                                                               {5125, 4, "UNSIGNED_INT", rawAsDouble<std::uint32_t>, 0},
                                                               {5126, 4, "FLOAT", rawAsDouble<float>, 0}});

const ComponentType &componentType(const GltfValue &code) {
    for (const ComponentType &type : kComponentTypes)
        if (type.code == code.integer(-1)) return type;
    code.fail(std::to_string(code.integer(-1)), "one of 5120, 5121, 5122, 5123, 5125, 5126");
}

std::string_view typeName(int components) {
    constexpr std::array<std::string_view, 5> kNames{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    return components == 16 ? "MAT4" : kNames[static_cast<std::size_t>(components)];
}

/// `count` elements of `elementBytes` each, `stride` apart, all inside the view.
struct Elements {
    const unsigned char *data = nullptr;
    std::size_t stride = 0;
};

/// The elements to which an accessor, or one half of a sparse one, points with its members bufferView and byteOffset.
Elements elementsOf(const GltfSource &source, const GltfValue &owner, std::size_t count, std::size_t elementBytes, bool strided) {
    const std::span<const unsigned char> bytes = gltfBufferView(source, owner["bufferView"]);
    const GltfValue view = source["bufferViews"][static_cast<std::size_t>(owner["bufferView"].integer(0))];
    const auto byteOffset = static_cast<std::size_t>(owner["byteOffset"].integer(0));
    const auto given = strided ? static_cast<std::size_t>(view["byteStride"].integer(0)) : 0;
    const std::size_t stride = given != 0 ? given : elementBytes;
    if (stride < elementBytes)
        view["byteStride"].fail(std::to_string(stride),
                                "at least " + std::to_string(elementBytes) + ", the size of an element of " + owner.path());
    // Counts and strides are below 2^31 (checkGltfJson), so the product fits.
    const bool fits = byteOffset <= bytes.size() && elementBytes <= bytes.size() - byteOffset &&
                      (count - 1) * stride <= bytes.size() - byteOffset - elementBytes;
    if (!fits)
        owner.fail(std::to_string(count) + " elements of " + std::to_string(elementBytes) + " bytes, " + std::to_string(stride) +
                       " apart from byte " + std::to_string(byteOffset),
                   "elements inside the " + std::to_string(bytes.size()) + " bytes of " + view.path());
    return {bytes.data() + byteOffset, stride};
}

/// What an accessor says of its elements.
struct Layout {
    const ComponentType &type;
    bool normalized;
    std::size_t components;
    std::size_t count;

    template <class T> void read(const unsigned char *from, T *to) const {
        for (std::size_t c = 0; c < components; ++c) to[c] = static_cast<T>(type.component(from + c * type.bytes, normalized));
    }
};

/// Overwrites the elements that a sparse accessor lists.
template <class T>
void applySparse(const GltfSource &source, const GltfValue &sparse, const Layout &layout, const std::vector<Index> *wanted,
                 std::vector<T> &values) {
    const auto count = static_cast<std::size_t>(sparse["count"].integer(0));
    if (count == 0 || count > layout.count)
        sparse["count"].fail(std::to_string(count), "1 to " + std::to_string(layout.count) + ", the accessor's count");
    const GltfValue listed = sparse["indices"];
    const ComponentType indexType = componentType(listed["componentType"]);
    if (!indexType.isUnsigned()) listed["componentType"].fail(indexType.name, "an unsigned type");
    const Elements indices = elementsOf(source, listed, count, indexType.bytes, false);
    const Elements replacing = elementsOf(source, sparse["values"], count, layout.type.bytes * layout.components, false);
    double last = -1;
    for (std::size_t i = 0; i < count; ++i) {
        const double index = indexType.component(indices.data + i * indices.stride, false);
        if (!(index > last) || !(index < static_cast<double>(layout.count)))
            listed.fail("index " + std::to_string(static_cast<long long>(index)) + " at place " + std::to_string(i),
                        "increasing indices below " + std::to_string(layout.count));
        last = index;
        auto place = static_cast<std::size_t>(index);
        if (wanted != nullptr) {
            const auto at = std::lower_bound(wanted->begin(), wanted->end(), static_cast<Index>(index));
            if (at == wanted->end() || *at != static_cast<Index>(index)) continue;
            place = static_cast<std::size_t>(at - wanted->begin());
        }
        layout.read(replacing.data + i * replacing.stride, &values[place * layout.components]);
    }
}

template <class T>
std::vector<T> decode(const GltfSource &source, const GltfValue &reference, int components, bool integersOnly,
                      const std::vector<Index> *wanted) {
    const std::string &use = reference.path();
    const GltfValue accessors = source["accessors"];
    const GltfValue accessor = accessors[reference.index(accessors.size(), "accessors")];
    if (accessor["type"].text() != typeName(components))
        accessor["type"].fail(taut::quoted(accessor["type"].text()), taut::quoted(typeName(components)) + " for " + use);
    const GltfValue typeCode = accessor["componentType"];
    const Layout layout{componentType(typeCode), accessor["normalized"].isTrue(), static_cast<std::size_t>(components),
                        static_cast<std::size_t>(accessor["count"].integer(0))};
    if (integersOnly && (!layout.type.isUnsigned() || layout.normalized))
        typeCode.fail(std::string(layout.type.name) + (layout.normalized ? ", normalized" : ""), "an unsigned integer type for " + use);
    if (components == 16 && layout.type.name != "FLOAT") typeCode.fail(layout.type.name, "FLOAT for " + use);
    // Elements without a buffer view are zeros; more of them than the file has bytes is a trick.
    const bool inBuffer = accessor.has("bufferView");
    if (layout.count == 0 || (!inBuffer && layout.count > source.fileBytes))
        accessor["count"].fail(std::to_string(layout.count), "a count from 1 to what the file holds");
    Elements elements;
    if (inBuffer) elements = elementsOf(source, accessor, layout.count, layout.type.bytes * layout.components, true);
    // Accessors may be shared by any number of users: the sum is what has to stay in proportion to the file.
    const std::size_t count = wanted != nullptr ? wanted->size() : layout.count;
    source.budget.take(static_cast<double>(count) * static_cast<double>(layout.components) * sizeof(T), accessor.place(),
                       std::to_string(count) + " elements for " + use);
    std::vector<T> values(count * layout.components, T(0));
    if (inBuffer)
        for (std::size_t i = 0; i < count; ++i)
            layout.read(elements.data + (wanted != nullptr ? (*wanted)[i] : i) * elements.stride, &values[i * layout.components]);
    if (accessor.has("sparse")) applySparse(source, accessor["sparse"], layout, wanted, values);
    return values;
}

} // namespace

std::span<const unsigned char> gltfBufferView(const GltfSource &source, const GltfValue &reference) {
    const GltfValue views = source["bufferViews"];
    const GltfValue view = views[reference.index(views.size(), "bufferViews")];
    const Index buffer = view["buffer"].index(source.buffers.size(), "buffers");
    const std::span<const unsigned char> bytes = source.buffers[buffer];
    const auto offset = static_cast<std::size_t>(view["byteOffset"].integer(0));
    const auto length = static_cast<std::size_t>(view["byteLength"].integer(0));
    if (offset > bytes.size() || length > bytes.size() - offset)
        view.fail(std::to_string(length) + " bytes from byte " + std::to_string(offset),
                  "a range inside the " + std::to_string(bytes.size()) + " bytes of " + jsonPath("buffers", buffer));
    return bytes.subspan(offset, length);
}

std::size_t accessorCount(const GltfSource &source, const GltfValue &reference) {
    const GltfValue accessors = source["accessors"];
    return static_cast<std::size_t>(accessors[reference.index(accessors.size(), "accessors")]["count"].integer(0));
}

std::vector<float> accessorFloats(const GltfSource &source, const GltfValue &reference, int components, const std::vector<Index> *wanted) {
    std::vector<float> values = decode<float>(source, reference, components, false, wanted);
    const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
    if (bad != values.end()) {
        const auto place = static_cast<std::size_t>((bad - values.begin()) / components);
        reference.fail("a number that is not finite in element " + std::to_string(wanted != nullptr ? (*wanted)[place] : place),
                       "finite numbers");
    }
    return values;
}

std::vector<Index> accessorIndices(const GltfSource &source, const GltfValue &reference, int components, const std::vector<Index> *wanted) {
    return decode<Index>(source, reference, components, true, wanted);
}

} // namespace taut
