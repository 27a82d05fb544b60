#include "mesh_arrays.h"

#include "taut/base/error.h"
#include "taut/formats/read_formats.h"

namespace taut::python {

namespace {

/// Values of corners with each value that a point has once, so that corners without a seam between them share it, as in a file.
template <class V> void shareValues(std::span<const V> given, const Mesh &mesh, std::vector<V> &values, std::vector<Index> &corners) {
    std::vector<Index> first(mesh.positions.size(), kNone); // the values of a point, chained
    std::vector<Index> next;
    corners.resize(given.size());
    for (std::size_t c = 0; c < given.size(); ++c) {
        const Index point = mesh.cornerPositions[c];
        if (point >= first.size()) continue; // check() says so
        Index at = first[point];
        while (at != kNone && values[at] != given[c]) at = next[at];
        if (at == kNone) {
            at = static_cast<Index>(values.size());
            values.push_back(given[c]);
            next.push_back(first[point]);
            first[point] = at;
        }
        corners[c] = at;
    }
}

/// Values at points or at corners, as a mesh has them.
template <class V>
void setAttribute(const std::string &what, const Array<float> &rows, const Mesh &mesh, std::vector<V> &values,
                  std::vector<Index> &corners) {
    const std::span<const V> given = rowsOf<V>(rows);
    if (given.size() == mesh.positions.size()) {
        values.assign(given.begin(), given.end());
        corners = mesh.cornerPositions;
    } else if (given.size() == mesh.cornerCount()) {
        shareValues(given, mesh, values, corners);
    } else {
        failInput({what}, std::to_string(given.size()) + " rows",
                  "one for each of " + std::to_string(mesh.positions.size()) + " points or of " + std::to_string(mesh.cornerCount()) +
                      " corners");
    }
}

} // namespace

std::shared_ptr<const Mesh> meshOf(const std::string &name, const MeshArrays &arrays) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = name;
    const std::span<const Vec3> rest = rowsOf<Vec3>(arrays.rest);
    mesh->positions.assign(rest.begin(), rest.end());
    const auto starts = valuesOf(arrays.starts);
    const auto corners = valuesOf(arrays.corners);
    mesh->faceOffsets.assign(starts.begin(), starts.end());
    mesh->faceOffsets.push_back(static_cast<Index>(corners.size()));
    mesh->cornerPositions.assign(corners.begin(), corners.end());
    if (arrays.uvs) setAttribute("uv", *arrays.uvs, *mesh, mesh->uvs, mesh->cornerUvs);
    if (arrays.normals) setAttribute("normals", *arrays.normals, *mesh, mesh->normals, mesh->cornerNormals);
    if (arrays.faceMaterials) {
        const auto slots = valuesOf(*arrays.faceMaterials);
        mesh->faceMaterials.assign(slots.begin(), slots.end());
        mesh->materialNames = arrays.materialNames;
        for (std::size_t f = 0; f < slots.size(); ++f)
            if (slots[f] >= arrays.materialNames.size())
                failInput({"face_materials[" + std::to_string(f) + "]"}, std::to_string(slots[f]),
                          "an index of one of " + std::to_string(arrays.materialNames.size()) + " material_names");
    }
    normaliseNormals(*mesh); // as those of a file
    return mesh;
}

} // namespace taut::python
