#include "taut/formats/gltf_accessors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace taut {

namespace {

struct ComponentType {
    int code;
    std::size_t bytes;
    std::string_view name;
};
constexpr auto kComponentTypes = std::to_array<ComponentType>({{TINYGLTF_COMPONENT_TYPE_BYTE, 1, "BYTE"},
                                                               {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, 1, "UNSIGNED_BYTE"},
                                                               {TINYGLTF_COMPONENT_TYPE_SHORT, 2, "SHORT"},
                                                               {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, 2, "UNSIGNED_SHORT"},
                                                               {TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 4, "UNSIGNED_INT"},
                                                               {TINYGLTF_COMPONENT_TYPE_FLOAT, 4, "FLOAT"}});

const ComponentType &componentType(const GltfSource &source, int code, const std::string &where) {
    for (const ComponentType &type : kComponentTypes)
        if (type.code == code) return type;
    failGltf(source.path, where, std::to_string(code), "one of 5120, 5121, 5122, 5123, 5125, 5126");
}

template <class T> double as(const unsigned char *raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
}

/// One component; normalised integers after glTF 2.0, section 3.11: c / max, and no less than -1.
double component(const unsigned char *raw, int code, bool normalized) {
    switch (code) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return normalized ? std::max(as<std::int8_t>(raw) / 127, -1.0) : as<std::int8_t>(raw);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return as<std::uint8_t>(raw) / (normalized ? 255 : 1);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return normalized ? std::max(as<std::int16_t>(raw) / 32767, -1.0) : as<std::int16_t>(raw);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return as<std::uint16_t>(raw) / (normalized ? 65535 : 1);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return as<std::uint32_t>(raw);
    default: return as<float>(raw);
    }
}

/// `count` elements of `elementBytes` each, `stride` apart, all inside the view.
struct Elements {
    const unsigned char *data = nullptr;
    std::size_t stride = 0;
};

Elements elementsOf(const GltfSource &source, int view, std::size_t byteOffset, std::size_t count, std::size_t elementBytes, bool strided,
                    const std::string &where) {
    const std::span<const unsigned char> bytes = gltfBufferView(source, view, where + ".bufferView");
    const std::size_t given = strided ? source.model.bufferViews[static_cast<std::size_t>(view)].byteStride : 0;
    const std::size_t stride = given != 0 ? given : elementBytes;
    if (stride < elementBytes)
        failGltf(source.path, jsonPath("bufferViews", static_cast<std::size_t>(view)) + ".byteStride", std::to_string(stride),
                 "at least " + std::to_string(elementBytes) + ", the size of an element of " + where);
    // Counts and strides are below 2^31 (checkGltfJson), so the product fits.
    const bool fits = byteOffset <= bytes.size() && elementBytes <= bytes.size() - byteOffset &&
                      (count - 1) * stride <= bytes.size() - byteOffset - elementBytes;
    if (!fits)
        failGltf(source.path, where,
                 std::to_string(count) + " elements of " + std::to_string(elementBytes) + " bytes, " + std::to_string(stride) +
                     " apart from byte " + std::to_string(byteOffset),
                 "elements inside the " + std::to_string(bytes.size()) + " bytes of " +
                     jsonPath("bufferViews", static_cast<std::size_t>(view)));
    return {bytes.data() + byteOffset, stride};
}

/// Overwrites the elements that a sparse accessor lists.
template <class T>
void applySparse(const GltfSource &source, const tinygltf::Accessor &accessor, std::size_t components, const std::string &where,
                 std::vector<T> &values) {
    const auto count = static_cast<std::size_t>(accessor.sparse.count);
    if (count == 0 || count > accessor.count)
        failGltf(source.path, where + ".sparse.count", std::to_string(count),
                 "1 to " + std::to_string(accessor.count) + ", the accessor's count");
    const int indexCode = accessor.sparse.indices.componentType;
    const ComponentType &indexType = componentType(source, indexCode, where + ".sparse.indices.componentType");
    const bool isUnsigned = indexType.name.substr(0, 8) == "UNSIGNED";
    if (!isUnsigned) failGltf(source.path, where + ".sparse.indices.componentType", std::string(indexType.name), "an unsigned type");
    const ComponentType &type = componentType(source, accessor.componentType, where + ".componentType");
    const Elements indices =
        elementsOf(source, accessor.sparse.indices.bufferView, static_cast<std::size_t>(accessor.sparse.indices.byteOffset), count,
                   indexType.bytes, false, where + ".sparse.indices");
    const Elements replacing =
        elementsOf(source, accessor.sparse.values.bufferView, static_cast<std::size_t>(accessor.sparse.values.byteOffset), count,
                   type.bytes * components, false, where + ".sparse.values");
    double last = -1;
    for (std::size_t i = 0; i < count; ++i) {
        const double index = component(indices.data + i * indices.stride, indexCode, false);
        if (!(index > last) || !(index < static_cast<double>(accessor.count)))
            failGltf(source.path, where + ".sparse.indices",
                     "index " + std::to_string(static_cast<long long>(index)) + " at place " + std::to_string(i),
                     "increasing indices below " + std::to_string(accessor.count));
        last = index;
        for (std::size_t c = 0; c < components; ++c)
            values[static_cast<std::size_t>(index) * components + c] = static_cast<T>(
                component(replacing.data + i * replacing.stride + c * type.bytes, accessor.componentType, accessor.normalized));
    }
}

