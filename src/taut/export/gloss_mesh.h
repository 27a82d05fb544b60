#pragma once
/// A deformed mesh with its gloss at every vertex, as `taut export` writes it: arrays, and a table that names them for the writers.
///
/// Vectors are in the space of `positions` (world space unless asked otherwise: right-handed, z up, metres). M, phi and the
/// signs of angles live in the frame (tangent, bitangent = cross(normal, tangent), normal) of each vertex.

#include "taut/mesh/mesh.h"
#include "taut/microsurface/conventions.h"

#include <span>

namespace taut {

/// What a file format that knows materials is told; M in the vertices says the rest.
struct GlossMaterial {
    std::string name;
    Vec3 color{1}; ///< F0 of a metal, albedo of others; linear
    bool metal = false;
    float ior = 1.5F;
};

struct GlossMesh {
    std::string name;

    // What no frame changes.
    std::vector<Index3> triangles;        ///< counter-clockwise from outside
    std::vector<Index> triangleMaterials; ///< [triangles], into materials
    std::vector<GlossMaterial> materials;
    std::vector<Vec2> uvs;           ///< v up; empty without UVs
    std::vector<Vec3> restPositions; ///< object space, of the undeformed mesh

    // Of one frame.
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;          ///< unit, outward
    std::vector<Vec4> tangents;         ///< unit, the direction of ds; w: +1 or -1, the side of cross(normal, tangent) that dt is on
    std::vector<Vec3> ds, dt;           ///< images of the rest tangent frame: F t0, F b0
    std::vector<Vec3> m;                ///< a, b, d: the 2x2 block [a b; 0 d] of M
    std::vector<Vec2> lean;             ///< p, q: the third column of M
    std::vector<Vec3> stretch;          ///< largest and smallest stretch, area factor det A
    std::vector<Vec3> stretchDirection; ///< unit, on the deformed surface, along the largest stretch
    std::vector<Vec3> alpha;            ///< alphaMax, alphaMin, phi (radians from tangent to bitangent)
    std::vector<Vec3> alphaDirection;   ///< unit, the rougher axis: the direction of alphaMax
    const ConventionInfo *convention = nullptr;
    std::vector<Vec3> conventionValues; ///< roughness, anisotropy, rotation of `convention`; empty without one

    [[nodiscard]] std::size_t vertexCount() const { return positions.size(); }
};

/// One named attribute of the vertices.
struct VertexAttribute {
    std::string name;       ///< "ds"; a convention's: "blender_roughness"
    int width = 1;          ///< floats: 1, 2 or 3
    std::size_t stride = 1; ///< floats from one vertex to the next
    const float *data = nullptr;
};

/// Everything but positions, normals and uvs, in the order in which files hold it:
/// tangent (3), tangent_sign, Pref (3), M (3: a, b, d), M_p, M_q, ds (3), dt (3), stretch_max, stretch_min, det, stretch_dir (3),
/// alpha_max, alpha_min, phi, alpha_dir (3), then the convention's. Views into `mesh`.
std::vector<VertexAttribute> vertexAttributes(const GlossMesh &mesh);

/// The name of a component in a table of scalars: "ds_x", "phi_x". Mitsuba reads groups of one or three such properties as
/// vertex_ds and vertex_phi; Blender reads each as an attribute of its own.
std::string componentName(const VertexAttribute &attribute, int component);

/// A column of scalars over the vertices, for formats that interleave.
struct VertexColumn {
    std::string name;
    std::size_t stride = 1;
    const float *data = nullptr;
};
/// x y z nx ny nz, s t where there are uvs, then the components of vertexAttributes().
std::vector<VertexColumn> vertexColumns(const GlossMesh &mesh);

/// KHR_materials_anisotropy has one set of numbers a material: the mean of its vertices' slope tensors (M M^T)^-1.
struct MeanGloss {
    EquivalentAlpha alpha{0.1F, 0.1F, 0}; ///< phi on the side of tangent.w
    float spread = 0;                     ///< largest difference of a vertex from the mean, relative to alphaMax^2 of the mean
};
/// By material of `mesh.materials`.
std::vector<MeanGloss> meanGloss(const GlossMesh &mesh);

} // namespace taut
