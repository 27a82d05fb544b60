#include "taut/scene/check_parts.h"

namespace taut {

namespace {

bool isBeyond(Index index, std::size_t count) {
    return index >= count;
}

/// Offsets of rows in an array of `elements`: from 0, never falling, to its end.
void checkOffsets(const Part &part, std::string_view member, const std::vector<Index> &offsets, std::size_t elements) {
    if (offsets.empty() || offsets.front() != 0) part.fail(member, offsets.empty() ? "none" : "another first offset", "0 at the front");
    checkEach(part, member, offsets.size() - 1, "a fall", "offsets that never fall",
              [&](std::size_t i) { return offsets[i + 1] < offsets[i]; });
    if (offsets.back() != elements) part.fail(member, std::to_string(offsets.back()) + " at the end", std::to_string(elements));
}

void checkPoints(const Part &part, std::string_view member, const std::vector<Vec3> &points) {
    checkEach(part, member, points.size(), "a number that is not finite", "finite numbers",
              [&](std::size_t i) { return !isFinite(points[i]); });
}

/// The indices of a corner attribute, which may be absent, as a whole or for single corners.
void checkAttribute(const Part &part, std::string_view member, const std::vector<Index> &corners, std::size_t values, const Mesh &mesh) {
    if (corners.empty()) return;
    checkCount(part, member, corners.size(), mesh.cornerCount());
    checkEach(part, member, corners.size(), "an index beyond the " + std::to_string(values) + " values", "an index of one, or kNone",
              [&](std::size_t c) { return corners[c] != kNone && isBeyond(corners[c], values); });
}

void checkFaces(const Part &part, const Mesh &mesh) {
    if (mesh.positions.empty()) part.fail("mesh.positions", "none", "at least three");
    checkPoints(part, "mesh.positions", mesh.positions);
    if (mesh.faceOffsets.size() < 2) part.fail("mesh.faceOffsets", "no face", "at least one");
    checkOffsets(part, "mesh.faceOffsets", mesh.faceOffsets, mesh.cornerCount());
    checkEach(part, "mesh.faceOffsets", mesh.faceCount(), "a face of fewer than three corners", "at least three",
              [&](std::size_t f) { return mesh.faceOffsets[f + 1] - mesh.faceOffsets[f] < 3; });
    checkEach(part, "mesh.cornerPositions", mesh.cornerCount(), "an index beyond the positions", "an index of one",
              [&](std::size_t c) { return isBeyond(mesh.cornerPositions[c], mesh.positions.size()); });
    if (!mesh.faceMaterials.empty()) checkCount(part, "mesh.faceMaterials", mesh.faceMaterials.size(), mesh.faceCount());
}

void checkSkin(const Part &part, const SkinWeights &skin, std::size_t positions) {
    if (skin.empty()) return;
    checkCount(part, "mesh.skin.offsets", skin.offsets.size(), positions + 1);
    checkOffsets(part, "mesh.skin.offsets", skin.offsets, skin.joints.size());
    checkCount(part, "mesh.skin.weights", skin.weights.size(), skin.joints.size());
    checkEach(part, "mesh.skin.weights", skin.weights.size(), "a number that is not finite", "finite numbers",
              [&](std::size_t i) { return !std::isfinite(skin.weights[i]); });
}

void checkFeatures(const Part &part, const Mesh &mesh) {
    const std::size_t positions = mesh.positions.size();
    checkEach(part, "mesh.creases", mesh.creases.size(), "an edge beyond the positions, or no sharpness", "a sharp edge",
              [&](std::size_t i) {
                  const EdgeCrease &crease = mesh.creases[i];
                  return isBeyond(crease.a, positions) || isBeyond(crease.b, positions) || !(crease.sharpness >= 0);
              });
    checkEach(part, "mesh.corners", mesh.corners.size(), "a corner beyond the positions, or no sharpness", "a sharp corner",
              [&](std::size_t i) { return isBeyond(mesh.corners[i].position, positions) || !(mesh.corners[i].sharpness >= 0); });
}

} // namespace

void checkMesh(const Part &part, const Mesh &mesh) {
    checkFaces(part, mesh);
    checkAttribute(part, "mesh.cornerNormals", mesh.cornerNormals, mesh.normals.size(), mesh);
    checkAttribute(part, "mesh.cornerUvs", mesh.cornerUvs, mesh.uvs.size(), mesh);
    checkAttribute(part, "mesh.cornerTangents", mesh.cornerTangents, mesh.tangents.size(), mesh);
    checkAttribute(part, "mesh.cornerColors", mesh.cornerColors, mesh.colors.size(), mesh);
    if (!mesh.uvs1.empty()) checkCount(part, "mesh.uvs1", mesh.uvs1.size(), mesh.uvs.size());
    checkEach(part, "mesh.colors", mesh.colors.size(), "a number that is not finite", "finite numbers",
              [&](std::size_t i) { return !isFinite(Vec3(mesh.colors[i])) || !std::isfinite(mesh.colors[i].w); });
    checkPoints(part, "mesh.normals", mesh.normals);
    checkEach(part, "mesh.tangents", mesh.tangents.size(), "a number that is not finite", "finite numbers",
              [&](std::size_t i) { return !isFinite(Vec3(mesh.tangents[i])); });
    if (!mesh.storedM.empty()) checkCount(part, "mesh.storedM", mesh.storedM.size(), mesh.tangents.size());
    checkEach(part, "mesh.storedM", mesh.storedM.size(), "a diagonal that is not above 0", "numbers above 0",
              [&](std::size_t i) { return !isFinite(mesh.storedM[i]) || !(mesh.storedM[i].x > 0 && mesh.storedM[i].z > 0); });
    for (const MorphTarget &morph : mesh.morphs) {
        checkCount(part, "mesh.morphs", morph.positionDeltas.size(), mesh.positions.size());
        checkPoints(part, "mesh.morphs", morph.positionDeltas);
        if (morph.normalDeltas.empty()) continue;
        checkCount(part, "mesh.morphs", morph.normalDeltas.size(), mesh.normals.size());
        checkPoints(part, "mesh.morphs", morph.normalDeltas);
    }
    checkSkin(part, mesh.skin, mesh.positions.size());
    checkFeatures(part, mesh);
}

} // namespace taut
