#pragma once
/// The surface of a mesh as it is rendered: triangles, render vertices with their rest tangent frame, and what is needed to
/// evaluate the surface gradient (ds, dt) at any time. Built once a mesh; per-frame work is in surface_motion.h.
///
/// Three kinds of vertices:
///   position        a point of the control mesh
///   surface vertex  a position with one rest normal: all faces that meet there smoothly. Gradients are evaluated here, so
///                   they do not jump at UV seams; hard edges have a surface vertex on either side.
///   render vertex   a surface vertex with one UV, one colour and one tangent frame; triangles index these.
///
/// Rest space: object space under the linear part of the object's rest placement (`restFromObject`): what deformation is
/// measured against (docs/pipeline.md, "The rest state").
///
/// Policies, by name, for what has no right answer:
///   TangentFromUv        t0 = dP/du made perpendicular to the rest normal, b0 = +-cross(n, t0), the sign of the UV map: under
///                        mirrored UVs b0 turns over, and so does the sense of a material's rotation. The UV winding splits
///                        render vertices, so a mirror seam is sharp.
///                        Across a seam where the map runs on (within 20 degrees) both sides share one tangent.
///   TangentOfMaps        under a map of normals (mapTangents) t0 is what the map was baked for: the file's own, else MikkTSpace's.
///   SmoothFieldNoUv      without UVs (or where the UV map is degenerate) t0 comes from smoothTangentFromNormal: smooth over the
///                        sphere of normals but for one point (n = -z).
///   NormalsFollowWinding a file's normals that point to the inner side of their faces are turned (mesh/winding.h).
///   SkipDegenerateFace   a face without area has no say in gradients and normals; it is still rendered by its neighbours' data.
///                        A sliver, whose height is lost in the rounding of its points, has as little.
///   RestAtLoneVertex     a surface vertex with only degenerate faces and slivers keeps A = identity.

#include "taut/base/frame.h"
#include "taut/mesh/subdivide.h"

#include <array>
#include <span>
#include <vector>

namespace taut {

/// One face at a vertex, as the triangle of the vertex and its neighbours there: the edges a and b to the neighbours' deformed
/// points give the images of e1 and e2, a x + b y and a z + b w.
struct RingFace {
    std::array<Index, 2> positions; ///< neighbours: the next, the previous one around the face
    Vec4 fromEdges;
    float share; ///< of the vertex; they sum to 1
};

struct Surface {
    // Render vertices.
    std::vector<Index3> triangles;         ///< render vertices, counter-clockwise from outside
    std::vector<Index> triangleSlots;      ///< material slot; empty: all 0
    std::vector<Index> vertexSurface;      ///< [render vertices] -> surface vertex
    std::vector<Vec2> uvs;                 ///< [render vertices]; empty without UVs
    std::vector<Vec2> uvs1;                ///< [render vertices] the second set; empty: none
    std::vector<Vec4> colors;              ///< [render vertices] linear RGBA, 1 where a corner has none; empty without colours
    std::vector<Index> vertexTangents;     ///< [render vertices] -> tangent of the mesh; empty where it has none
    std::vector<Vec4> tangentCoefficients; ///< [render vertices]: t0 = x e1 + y e2, b0 = z e1 + w e2

    // Surface vertices.
    std::vector<Index> surfacePosition; ///< -> position
    std::vector<Vec3> normals;          ///< rest space, unit
    std::vector<Index> morphedNormals;  ///< -> normal of the mesh, kNone without one; empty where no morph says what normals do
    Mat3 restFromObject{1};

    // Gradient from positions: dx/de1 = sum weights.x * x[position], dx/de2 = sum weights.y * x[position]; exact in the tangent
    // plane at rest. `slope` is what is left along the rest normal there. Rows of a fit refer to positions; rows of a limit
    // surface to the points of its cage, and give the vertex's position as well: x = sum points * x[position].
    std::vector<Index> stencilOffsets; ///< [surface vertices + 1]
    std::vector<Index> stencilPositions;
    std::vector<Vec2> stencilWeights;
    std::vector<float> stencilPoints; ///< empty but for a limit surface
    std::vector<Vec2> slope;          ///< [surface vertices]; infinite at lone vertices of a limit surface

    // The faces around a vertex, each laid into its rest tangent plane by a rotation: how far each is stretched, whatever folds
    // between them, which a fit over all of them can't tell (surface_motion.cpp).
    std::vector<Index> ringOffsets; ///< [surface vertices + 1]; empty on a limit surface
    std::vector<RingFace> ringFaces;
    std::vector<float> ringTilts; ///< [surface vertices] mean of 1 - cos between the faces' normals and the vertex's

    // Derivatives of skin weights along e1 and e2 by the same fit: for joint k of surface vertex v.
    std::vector<Index> weightGradientOffsets; ///< [surface vertices + 1]; empty without a skin
    std::vector<Index> weightGradientJoints;
    std::vector<Vec2> weightGradients;
    std::vector<unsigned char> hinges; ///< [surface vertices] where the weights jump (skin_hinges.h); empty where they do nowhere

    // What the policies did, for `taut info`.
    Index degenerateFaces = 0;
    Index loneVertices = 0;
    Index mirroredVertices = 0;
    Index fallbackTangents = 0; ///< render vertices under SmoothFieldNoUv
    Index turnedVertices = 0;   ///< render vertices whose normal NormalsFollowWinding turned

    [[nodiscard]] std::size_t vertexCount() const { return vertexSurface.size(); }
    /// (e1, e2, normal) of a surface vertex, rest space: orthonormal, right-handed. A function of the normal, so that it needs no memory.
    [[nodiscard]] Frame frameAt(std::size_t surfaceVertex) const { return quickFrameFromNormal(normals[surfaceVertex]); }
    /// Whether the stencils are those of a limit surface, on the points of a cage.
    [[nodiscard]] bool onLimit() const { return !stencilPoints.empty(); }
};

/// Means of the gradients of the faces around a vertex, weighted by their area or their angle there, or the linear map that
/// fits the vertex's neighbours best.
enum class GradientFit { Area, Angle, LeastSquares };

struct SurfaceOptions {
    Mat3 restFromObject{1};
    bool smooth = true;       ///< where the file has no normals: smooth, else faceted
    bool weld = false;        ///< join positions that coincide and move alike (glTF splits positions at seams)
    bool mapTangents = false; ///< where the file has none: tangents as maps of normals are baked for (mesh/tangent_space.h)
    GradientFit fit = GradientFit::Area;
    const Subdivision *limit = nullptr; ///< the mesh is limit->mesh: exact limit derivatives where it has them, else the fit
    std::span<const Vec3> cage;         ///< with `limit`: the cage's positions, object space
};

Surface buildSurface(const Mesh &mesh, const SurfaceOptions &options);

/// Gives memory back: what arrays hold beyond their size, and with `fits` false stencils and slopes. Gradients then can be carried
/// along but no longer be fitted, so control points must stay at rest.
void compact(Surface &surface, bool fits);

} // namespace taut
