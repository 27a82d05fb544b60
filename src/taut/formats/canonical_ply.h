#pragma once
/// Writes the dialect of PLY that OpenMesh reads right: binary little-endian, float vertices, int lists.

#include "taut/base/error.h"
#include "taut/formats/mesh_guard.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace taut {

static_assert(std::endian::native == std::endian::little, "binary meshes are written in the machine's order");

template <class T> void appendBinary(std::string &out, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    out.append(raw, sizeof(T));
}

class CanonicalPly {
  public:
    bool hasNormals = false;
    bool hasUvs = false;

    /// All of one vertex: position, then the normal and the uv that the file has.
    template <std::size_t N> void addVertex(const float (&values)[N]) {
        static_assert(N >= 8);
        for (int i = 0; i < 8; ++i)
            if (i < 3 || (i < 6 ? hasNormals : hasUvs)) appendBinary(vertices_, values[i]);
        ++vertexCount_;
    }
    void beginFace(std::int32_t corners) {
        appendBinary(faces_, corners);
        ++faceCount_;
    }
    void addCorner(std::int32_t position) { appendBinary(faces_, position); }

    [[nodiscard]] CheckedFile finish() const {
        std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertexCount_);
        out += "\nproperty float x\nproperty float y\nproperty float z\n";
        if (hasNormals) out += "property float nx\nproperty float ny\nproperty float nz\n";
        if (hasUvs) out += "property float s\nproperty float t\n";
        out += "element face " + std::to_string(faceCount_) + "\nproperty list int int vertex_indices\nend_header\n";
        return {out + vertices_ + faces_, faceCount_, hasNormals, hasUvs};
    }

  private:
    std::string vertices_;
    std::string faces_;
    std::size_t vertexCount_ = 0;
    std::size_t faceCount_ = 0;
};

/// "found a face of 2 corners, expected at least 3" and the like, shared by PLY and OFF.
inline void checkCornerCount(std::int64_t corners, const Location &where) {
    if (corners < 3) failInput(where, "a face of " + std::to_string(corners) + " corners", "at least 3 corners");
    if (corners > 0x7fffffff)
        failInput(where, "a face of " + std::to_string(corners) + " corners", "fewer corners than the file has bytes");
}
inline void checkVertexIndex(std::int64_t index, std::size_t vertices, const Location &where) {
    if (index < 0 || index >= static_cast<std::int64_t>(vertices))
        failInput(where, "vertex index " + std::to_string(index),
                  vertices == 0 ? "none, for the file has no vertex" : "0 to " + std::to_string(vertices - 1));
}
/// Fails unless `count` elements of at least `bytesEach` bytes fit into `bytesLeft`.
inline void checkCount(std::int64_t count, std::size_t bytesEach, std::size_t bytesLeft, const std::string &what, const Location &where) {
    const std::size_t most = bytesLeft / bytesEach;
    if (count < 0 || static_cast<std::uint64_t>(count) > most)
        failInput(where, std::to_string(count) + " " + what,
                  "a count from 0 to " + std::to_string(most) + ", which is what fits into the rest of the file");
}

} // namespace taut
