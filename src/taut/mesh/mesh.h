#pragma once
/// The control mesh: polygons stay polygons, UVs, colours, normals and tangents are kept per corner.
/// Plain data, indices into arrays, no pointers. Positions are in the object's own space, in metres.

#include "taut/base/vec.h"

#include <string>
#include <vector>

namespace taut {

/// One morph (shape key, blend shape): a displacement per position vertex, object space, metres, and what it adds to normals.
struct MorphTarget {
    std::string name;
    std::vector<Vec3> positionDeltas; ///< [positions]
    std::vector<Vec3> normalDeltas{}; ///< [normals] object space; empty: its normals follow from its positions
};

/// Linear blend skinning weights, compressed rows: the influences of position vertex v are [offsets[v], offsets[v+1]).
/// Weights of a vertex sum to 1; a vertex without influences follows no joint and is reported by the reader.
struct SkinWeights {
    std::vector<Index> offsets; ///< [positions + 1]; empty: the mesh is not skinned
    std::vector<Index> joints;  ///< index into Skin::joints
    std::vector<float> weights;
    [[nodiscard]] bool empty() const { return offsets.empty(); }
};

/// Sharpness of subdivision surfaces, in levels: 0 is smooth, a feature of sharpness s is kept sharp for s levels; from
/// kInfinitelySharp on for ever (OpenSubdiv's convention).
inline constexpr float kInfinitelySharp = 10;
struct EdgeCrease {
    Index a = 0, b = 0; ///< positions at the edge's ends
    float sharpness = 0;
};
struct SharpCorner {
    Index position = 0;
    float sharpness = 0;
};

/// A polygon mesh. Face f has the corners [faceOffsets[f], faceOffsets[f+1]), counter-clockwise seen from outside.
/// A corner attribute that the file lacks has an empty index array. An index may be kNone where single corners lack it.
struct Mesh {
    std::string name;
    std::vector<Vec3> positions;
    std::vector<Index> faceOffsets{0};
    std::vector<Index> cornerPositions; ///< [corners], into positions

    std::vector<Vec3> normals; ///< unit, object space
    std::vector<Index> cornerNormals;
    std::vector<Vec2> uvs; ///< v up: (0, 0) is the lower left of the texture
    std::vector<Index> cornerUvs;
    std::vector<Vec2> uvs1;   ///< [uvs] a second set at the same indices (glTF's TEXCOORD_1); empty: none
    std::vector<Vec4> colors; ///< linear RGBA that multiplies the materials' colour and opacity
    std::vector<Index> cornerColors;
    std::vector<Vec4> tangents; ///< glTF TANGENT: unit xyz in object space, w = handedness (bitangent = w * cross(n, t))
    std::vector<Index> cornerTangents;
    /// Gloss that `taut export` stored: a, b, d of M at each tangent, in the frame (tangent, cross(normal, tangent), normal).
    /// It takes the place of a material's alpha and rotation. [tangents]; empty: none.
    std::vector<Vec3> storedM;

    std::vector<Index> faceMaterials;       ///< [faces], into materialNames; empty: material slot 0
    std::vector<std::string> materialNames; ///< as the file calls them; may be empty

    std::vector<MorphTarget> morphs;
    SkinWeights skin;

    std::vector<EdgeCrease> creases; ///< used by subdivide() alone, as are corners
    std::vector<SharpCorner> corners;

    [[nodiscard]] std::size_t faceCount() const { return faceOffsets.size() - 1; }
    [[nodiscard]] std::size_t cornerCount() const { return cornerPositions.size(); }
};

/// Gives back what the arrays hold beyond their size.
void shrinkToFit(Mesh &mesh);

/// Smallest axis-aligned box of finite points; lower > upper where there are none.
struct Bounds {
    Vec3 lower{kInfinity};
    Vec3 upper{-kInfinity};
    void add(const Vec3 &p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    [[nodiscard]] bool empty() const { return !(lower.x <= upper.x); }
    [[nodiscard]] Vec3 centre() const { return 0.5F * (lower + upper); }
    [[nodiscard]] float diagonal() const { return empty() ? 0.0F : glm::length(upper - lower); }
};

Bounds boundsOf(const std::vector<Vec3> &points);

} // namespace taut
