/// NPZ: a ZIP archive (PKWARE APPNOTE 6.3) of stored .npy files (NumPy's format 1.0), one an array.

#include "taut/base/error.h"
#include "taut/export/block_writer.h"
#include "taut/export/write_gloss.h"

#include <bit>
#include <cstring>

namespace taut {

namespace {

static_assert(std::endian::native == std::endian::little);

// --- CRC-32 (ISO-HDLC, polynomial 0xedb88320), eight bytes at a time (Kounavis & Berry 2008, "slicing by 8") ----------------

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr CrcTables makeCrcTables() {
    CrcTables tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t c = i;
        for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? c >> 1 ^ 0xedb88320U : c >> 1;
        tables[0][i] = c;
    }
    for (std::size_t k = 1; k < 8; ++k)
        for (std::size_t i = 0; i < 256; ++i) tables[k][i] = tables[k - 1][i] >> 8 ^ tables[0][tables[k - 1][i] & 0xffU];
    return tables;
}
constexpr CrcTables kCrc = makeCrcTables();

/// Continues `crc` (0 at the start) over more bytes.
std::uint32_t crc32(std::uint32_t crc, std::string_view bytes) {
    crc = ~crc;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
        std::uint32_t low;
        std::uint32_t high;
        std::memcpy(&low, bytes.data() + i, 4);
        std::memcpy(&high, bytes.data() + i + 4, 4);
        low ^= crc;
        crc = kCrc[7][low & 0xffU] ^ kCrc[6][low >> 8 & 0xffU] ^ kCrc[5][low >> 16 & 0xffU] ^ kCrc[4][low >> 24] ^ kCrc[3][high & 0xffU] ^
              kCrc[2][high >> 8 & 0xffU] ^ kCrc[1][high >> 16 & 0xffU] ^ kCrc[0][high >> 24];
    }
    for (; i < bytes.size(); ++i) crc = crc >> 8 ^ kCrc[0][(crc ^ static_cast<unsigned char>(bytes[i])) & 0xffU];
    return ~crc;
}

// --- the archive -------------------------------------------------------------------------------------------------------------

class NpzFile {
  public:
    explicit NpzFile(const std::string &path) : path_(path), out_(path) {}

    /// Appends one array. `dtype` "<f4" or "<i4"; `shape` "(3, 4)". Rows of `rowBytes` bytes come from
    /// fill(begin, end, char *out).
    template <class Fill>
    void add(const std::string &name, const char *dtype, const std::string &shape, std::size_t rows, std::size_t rowBytes,
             const Fill &fill) {
        std::string header = std::string("{'descr': '") + dtype + "', 'fortran_order': False, 'shape': " + shape + ", }";
        constexpr std::size_t kPreamble = 10; // magic, version, length
        header.append(63 - (kPreamble + header.size()) % 64, ' ') += '\n';
        std::string npy("\x93NUMPY\1\0", 8);
        append16(npy, static_cast<unsigned>(header.size()));
        npy += header;

        Entry entry{name + ".npy", 0, npy.size() + std::uint64_t{rows} * rowBytes, position_};
        if (position_ + entry.size + 4096 > kMostBytes32) // plain ZIP counts them so
            throw RunError(path_ + ": an .npz of more than 4 GB cannot be written; export fewer vertices or another format");
        write(localHeader(entry));
        write(npy);
        entry.crc = crc32(0, npy);
        writeBlocks(
            rows, kBinaryRows,
            [&](std::size_t begin, std::size_t end, std::string &bytes) {
                bytes.resize((end - begin) * rowBytes);
                fill(begin, end, bytes.data());
            },
            [&](const std::string &bytes) {
                entry.crc = crc32(entry.crc, bytes);
                write(bytes);
            });
        constexpr long kCrcOffset = 14;
        std::string crc;
        append32(crc, entry.crc);
        out_.patch(static_cast<long>(entry.offset) + kCrcOffset, crc);
        entries_.push_back(entry);
    }

