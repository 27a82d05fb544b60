/// taut_export_bench [FOLDER] [VERTICES] [FRAMES]: does an export stream, and how fast?
///
/// A sheared grid (one million vertices, 24 frames) goes through every writer, one frame a file (the point caches and the .usda
/// all frames). For each: seconds to work out M, seconds to write, the same number of bytes written plainly to the same folder,
/// their ratio, and the peak memory after the second and after the last frame, each format in a process of its own. Files are
/// deleted as they are done. The .usda is given a hundredth of the vertices: it is text and holds every frame.

#include "taut/base/stopwatch.h"
#include "taut/export/gloss_export.h"
#include "taut/export/usda_writer.h"
#include "taut/export/write_gloss.h"
#include "taut/formats/point_cache.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

using namespace taut;

namespace {

double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// About `vertices` of them in a square grid with UVs, sheared over the frames.
Scene gridScene(std::size_t vertices, int frames) {
    const auto side = static_cast<Index>(std::lround(std::sqrt(static_cast<double>(vertices))));
    Mesh mesh;
    mesh.name = "grid";
    for (Index y = 0; y < side; ++y)
        for (Index x = 0; x < side; ++x) {
            const Vec2 uv(static_cast<float>(x) / static_cast<float>(side - 1), static_cast<float>(y) / static_cast<float>(side - 1));
            mesh.uvs.push_back(uv);
            mesh.positions.emplace_back(2 * uv.x - 1, 2 * uv.y - 1, 0.1F * std::sin(6 * uv.x) * std::sin(6 * uv.y));
        }
    for (Index y = 0; y + 1 < side; ++y)
        for (Index x = 0; x + 1 < side; ++x) {
            const Index a = x + y * side;
            for (const Index corner : {a, a + 1, a + 1 + side, a + side}) mesh.cornerPositions.push_back(corner);
            mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        }
    mesh.cornerUvs = mesh.cornerPositions;
    Scene scene;
    Material metal;
    metal.name = "metal";
    metal.type = BsdfType::Conductor;
    metal.alphaX.value = 0.1F;
    metal.alphaY.value = 0.4F;
    scene.materials.push_back(metal);
    Object object;
    object.name = "grid";
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {0};
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 1;
    shear.amount.keys = {{1.0, 0.0}, {static_cast<double>(frames), 1.2}};
    object.deformers.push_back(shear);
    scene.objects.push_back(std::move(object));
    return scene;
}

struct Result {
    double gloss = 0, write = 0, plain = 0;
    std::uintmax_t bytes = 0;
    double peakAtTwo = 0, peakAtEnd = 0;
};

/// The same bytes by fwrite in blocks of a megabyte.
double plainWrite(const std::string &path, std::uintmax_t bytes) {
    const std::string block(std::size_t{1} << 20, 'x');
    Stopwatch watch;
    std::FILE *file = std::fopen(path.c_str(), "wb");
    for (std::uintmax_t left = bytes; left > 0;) {
        const std::size_t size = static_cast<std::size_t>(std::min<std::uintmax_t>(left, block.size()));
        if (std::fwrite(block.data(), 1, size, file) != size) std::abort();
        left -= size;
    }
    std::fclose(file);
    const double seconds = watch.lap();
    std::filesystem::remove(path);
    return seconds;
}

Result measure(const std::string &format, const std::string &folder, std::size_t vertices, int frames) {
    const Scene scene = gridScene(vertices, frames);
    GlossObject object;
    prepareGlossObject(scene, scene.objects.front(), object);
    const std::string path = folder + "/bench." + format;
    std::unique_ptr<UsdaWriter> usda;
    std::unique_ptr<PointCacheWriter> cache;
    std::vector<Vec3> points;
    Result result;
    const auto writeFrame = [&](int frame) {
        const std::span<const GlossMesh> meshes(&object.mesh, 1);
        if (format == "ply") writeGlossPly(path, object.mesh, false);
        if (format == "csv") writeGlossCsv(path, object.mesh);
        if (format == "npz") writeGlossNpz(path, object.mesh);
        if (format == "glb") writeGlossGltf(path, meshes, std::vector<std::vector<MeanGloss>>{meanGloss(object.mesh)});
        if (format == "usda") {
            if (!usda) usda = std::make_unique<UsdaWriter>(path, meshes);
            usda->write(frame, meshes);
            if (frame == frames) usda->finish(meshes, 24);
        }
        if (format == "pc2") {
            if (!cache)
                cache = std::make_unique<PointCacheWriter>(
                    path, PointCacheInfo{PointCacheFormat::Pc2, static_cast<Index>(points.size()), static_cast<Index>(frames), 1, 1, {}});
            cache->write(points);
            if (frame == frames) cache->finish();
        }
    };
    for (int frame = 1; frame <= frames; ++frame) {
        Stopwatch watch;
        if (format == "pc2")
            pointsAtFrame(scene, frame, PointSpace::World, object, points);
        else
            glossAtFrame(scene, frame, {}, object);
        result.gloss += watch.lap();
        writeFrame(frame);
        result.write += watch.lap();
        if (frame == 2) result.peakAtTwo = peakMegabytes();
        if (!std::filesystem::exists(path)) continue; // a file of all frames, not yet finished
        const std::uintmax_t bytes = std::filesystem::file_size(path);
        std::filesystem::remove(path);
        result.bytes += bytes;
        result.plain += plainWrite(path + ".plain", bytes);
    }
    result.peakAtEnd = peakMegabytes();
    return result;
}

} // namespace

int main(int argc, char **argv) {
    const std::string folder = argc > 1 ? argv[1] : "out";
    const std::size_t vertices = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1000000;
    const int frames = argc > 3 ? std::atoi(argv[3]) : 24;
    if (vertices < 4 || frames < 2) {
        std::fprintf(stderr, "taut_export_bench [FOLDER] [VERTICES >= 4] [FRAMES >= 2]\n");
        return 2;
    }
    std::filesystem::create_directories(folder);
    std::printf("| format | vertices x frames | MB | M, s | write, s | plain write, s | write MB/s | ratio | peak MB at frame 2 / %d |\n",
                frames);
    std::printf("|---|---|---|---|---|---|---|---|---|\n");
    for (const std::string format : {"ply", "npz", "glb", "csv", "usda", "pc2"}) {
        std::fflush(stdout);
        const pid_t child = fork(); // before any thread: peak memory of its own
        if (child == 0) {
            const std::size_t count = format == "usda" ? vertices / 100 : vertices;
            const Result r = measure(format, folder, count, frames);
            const double megabytes = static_cast<double>(r.bytes) / 1e6;
            std::printf("| %s | %zu x %d | %.0f | %.2f | %.2f | %.2f | %.0f | %.2f | %.0f / %.0f |\n", format.c_str(), count, frames,
                        megabytes, r.gloss, r.write, r.plain, megabytes / r.write, r.plain / r.write, r.peakAtTwo, r.peakAtEnd);
            std::fflush(stdout);
            _exit(0);
        }
        int status = 0;
        waitpid(child, &status, 0);
        if (status != 0) return 1;
    }
    return 0;
}
