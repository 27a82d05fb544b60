/// Does an export stream, and how fast? A sheared grid goes through every writer, one frame a file (the point cache and the .usda hold all
/// frames), beside as many bytes written plainly to the same folder.

#include "study/charts.h"
#include "study/measures/memory.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include "taut/base/error.h"
#include "taut/base/stopwatch.h"
#include "taut/export/gloss_export.h"
#include "taut/export/usda_writer.h"
#include "taut/export/write_gloss.h"
#include "taut/formats/point_cache.h"

#include <cstdio>

namespace taut::chart {

namespace {

namespace fs = std::filesystem;

/// About `vertices` of them in a wavy square grid, sheared over the frames.
Scene gridScene(std::size_t vertices, int frames) {
    const int quads = static_cast<int>(std::lround(std::sqrt(static_cast<double>(vertices)))) - 1;
    Mesh mesh = makeGrid(quads, quads, 2);
    mesh.name = "grid";
    for (Vec3 &p : mesh.positions) p.z = 0.1F * std::sin(3 * (p.x + 1)) * std::sin(3 * (p.y + 1));
    mesh.normals.clear();
    mesh.cornerNormals.clear();
    Scene scene;
    scene.materials = {brushedMetal(0.1F, 0.4F)};
    scene.objects = {objectOf(std::move(mesh))};
    scene.objects[0].deformers = {deformer(DeformerType::Shear, ramp(1.2, frames), 0, 1)};
    return scene;
}

/// Seconds of the same bytes by fwrite in blocks of a megabyte.
double plainWrite(const std::string &path, std::uintmax_t bytes) {
    const std::string block(std::size_t{1} << 20, 'x');
    Stopwatch watch;
    std::FILE *file = std::fopen(path.c_str(), "wb");
    bool written = file != nullptr;
    for (std::uintmax_t left = bytes; left > 0 && written;) {
        const std::size_t size = static_cast<std::size_t>(std::min<std::uintmax_t>(left, block.size()));
        written = std::fwrite(block.data(), 1, size, file) == size;
        left -= size;
    }
    if (file == nullptr || std::fclose(file) != 0 || !written) throw RunError(path + ": can't be written");
    const double seconds = watch.lap();
    fs::remove(path);
    return seconds;
}

struct Result {
    double gloss = 0, write = 0, plain = 0; ///< s
    std::uintmax_t bytes = 0;
    double peakAtTwo = 0, peakAtEnd = 0; ///< MB
};

/// Files are deleted as they are done.
Result measure(const std::string &format, const fs::path &folder, const Scene &scene, int frames) {
    resetPeak();
    GlossObject object;
    prepareGlossObject(scene, scene.objects.front(), object);
    const std::string path = (folder / ("export." + format)).string();
    std::unique_ptr<UsdaWriter> usda;
    std::unique_ptr<PointCacheWriter> cache;
    std::vector<Vec3> points;
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
    Result result;
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
        if (!fs::exists(path)) continue; // a file of all frames, not yet finished
        const std::uintmax_t bytes = fs::file_size(path);
        fs::remove(path);
        result.bytes += bytes;
        result.plain += plainWrite(path + ".plain", bytes);
    }
    result.peakAtEnd = peakMegabytes();
    return result;
}

} // namespace

Chart measureExport(const ChartOptions &options) {
    const int frames = options.pick(4, 24);
    const auto vertices = static_cast<std::size_t>(options.pick(100000, 1000000));
    Chart chart{"export", "Writers of exports",
                printed("A sheared grid of %s vertices through every writer, %d frames (the .usda: a hundredth of the vertices, for "
                        "it is text and holds every frame), beside the same bytes written plainly to the same folder.",
                        count(static_cast<double>(vertices)).c_str(), frames),
                "Memory that does not grow from the second frame to the last: the writer streams."};
    Table table{"writers",
                "Time, size and peak memory",
                {"format", "vertices x frames", "MB", "M, s", "write, s", "plain write, s", "write MB/s", "ratio",
                 printed("peak MB at frame 2 / %d", frames)},
                {}};
    for (const std::string format : {"ply", "npz", "glb", "csv", "usda", "pc2"}) {
        const std::size_t size = format == "usda" ? vertices / 100 : vertices;
        const Result r = measure(format, options.directory, gridScene(size, frames), frames);
        const double megabytes = static_cast<double>(r.bytes) / 1e6;
        table.rows.push_back({format, printed("%zu x %d", size, frames), printed("%.0f", megabytes), printed("%.2f", r.gloss),
                              printed("%.2f", r.write), printed("%.2f", r.plain), printed("%.0f", megabytes / r.write),
                              printed("%.2f", r.plain / r.write), printed("%.0f / %.0f", r.peakAtTwo, r.peakAtEnd)});
    }
    chart.tables.push_back(std::move(table));
    return chart;
}

} // namespace taut::chart
