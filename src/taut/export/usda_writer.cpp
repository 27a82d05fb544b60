#include "taut/export/usda_writer.h"

#include "taut/base/distinct_names.h"
#include "taut/base/error.h"
#include "taut/export/block_writer.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace taut {

namespace {

/// One attribute of the vertices under its USD name and type.
struct Sampled {
    std::string declaration; ///< "vector3f[] primvars:taut:ds"
    int width;
    std::size_t stride;
    const float *data;
};

bool isDirection(std::string_view name) {
    return name == "tangent" || name == "ds" || name == "dt" || name == "stretch_dir" || name == "alpha_dir";
}

std::vector<Sampled> sampledAttributes(const GlossMesh &mesh) {
    std::vector<Sampled> out{{"point3f[] points", 3, 3, &mesh.positions.front().x}, {"normal3f[] normals", 3, 3, &mesh.normals.front().x}};
    for (const VertexAttribute &a : vertexAttributes(mesh)) {
        if (a.name == "Pref") continue; // does not change
        const char *type = a.width == 1 ? "float" : isDirection(a.name) ? "vector3f" : "float3";
        out.push_back({std::string(type) + "[] primvars:taut:" + a.name, a.width, a.stride, a.data});
    }
    return out;
}

/// "[(1, 2, 3), ...]" of floats, or "[1, 2, ...]".
template <class Sink> void writeFloatArray(int width, std::size_t stride, const float *data, std::size_t count, const Sink &sink) {
    sink("[");
    writeBlocks(
        count, kTextRows,
        [&](std::size_t begin, std::size_t end, std::string &text) {
            for (std::size_t v = begin; v < end; ++v) {
                if (v != 0) text += ", ";
                if (width > 1) text += '(';
                for (int c = 0; c < width; ++c) {
                    if (c != 0) text += ", ";
                    appendShortest(text, data[v * stride + static_cast<std::size_t>(c)]);
                }
                if (width > 1) text += ')';
            }
        },
        sink);
    sink("]");
}

template <class Value, class Sink> void writeIntArray(std::size_t count, const Value &value, const Sink &sink) {
    sink("[");
    writeBlocks(
        count, kTextRows,
        [&](std::size_t begin, std::size_t end, std::string &text) {
            for (std::size_t i = begin; i < end; ++i) {
                if (i != 0) text += ", ";
                appendNumber(text, value(i));
            }
        },
        sink);
    sink("]");
}

/// Names of prims: letters, digits and underscores, each once.
std::vector<std::string> primNames(std::span<const GlossMesh> meshes) {
    std::vector<std::string> names;
    DistinctNames unique;
    for (const GlossMesh &mesh : meshes) {
        std::string name = mesh.name.empty() ? "mesh" : mesh.name;
        for (char &c : name)
            if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'))) c = '_';
        if (name[0] >= '0' && name[0] <= '9') name.insert(0, 1, '_');
        names.push_back(unique.add(name));
    }
    return names;
}

std::string layerHeader(const std::vector<int> &frames, double fps) {
    std::string rate;
    char text[32];
    rate.assign(text, std::to_chars(text, text + sizeof text, fps).ptr);
    return "#usda 1.0\n(\n    defaultPrim = \"taut\"\n    doc = \"\"\"Written by taut export. M = [M.x M.y M_p; 0 M.z M_q; 0 0 1] in the "
           "frame "
           "(tangent, cross(normal, tangent), normal).\"\"\"\n    endTimeCode = " +
           std::to_string(frames.back()) + "\n    framesPerSecond = " + rate +
           "\n    metersPerUnit = 1\n    startTimeCode = " + std::to_string(frames.front()) + "\n    timeCodesPerSecond = " + rate +
           "\n    upAxis = \"Z\"\n)\n\ndef Xform \"taut\"\n{\n";
}

} // namespace