std::string_view typeName(int components) {
    switch (components) {
    case 1: return "SCALAR";
    case 2: return "VEC2";
    case 3: return "VEC3";
    case 4: return "VEC4";
    default: return "MAT4";
    }
}

int componentCount(const tinygltf::Accessor &accessor) {
    switch (accessor.type) {
    case TINYGLTF_TYPE_SCALAR: return 1;
    case TINYGLTF_TYPE_VEC2: return 2;
    case TINYGLTF_TYPE_VEC3: return 3;
    case TINYGLTF_TYPE_VEC4: return 4;
    case TINYGLTF_TYPE_MAT4: return 16;
    default: return 0;
    }
}

template <class T> std::vector<T> decode(const GltfSource &source, int index, int wanted, const std::string &use, bool integersOnly) {
    const Index checked = checkedIndex(source, use, index, source.model.accessors.size(), "accessors");
    const tinygltf::Accessor &accessor = source.model.accessors[checked];
    const std::string where = jsonPath("accessors", checked);
    if (componentCount(accessor) != wanted)
        failGltf(source.path, where + ".type", taut::quoted(source.json["accessors"][checked]["type"].get<std::string>()),
                 taut::quoted(typeName(wanted)) + " for " + use);
    const ComponentType &type = componentType(source, accessor.componentType, where + ".componentType");
    if (integersOnly && (type.name.substr(0, 8) != "UNSIGNED" || accessor.normalized))
        failGltf(source.path, where + ".componentType", std::string(type.name) + (accessor.normalized ? ", normalized" : ""),
                 "an unsigned integer type for " + use);
    if (wanted == 16 && type.code != TINYGLTF_COMPONENT_TYPE_FLOAT)
        failGltf(source.path, where + ".componentType", std::string(type.name), "FLOAT for " + use);
    const auto components = static_cast<std::size_t>(wanted);
    const std::size_t count = accessor.count;
    // Elements without a buffer view are zeros; more of them than the file has bytes is a trick.
    if (count == 0 || (accessor.bufferView < 0 && count > source.fileBytes))
        failGltf(source.path, where + ".count", std::to_string(count), "a count from 1 to what the file holds");
    Elements elements;
    if (accessor.bufferView >= 0)
        elements = elementsOf(source, accessor.bufferView, accessor.byteOffset, count, type.bytes * components, true, where);
    // Accessors may be shared by any number of users: the sum is what has to stay in proportion to the file.
    source.decodedBytes += count * components * sizeof(T);
    if (source.decodedBytes > source.decodedBudget())
        failGltf(source.path, where, "data shared so often that they take " + std::to_string(source.decodedBytes) + " bytes",
                 "at most " + std::to_string(source.decodedBudget()));
    std::vector<T> values(count * components, T(0));
    if (elements.data != nullptr)
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t c = 0; c < components; ++c)
                values[i * components + c] = static_cast<T>(
                    component(elements.data + i * elements.stride + c * type.bytes, accessor.componentType, accessor.normalized));
    if (accessor.sparse.isSparse) applySparse(source, accessor, components, where, values);
    return values;
}

} // namespace

std::span<const unsigned char> gltfBufferView(const GltfSource &source, int view, const std::string &where) {
    const Index checked = checkedIndex(source, where, view, source.model.bufferViews.size(), "bufferViews");
    const tinygltf::BufferView &found = source.model.bufferViews[checked];
    const std::string path = jsonPath("bufferViews", checked);
    const Index buffer = checkedIndex(source, path + ".buffer", found.buffer, source.buffers.size(), "buffers");
    const std::vector<unsigned char> &bytes = source.buffers[buffer];
    if (found.byteOffset > bytes.size() || found.byteLength > bytes.size() - found.byteOffset)
        failGltf(source.path, path, std::to_string(found.byteLength) + " bytes from byte " + std::to_string(found.byteOffset),
                 "a range inside the " + std::to_string(bytes.size()) + " bytes of " + jsonPath("buffers", buffer));
    return {bytes.data() + found.byteOffset, found.byteLength};
}

std::vector<float> accessorFloats(const GltfSource &source, int accessor, int components, const std::string &where) {
    std::vector<float> values = decode<float>(source, accessor, components, where, false);
    const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
    if (bad != values.end())
        failGltf(source.path, where, "a number that is not finite in element " + std::to_string((bad - values.begin()) / components),
                 "finite numbers");
    return values;
}

std::vector<Index> accessorIndices(const GltfSource &source, int accessor, int components, const std::string &where) {
    return decode<Index>(source, accessor, components, where, true);
}

} // namespace taut
