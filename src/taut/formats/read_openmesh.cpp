/// PLY, OFF and STL through OpenMesh's readers, which call back an importer that fills our own mesh: no halfedges are built,
/// so polygons of any size, non-manifold edges and isolated vertices survive.

#include "taut/formats/mesh_guard.h"
#include "taut/formats/read_formats.h"

#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <array>
#include <mutex>
#include <sstream>

namespace taut {

namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;
using Status = OpenMesh::Attributes::StatusInfo;

class MeshImporter final : public OpenMesh::IO::BaseImporter {
  public:
    Mesh mesh;

    VertexHandle add_vertex(const OpenMesh::Vec3f &p) override {
        mesh.positions.emplace_back(p[0], p[1], p[2]);
        return VertexHandle(static_cast<int>(mesh.positions.size()) - 1);
    }
    VertexHandle add_vertex(const OpenMesh::Vec3d &p) override { return add_vertex(OpenMesh::Vec3f(p)); }
    VertexHandle add_vertex() override { return add_vertex(OpenMesh::Vec3f(0.0F)); }
    void set_point(VertexHandle v, const OpenMesh::Vec3f &p) override { mesh.positions[index(v)] = {p[0], p[1], p[2]}; }
    void set_normal(VertexHandle v, const OpenMesh::Vec3f &n) override {
        mesh.normals.resize(mesh.positions.size());
        mesh.normals[index(v)] = {n[0], n[1], n[2]};
    }
    void set_normal(VertexHandle v, const OpenMesh::Vec3d &n) override { set_normal(v, OpenMesh::Vec3f(n)); }
    void set_texcoord(VertexHandle v, const OpenMesh::Vec2f &t) override {
        mesh.uvs.resize(mesh.positions.size());
        mesh.uvs[index(v)] = {t[0], t[1]};
    }
    FaceHandle add_face(const VHandles &corners) override {
        for (const VertexHandle corner : corners) mesh.cornerPositions.push_back(static_cast<Index>(corner.idx()));
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        return FaceHandle(static_cast<int>(mesh.faceCount()) - 1);
    }
    [[nodiscard]] size_t n_vertices() const override { return mesh.positions.size(); }
    [[nodiscard]] size_t n_faces() const override { return mesh.faceCount(); }
    [[nodiscard]] size_t n_edges() const override { return 0; }

    // What a mesh of ours does not keep.
    HalfedgeHandle add_edge(VertexHandle, VertexHandle) override { return HalfedgeHandle(); }
    FaceHandle add_face(HalfedgeHandle) override { return FaceHandle(); }
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec2f> &) override {}
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<OpenMesh::Vec3f> &) override {}
    void set_face_texindex(FaceHandle, int) override {}
    void set_halfedge(VertexHandle, HalfedgeHandle) override {}
    void set_color(VertexHandle, const OpenMesh::Vec3uc &) override {}
    void set_color(VertexHandle, const OpenMesh::Vec4uc &) override {}
    void set_color(VertexHandle, const OpenMesh::Vec3f &) override {}
    void set_color(VertexHandle, const OpenMesh::Vec4f &) override {}
    void set_color(EdgeHandle, const OpenMesh::Vec3uc &) override {}
    void set_color(EdgeHandle, const OpenMesh::Vec4uc &) override {}
    void set_color(EdgeHandle, const OpenMesh::Vec3f &) override {}
    void set_color(EdgeHandle, const OpenMesh::Vec4f &) override {}
    void set_color(FaceHandle, const OpenMesh::Vec3uc &) override {}
    void set_color(FaceHandle, const OpenMesh::Vec4uc &) override {}
    void set_color(FaceHandle, const OpenMesh::Vec3f &) override {}
    void set_color(FaceHandle, const OpenMesh::Vec4f &) override {}
    void set_status(VertexHandle, const Status &) override {}
    void set_status(HalfedgeHandle, const Status &) override {}
    void set_status(EdgeHandle, const Status &) override {}
    void set_status(FaceHandle, const Status &) override {}
    void set_next(HalfedgeHandle, HalfedgeHandle) override {}
    void set_face(HalfedgeHandle, FaceHandle) override {}
    void set_normal(FaceHandle, const OpenMesh::Vec3f &) override {}
    void set_normal(FaceHandle, const OpenMesh::Vec3d &) override {}
    void request_face_texcoords2D() override {}
    void set_texcoord(HalfedgeHandle, const OpenMesh::Vec2f &) override {}
    void set_texcoord(VertexHandle, const OpenMesh::Vec3f &) override {}
    void set_texcoord(HalfedgeHandle, const OpenMesh::Vec3f &) override {}
    void add_texture_information(int, std::string) override {}

  private:
    static std::size_t index(VertexHandle v) { return static_cast<std::size_t>(v.idx()); }
};