/// A temporary file that vanishes with its owner. It holds the samples in the order in which they come; the file wants each attribute's
/// together.
struct UsdaWriter::Spool {
    std::string path; ///< of the file that it is for
    std::FILE *file;
    std::uint64_t size = 0;
    explicit Spool(std::string name) : path(std::move(name)), file(openSpool(path)) {}
    Spool(const Spool &) = delete;
    Spool &operator=(const Spool &) = delete;
    ~Spool() { std::fclose(file); }
    [[noreturn]] void fail() const { throw RunError(path + ": could not be written: " + std::strerror(errno)); }
    void write(std::string_view text) {
        if (std::fwrite(text.data(), 1, text.size(), file) != text.size()) fail();
        size += text.size();
    }
    void copy(const Passage &passage, OutputFile &out) const {
        if (fseeko(file, static_cast<off_t>(passage.begin), SEEK_SET) != 0) fail();
        std::array<char, 1 << 16> block;
        for (std::uint64_t left = passage.end - passage.begin; left > 0;) {
            const std::size_t read = std::fread(block.data(), 1, std::min<std::uint64_t>(block.size(), left), file);
            if (read == 0) fail();
            out.write(block.data(), read);
            left -= read;
        }
    }
};

UsdaWriter::UsdaWriter(const std::string &path, std::span<const GlossMesh> meshes)
    : out_(path), spool_(std::make_unique<Spool>(path)), samples_(meshes.size()) {}

UsdaWriter::~UsdaWriter() = default;

void UsdaWriter::write(int frame, std::span<const GlossMesh> meshes) {
    frames_.push_back(frame);
    const auto sink = [&](std::string_view text) { spool_->write(text); };
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const std::vector<Sampled> attributes = sampledAttributes(meshes[m]);
        samples_[m].resize(attributes.size());
        for (std::size_t a = 0; a < attributes.size(); ++a) {
            const Sampled &attribute = attributes[a];
            const std::uint64_t begin = spool_->size;
            sink("            " + std::to_string(frame) + ": ");
            writeFloatArray(attribute.width, attribute.stride, attribute.data, meshes[m].vertexCount(), sink);
            sink(",\n");
            samples_[m][a].push_back({begin, spool_->size});
        }
    }
}

void UsdaWriter::finish(std::span<const GlossMesh> meshes, double fps) {
    const auto sink = [&](std::string_view text) { out_.write(text); };
    const std::vector<std::string> names = primNames(meshes);
    sink(layerHeader(frames_, fps));
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const GlossMesh &mesh = meshes[m];
        const std::size_t vertices = mesh.vertexCount();
        sink("    def Mesh \"" + names[m] + "\"\n    {\n        uniform bool doubleSided = 1\n        int[] faceVertexCounts = ");
        writeIntArray(
            mesh.triangles.size(), [](std::size_t) { return 3U; }, sink);
        sink("\n        int[] faceVertexIndices = ");
        writeIntArray(
            3 * mesh.triangles.size(), [&](std::size_t i) { return mesh.triangles[i / 3][static_cast<int>(i % 3)]; }, sink);
        sink("\n        uniform token orientation = \"rightHanded\"\n        uniform token subdivisionScheme = \"none\"\n");
        const auto vertexArray = [&](const char *declaration, int width, const float *data) {
            sink(std::string("        ") + declaration + " = ");
            writeFloatArray(width, static_cast<std::size_t>(width), data, vertices, sink);
            sink(" (\n            interpolation = \"vertex\"\n        )\n");
        };
        if (!mesh.uvs.empty()) vertexArray("texCoord2f[] primvars:st", 2, &mesh.uvs.front().x);
        vertexArray("point3f[] primvars:Pref", 3, &mesh.restPositions.front().x);
        sink("        int[] primvars:taut:material = ");
        writeIntArray(
            mesh.triangleMaterials.size(), [&](std::size_t i) { return mesh.triangleMaterials[i]; }, sink);
        sink(" (\n            interpolation = \"uniform\"\n        )\n");
        const std::vector<Sampled> attributes = sampledAttributes(mesh);
        for (std::size_t a = 0; a < attributes.size(); ++a) {
            const std::string &declaration = attributes[a].declaration;
            if (a > 0) sink("        " + declaration + " (\n            interpolation = \"vertex\"\n        )\n"); // points have none
            sink("        " + declaration + ".timeSamples = {\n");
            for (const Passage &passage : samples_[m][a]) spool_->copy(passage, out_);
            sink("        }\n");
        }
        sink("    }\n");
    }
    sink("}\n");
    spool_.reset();
    out_.finish();
}

} // namespace taut