    void finish() {
        const std::uint64_t start = position_;
        for (const Entry &entry : entries_) {
            std::string record("PK\1\2", 4);
            append16(record, 20); // made by
            record += fields(entry);
            append16(record, 0); // comment
            append16(record, 0); // disk
            append16(record, 0); // internal attributes
            append32(record, 0); // external attributes
            append32(record, entry.offset);
            write(record + entry.name);
        }
        std::string end("PK\5\6\0\0\0\0", 8);
        append16(end, static_cast<unsigned>(entries_.size()));
        append16(end, static_cast<unsigned>(entries_.size()));
        append32(end, position_ - start);
        append32(end, start);
        append16(end, 0);
        write(end);
        out_.finish();
    }

  private:
    struct Entry {
        std::string name;
        std::uint32_t crc;
        std::uint64_t size;
        std::uint64_t offset;
    };
    /// What the local and the central header share: from "version needed" to "extra field length".
    static std::string fields(const Entry &entry) {
        std::string out;
        append16(out, 20);
        append16(out, 0);          // flags
        append16(out, 0);          // stored
        append32(out, 0x00210000); // time and date: 1980-01-01, so that equal contents are equal files
        append32(out, entry.crc);
        append32(out, entry.size);
        append32(out, entry.size);
        append16(out, static_cast<unsigned>(entry.name.size()));
        append16(out, 0);
        return out;
    }
    static std::string localHeader(const Entry &entry) { return std::string("PK\3\4", 4) + fields(entry) + entry.name; }
    void write(std::string_view bytes) {
        out_.write(bytes);
        position_ += bytes.size();
    }

    std::string path_;
    OutputFile out_;
    std::uint64_t position_ = 0;
    std::vector<Entry> entries_;
};

std::string shapeOf(std::size_t rows, std::size_t width) {
    return width == 1 ? "(" + std::to_string(rows) + ",)" : "(" + std::to_string(rows) + ", " + std::to_string(width) + ")";
}

/// Floats that stand `stride` apart, `width` of them.
void addFloats(NpzFile &npz, const std::string &name, std::size_t rows, std::size_t width, std::size_t stride, const float *data) {
    npz.add(name, "<f4", shapeOf(rows, width), rows, 4 * width, [&](std::size_t begin, std::size_t end, char *out) {
        if (stride == width) {
            std::memcpy(out, data + begin * width, (end - begin) * width * 4);
            return;
        }
        for (std::size_t v = begin; v < end; ++v, out += 4 * width) std::memcpy(out, data + v * stride, 4 * width);
    });
}

} // namespace

void writeGlossNpz(const std::string &path, const GlossMesh &mesh) {
    NpzFile npz(path);
    const std::size_t count = mesh.vertexCount();
    const auto floats = [](const auto &values) { return reinterpret_cast<const float *>(values.data()); };
    addFloats(npz, "P", count, 3, 3, floats(mesh.positions));
    addFloats(npz, "N", count, 3, 3, floats(mesh.normals));
    if (!mesh.uvs.empty()) addFloats(npz, "st", count, 2, 2, floats(mesh.uvs));
    npz.add("bitangent", "<f4", shapeOf(count, 3), count, 12, [&](std::size_t begin, std::size_t end, char *out) {
        for (std::size_t v = begin; v < end; ++v, out += 12) {
            const Vec3 b = glm::cross(mesh.normals[v], Vec3(mesh.tangents[v]));
            std::memcpy(out, &b, 12);
        }
    });
    npz.add("M", "<f4", shapeOf(count, 5), count, 20, [&](std::size_t begin, std::size_t end, char *out) {
        for (std::size_t v = begin; v < end; ++v, out += 20) {
            std::memcpy(out, &mesh.m[v], 12);
            std::memcpy(out + 12, &mesh.lean[v], 8);
        }
    });
    for (const VertexAttribute &a : vertexAttributes(mesh))
        if (a.name[0] != 'M') addFloats(npz, a.name, count, static_cast<std::size_t>(a.width), a.stride, a.data);
    npz.add("faces", "<i4", shapeOf(mesh.triangles.size(), 3), mesh.triangles.size(), 12,
            [&](std::size_t begin, std::size_t end, char *out) { std::memcpy(out, mesh.triangles.data() + begin, (end - begin) * 12); });
    npz.add(
        "face_material", "<i4", shapeOf(mesh.triangles.size(), 1), mesh.triangles.size(), 4,
        [&](std::size_t begin, std::size_t end, char *out) { std::memcpy(out, mesh.triangleMaterials.data() + begin, (end - begin) * 4); });
    npz.finish();
}

} // namespace taut
