#include "taut/formats/write_mesh.h"

#include "taut/base/file_bytes.h"

#include <cstdio>

namespace taut {

namespace {

/// "keyword x y [z]\n" with nine digits.
template <class V> void appendVector(std::string &out, const char *keyword, const V &v) {
    out += keyword;
    for (int i = 0; i < V::length(); ++i) {
        char number[32];
        std::snprintf(number, sizeof number, " %.9g", static_cast<double>(v[i]));
        out += number;
    }
    out += '\n';
}

Index cornerIndex(const std::vector<Index> &corners, std::size_t corner) {
    return corners.empty() ? kNone : corners[corner];
}

/// v, v/t, v//n or v/t/n, counted from 1.
void appendCorner(std::string &out, const Mesh &mesh, std::size_t corner) {
    const Index uv = cornerIndex(mesh.cornerUvs, corner);
    const Index normal = cornerIndex(mesh.cornerNormals, corner);
    out += ' ' + std::to_string(std::size_t{mesh.cornerPositions[corner]} + 1);
    if (uv != kNone || normal != kNone) out += '/';
    if (uv != kNone) out += std::to_string(std::size_t{uv} + 1);
    if (normal != kNone) out += '/' + std::to_string(std::size_t{normal} + 1);
}

} // namespace

void writeObj(const Mesh &mesh, const std::string &path) {
    std::string out;
    for (const Vec3 &p : mesh.positions) appendVector(out, "v", p);
    for (const Vec2 &t : mesh.uvs) appendVector(out, "vt", t);
    for (const Vec3 &n : mesh.normals) appendVector(out, "vn", n);
    Index material = kNone;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        if (!mesh.faceMaterials.empty() && mesh.faceMaterials[f] != material && mesh.faceMaterials[f] < mesh.materialNames.size()) {
            material = mesh.faceMaterials[f];
            out += "usemtl " + mesh.materialNames[material] + '\n';
        }
        out += 'f';
        for (std::size_t corner = mesh.faceOffsets[f]; corner < mesh.faceOffsets[f + 1]; ++corner) appendCorner(out, mesh, corner);
        out += '\n';
    }
    writeFileWhole(path, out);
}

} // namespace taut
