/// PLY and CSV: rows of scalars.

#include "taut/base/error.h"
#include "taut/export/block_writer.h"
#include "taut/export/write_gloss.h"

#include <bit>
#include <cstring>

namespace taut {

namespace {

static_assert(std::endian::native == std::endian::little);

void writeBinaryRows(OutputFile &out, const std::vector<VertexColumn> &columns, std::size_t count) {
    writeBlocks(
        count, kBinaryRows,
        [&](std::size_t begin, std::size_t end, std::string &bytes) {
            const std::size_t width = columns.size();
            bytes.resize((end - begin) * width * sizeof(float));
            char *row = bytes.data();
            for (std::size_t v = begin; v < end; ++v)
                for (std::size_t c = 0; c < width; ++c, row += sizeof(float))
                    std::memcpy(row, columns[c].data + v * columns[c].stride, sizeof(float));
        },
        [&](const std::string &bytes) { out.write(bytes); });
}

void writeTextRows(OutputFile &out, const std::vector<VertexColumn> &columns, std::size_t count, char separator) {
    writeBlocks(
        count, kTextRows,
        [&](std::size_t begin, std::size_t end, std::string &text) {
            for (std::size_t v = begin; v < end; ++v) {
                for (const VertexColumn &column : columns) {
                    appendShortest(text, column.data[v * column.stride]);
                    text += separator;
                }
                text.back() = '\n';
            }
        },
        [&](const std::string &text) { out.write(text); });
}

/// uchar 3, three ints and the material: 17 bytes.
void writeBinaryFaces(OutputFile &out, const GlossMesh &mesh) {
    constexpr std::size_t kFaceBytes = 17;
    writeBlocks(
        mesh.triangles.size(), kBinaryRows,
        [&](std::size_t begin, std::size_t end, std::string &bytes) {
            bytes.resize((end - begin) * kFaceBytes);
            char *row = bytes.data();
            for (std::size_t f = begin; f < end; ++f, row += kFaceBytes) {
                row[0] = 3;
                std::memcpy(row + 1, &mesh.triangles[f], 12);
                std::memcpy(row + 13, &mesh.triangleMaterials[f], 4);
            }
        },
        [&](const std::string &bytes) { out.write(bytes); });
}

void writeTextFaces(OutputFile &out, const GlossMesh &mesh) {
    writeBlocks(
        mesh.triangles.size(), kTextRows,
        [&](std::size_t begin, std::size_t end, std::string &text) {
            for (std::size_t f = begin; f < end; ++f) {
                text += "3 ";
                for (int k = 0; k < 3; ++k) {
                    appendNumber(text, mesh.triangles[f][k]);
                    text += ' ';
                }
                appendNumber(text, mesh.triangleMaterials[f]);
                text += '\n';
            }
        },
        [&](const std::string &text) { out.write(text); });
}

} // namespace

void writeGlossPly(const std::string &path, const GlossMesh &mesh, bool ascii) {
    const std::vector<VertexColumn> columns = vertexColumns(mesh);
    std::string header = ascii ? "ply\nformat ascii 1.0\n" : "ply\nformat binary_little_endian 1.0\n";
    header += "comment taut gloss: M = [M_x M_y M_p_x; 0 M_z M_q_x; 0 0 1] in the frame (tangent, cross(normal, tangent), normal)\n";
    for (std::size_t i = 0; i < mesh.materials.size(); ++i)
        header += "comment material " + std::to_string(i) + " " + taut::quoted(mesh.materials[i].name) + "\n"; // control bytes escaped
    header += "element vertex " + std::to_string(mesh.vertexCount()) + "\n";
    for (const VertexColumn &column : columns) header += "property float " + column.name + "\n";
    header += "element face " + std::to_string(mesh.triangles.size()) +
              "\nproperty list uchar int vertex_indices\nproperty int material\nend_header\n";
    OutputFile out(path);
    out.write(header);
    if (ascii) {
        writeTextRows(out, columns, mesh.vertexCount(), ' ');
        writeTextFaces(out, mesh);
    } else {
        writeBinaryRows(out, columns, mesh.vertexCount());
        writeBinaryFaces(out, mesh);
    }
    out.finish();
}

void writeGlossCsv(const std::string &path, const GlossMesh &mesh) {
    const std::vector<VertexColumn> columns = vertexColumns(mesh);
    std::string header;
    for (const VertexColumn &column : columns) header += column.name + ",";
    header.back() = '\n';
    OutputFile out(path);
    out.write(header);
    writeTextRows(out, columns, mesh.vertexCount(), ',');
    out.finish();
}

} // namespace taut