/// Keeps OpenMesh from printing while it lives.
class QuietOpenMesh {
  public:
    QuietOpenMesh() {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            wasEnabled_[i] = streams_[i]->is_enabled();
            streams_[i]->disable();
        }
    }
    ~QuietOpenMesh() {
        for (std::size_t i = 0; i < streams_.size(); ++i)
            if (wasEnabled_[i]) streams_[i]->enable();
    }
    QuietOpenMesh(const QuietOpenMesh &) = delete;
    QuietOpenMesh &operator=(const QuietOpenMesh &) = delete;

  private:
    std::array<OpenMesh::mostream *, 3> streams_{&omout(), &omlog(), &omerr()};
    std::array<bool, 3> wasEnabled_{};
};

/// Runs one of OpenMesh's readers over a checked file.
Mesh parse(OpenMesh::IO::BaseReader &reader, CheckedFile checked, const std::string &path) {
    // The readers are singletons that keep the header of the file at hand: one file at a time.
    static std::mutex oneAtATime;
    const std::lock_guard lock(oneAtATime);
    const QuietOpenMesh quiet;
    OpenMesh::IO::Options options = OpenMesh::IO::Options::Binary;
    if (checked.hasNormals) options += OpenMesh::IO::Options::VertexNormal;
    if (checked.hasUvs) options += OpenMesh::IO::Options::VertexTexCoord;
    std::istringstream in(std::move(checked.bytes), std::ios::binary);
    MeshImporter importer;
    if (!reader.read(in, importer, options)) throw InputError(path + ": found a file that OpenMesh cannot read, expected a mesh");
    Mesh mesh = std::move(importer.mesh);
    if (checked.hasNormals) mesh.cornerNormals = mesh.cornerPositions;
    if (checked.hasUvs) mesh.cornerUvs = mesh.cornerPositions;
    if (!checked.storedM.empty()) {
        mesh.storedM = std::move(checked.storedM);
        mesh.tangents = std::move(checked.tangents);
        mesh.cornerTangents = mesh.cornerPositions;
    }
    return mesh;
}

} // namespace

Mesh readPly(std::string_view bytes, const std::string &path, Warnings &warnings) {
    return parse(OpenMesh::IO::PLYReader(), checkPly(bytes, path, warnings), path);
}

Mesh readOff(std::string_view bytes, const std::string &path, Warnings &warnings) {
    return parse(OpenMesh::IO::PLYReader(), checkOff(bytes, path, warnings), path);
}

Mesh readStl(std::string_view bytes, const std::string &path, Warnings &warnings) {
    CheckedFile checked = checkStl(bytes, path, warnings);
    const std::size_t faces = checked.faces;
    Mesh mesh = parse(OpenMesh::IO::STLReader(), std::move(checked), path);
    // OpenMesh welds, and leaves out what welding makes degenerate without a word.
    if (mesh.faceCount() != faces)
        warnings.add(path + ": dropped " + std::to_string(faces - mesh.faceCount()) + " of " + std::to_string(faces) +
                     " faces, which have fewer than three distinct corners");
    return mesh;
}

} // namespace taut
