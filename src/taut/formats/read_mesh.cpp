#include "taut/formats/read_mesh.h"

#include "taut/base/file_bytes.h"
#include "taut/formats/read_formats.h"

#include <algorithm>
#include <array>
#include <filesystem>

namespace taut {

namespace {

constexpr std::array<std::string_view, 4> kMeshExtensions{"obj", "ply", "off", "stl"};

/// Keeps every count within Index: a corner takes at least one byte in every format.
constexpr std::size_t kLargestFile = 0xfffffffeU;

Mesh readByExtension(const std::string &path, Warnings &warnings) {
    const std::string extension = lowerExtension(path);
    if (!isMeshPath(path)) failUnknownName({path, 0, 0, -1}, extension, kMeshExtensions);
    const std::string bytes = readFileBytes(path);
    if (bytes.size() > kLargestFile) throw InputError(path + ": found " + std::to_string(bytes.size()) + " bytes, expected at most 4 GiB");
    if (const std::string_view mark = std::string_view(bytes).substr(0, 2);
        extension != "stl" && (mark == "\xff\xfe" || mark == "\xfe\xff"))
        failInput({path, 1, 1, -1}, "a text in UTF-16", "UTF-8");
    if (extension == "ply") return readPly(bytes, path, warnings);
    if (extension == "off") return readOff(bytes, path, warnings);
    if (extension == "stl") return readStl(bytes, path, warnings);
    return readObj(bytes, path, warnings);
}

bool isFiniteValue(const Vec3 &v) {
    return isFinite(v);
}
bool isFiniteValue(const Vec2 &v) {
    return std::isfinite(v.x) && std::isfinite(v.y);
}

/// `values` at `corners`; `name` says what they are, of many.
template <class V>
void dropNotFinite(std::vector<V> &values, std::vector<Index> &corners, const std::string &name, const std::string &what,
                   Warnings &warnings) {
    std::size_t bad = 0;
    for (const V &value : values) bad += isFiniteValue(value) ? 0 : 1;
    if (bad == 0) return;
    std::size_t used = 0;
    for (Index &corner : corners) {
        if (corner == kNone || isFiniteValue(values[corner])) continue;
        corner = kNone;
        ++used;
    }
    warnings.add(what + ": " + std::to_string(bad) + " of " + std::to_string(values.size()) + " " + name +
                 " are not finite and count as missing, at " + std::to_string(used) + " of " + std::to_string(corners.size()) + " corners");
    for (V &value : values)
        if (!isFiniteValue(value)) value = V(0);
    if (std::any_of(corners.begin(), corners.end(), [](Index corner) { return corner != kNone; })) return;
    values.clear();
    corners.clear();
}

bool hasThreeDistinct(const Mesh &mesh, std::size_t face) {
    const auto begin = mesh.cornerPositions.begin() + mesh.faceOffsets[face];
    const auto end = mesh.cornerPositions.begin() + mesh.faceOffsets[face + 1];
    const auto second = std::find_if(begin, end, [&](Index v) { return v != *begin; });
    if (second == end) return false;
    return std::any_of(second, end, [&](Index v) { return v != *begin && v != *second; });
}

} // namespace

void checkCornerCount(std::int64_t corners, const Location &where) {
    if (corners < 3) failInput(where, "a face of " + std::to_string(corners) + " corners", "at least 3 corners");
    if (corners > 0x7fffffff)
        failInput(where, "a face of " + std::to_string(corners) + " corners", "fewer corners than the file has bytes");
}

Index checkedVertex(std::int64_t index, std::size_t vertices, const Location &where) {
    if (index < 0 || index >= static_cast<std::int64_t>(vertices))
        failInput(where, "vertex index " + std::to_string(index),
                  vertices == 0 ? "none, for the file has no vertex" : "0 to " + std::to_string(vertices - 1));
    return static_cast<Index>(index);
}

void checkCount(std::int64_t count, std::size_t bytesEach, std::size_t bytesLeft, const std::string &what, const Location &where) {
    const std::size_t most = bytesLeft / bytesEach;
    if (count < 0 || static_cast<std::uint64_t>(count) > most)
        failInput(where, std::to_string(count) + " " + what,
                  "a count from 0 to " + std::to_string(most) + ", which is what fits into the rest of the file");
}

void dropDegenerateFaces(Mesh &mesh, const std::string &what, Warnings &warnings) {
    std::size_t keptFaces = 0;
    std::size_t keptCorners = 0;
    const std::size_t faces = mesh.faceCount();
    const std::array cornerArrays{&mesh.cornerPositions, &mesh.cornerNormals, &mesh.cornerUvs, &mesh.cornerTangents, &mesh.cornerColors};
    for (std::size_t f = 0; f < faces; ++f) {
        if (!hasThreeDistinct(mesh, f)) continue;
        const std::size_t begin = mesh.faceOffsets[f];
        const std::size_t end = mesh.faceOffsets[f + 1];
        for (std::vector<Index> *corners : cornerArrays)
            if (!corners->empty()) std::copy(corners->begin() + begin, corners->begin() + end, corners->begin() + keptCorners);
        keptCorners += end - begin;
        if (!mesh.faceMaterials.empty()) mesh.faceMaterials[keptFaces] = mesh.faceMaterials[f];
        // In place: keptFaces <= f, so no offset that is still to be read is overwritten with another value.
        mesh.faceOffsets[keptFaces + 1] = static_cast<Index>(keptCorners);
        ++keptFaces;
    }
    if (keptFaces == faces) return;
    mesh.faceOffsets.resize(keptFaces + 1);
    for (std::vector<Index> *corners : cornerArrays)
        if (!corners->empty()) corners->resize(keptCorners);
    if (!mesh.faceMaterials.empty()) mesh.faceMaterials.resize(keptFaces);
    warnings.add(what + ": dropped " + std::to_string(faces - keptFaces) + " of " + std::to_string(faces) +
                 " faces, which have fewer than three distinct corners");
}

void dropNotFinite(Mesh &mesh, const std::string &what, Warnings &warnings) {
    dropNotFinite(mesh.normals, mesh.cornerNormals, "normals", what, warnings);
    dropNotFinite(mesh.uvs, mesh.cornerUvs, "texture coordinates", what, warnings);
}

void normaliseNormals(Mesh &mesh) {
    for (Vec3 &n : mesh.normals) {
        // In double: the square of a float may leave float's range.
        const DVec3 wide(n);
        const double length = glm::length(wide);
        n = length > 0 ? Vec3(wide / length) : Vec3(0);
    }
    for (Index &corner : mesh.cornerNormals)
        if (corner != kNone && mesh.normals[corner] == Vec3(0)) corner = kNone;
}

bool isMeshPath(const std::string &path) {
    return std::find(kMeshExtensions.begin(), kMeshExtensions.end(), lowerExtension(path)) != kMeshExtensions.end();
}

Mesh readMesh(const std::string &path, Warnings &warnings) {
    Mesh mesh = readByExtension(path, warnings);
    mesh.name = std::filesystem::path(path).stem().string();
    dropDegenerateFaces(mesh, path, warnings);
    dropNotFinite(mesh, path, warnings);
    normaliseNormals(mesh);
    shrinkToFit(mesh);
    if (mesh.faceCount() == 0) throw InputError(path + ": found no face, expected at least one face with three distinct corners");
    return mesh;
}

std::vector<Vec3> readSequencePositions(const std::string &path, const Mesh &first) {
    Warnings said; // of the same faces, once a frame: the first frame has said it
    Mesh mesh = readMesh(path, said);
    const auto fail = [&](std::size_t found, std::size_t expected, const std::string &what) {
        throw InputError(path + ": found " + std::to_string(found) + " " + what + ", expected " + std::to_string(expected) +
                         " as in the first mesh of the sequence");
    };
    if (mesh.positions.size() != first.positions.size()) fail(mesh.positions.size(), first.positions.size(), "positions");
    if (mesh.faceCount() != first.faceCount()) fail(mesh.faceCount(), first.faceCount(), "faces");
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const bool same =
            mesh.faceOffsets[f + 1] == first.faceOffsets[f + 1] &&
            std::equal(mesh.cornerPositions.begin() + mesh.faceOffsets[f], mesh.cornerPositions.begin() + mesh.faceOffsets[f + 1],
                       first.cornerPositions.begin() + first.faceOffsets[f]);
        if (!same)
            throw InputError(path + ": found other corners in face " + std::to_string(f) +
                             " (counted from 0), expected those of the first mesh of the sequence");
    }
    return std::move(mesh.positions);
}

} // namespace taut
