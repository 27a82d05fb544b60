#include "exporter.h"

#include "part_names.h"

#include "taut/base/frame_set.h"
#include "taut/base/stopwatch.h"
#include "taut/export/gloss_export.h"
#include "taut/export/usda_writer.h"
#include "taut/export/write_gloss.h"
#include "taut/formats/point_cache.h"
#include "taut/scene/memory_estimate.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <unordered_set>

namespace taut::app {

namespace {

namespace fs = std::filesystem;

enum class Format { Ply, Csv, Npz, Gltf, Usda, Cache };

struct FormatInfo {
    std::string_view extension;
    Format format;
    bool manyObjects; ///< one file holds all objects
    bool manyFrames;  ///< one file may hold all frames
};
constexpr std::array<FormatInfo, 8> kFormats{{{"ply", Format::Ply, false, false},
                                              {"csv", Format::Csv, false, false},
                                              {"npz", Format::Npz, false, false},
                                              {"glb", Format::Gltf, true, false},
                                              {"gltf", Format::Gltf, true, false},
                                              {"usda", Format::Usda, true, true},
                                              {"pc2", Format::Cache, false, true},
                                              {"mdd", Format::Cache, false, true}}};

const FormatInfo &formatOf(const std::string &path) {
    const std::string extension = lowerExtension(path);
    std::vector<std::string_view> names;
    for (const FormatInfo &info : kFormats) {
        if (info.extension == extension) return info;
        names.push_back(info.extension);
    }
    failUnknownName({"-o " + quoted(path)}, extension, names);
}

/// One -o: a pattern, and for formats that hold all frames the writers that are open.
struct Output {
    std::string pattern;
    FormatInfo info;
    std::vector<std::string> parts;                        ///< [objects] what their files are told apart by; empty: nothing
    std::vector<std::unique_ptr<PointCacheWriter>> caches; ///< [objects]
    std::unique_ptr<UsdaWriter> usda;                      ///< of all frames
};

std::string_view oneOfNames(const std::string &option, const std::string &value, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names)
        if (name == value) return name;
    failUnknownName({option}, value, std::vector<std::string_view>(names));
}

const ConventionInfo *parseConvention(const std::string &name) {
    if (name == "matrix") return nullptr;
    std::vector<std::string_view> names{"matrix"};
    for (const ConventionInfo &info : kConventions) {
        if (info.name == name) return &info;
        names.push_back(info.name);
    }
    failUnknownName({"--convention"}, name, names);
}

/// "out/0001.ply" -> "out/0001.body.ply" where the format holds one object and there are several.
std::string pathOf(const Output &output, int frame, std::size_t object) {
    fs::path path = pathOfFrame(output.pattern, frame);
    if (!output.parts.empty()) path.replace_extension("." + output.parts[object] + path.extension().string());
    return path.string();
}

/// Names for the files of `objects`, so short that the longest frame number leaves a name that file systems take.
std::vector<std::string> partsOf(const Output &output, const std::vector<int> &frames, const std::vector<GlossObject> &objects) {
    constexpr std::size_t kLongestName = 255; // bytes, of common file systems
    constexpr std::size_t kShortestPart = 16; // of names that are too long already
    if (output.info.manyObjects || objects.size() < 2) return {};
    std::size_t longest = 0;
    for (const int frame : frames) longest = std::max(longest, fs::path(pathOfFrame(output.pattern, frame)).filename().string().size());
    std::vector<std::string> names;
    for (const GlossObject &object : objects) names.push_back(object.mesh.name);
    return partNames(names, longest + 1 + kShortestPart < kLongestName ? kLongestName - longest - 1 : kShortestPart);
}

/// The path of a file that is about to be written; its folder is made.
std::string newPathOf(const Output &output, int frame, std::size_t object) {
    std::string path = pathOf(output, frame, object);
    std::error_code ignored; // the writer says what is wrong with a path
    if (const fs::path folder = fs::path(path).parent_path(); !folder.empty()) fs::create_directories(folder, ignored);
    return path;
}

class Exporter {
  public:
    Exporter(const Scene &scene, const ExportRequest &arguments);
    nlohmann::json run(Warnings &warnings);

  private:
    void checkOutputs();
    void chargeOutputs() const;
    void checkPaths();
    void open(Output &output);
    void write(Output &output, int frame);
    void close(Output &output);
    void wrote(const std::string &path);
    nlohmann::json report(double seconds, Warnings &warnings);

    const Scene &scene_;
    const ExportRequest &arguments_;
    const std::vector<int> &frames_;
    GlossOptions options_;
    PointSpace space_ = PointSpace::World;
    std::vector<GlossObject> objects_;
    std::vector<Output> outputs_;
    std::vector<Vec3> points_;
    std::vector<std::string> files_;
    std::uint64_t bytes_ = 0;
    float greatestSpread_ = 0; ///< of the gloss of a material in a glTF file
    std::size_t clippedMaterials_ = 0;
};

Exporter::Exporter(const Scene &scene, const ExportRequest &arguments)
    : scene_(scene), arguments_(arguments), frames_(scene.render.frames) {
    options_.convention = parseConvention(arguments.convention);
    options_.restPositions = oneOfNames("--positions", arguments.positions, {"deformed", "rest"}) == "rest";
    if (oneOfNames("--space", arguments.space, {"world", "object"}) == "object") space_ = PointSpace::Object;
    for (const std::string &pattern : arguments.outputs) outputs_.push_back({pattern, formatOf(pattern), {}, {}, nullptr});
    checkOutputs();

    std::vector<std::string_view> names;
    for (const Object &object : scene.objects) names.push_back(object.name);
    for (const std::string &name : arguments.objects)
        if (std::find(names.begin(), names.end(), name) == names.end()) failUnknownName({"--object"}, name, names);
    const auto isChosen = [&](const Object &object) {
        return arguments.objects.empty() ||
               std::find(arguments.objects.begin(), arguments.objects.end(), object.name) != arguments.objects.end();
    };
    objects_.reserve(scene.objects.size());
    for (const Object &object : scene.objects) {
        if (!isChosen(object)) continue;
        if (scene.budget && object.planLevel) // nobody plans: its level is taken as it is
            scene.budget->take(objectBytes(object, scene.render, object.subdivision.level), "mesh " + quoted(object.name),
                               "subdivision = \"auto\"");
        prepareGlossObject(scene, object, objects_.emplace_back());
    }
    if (objects_.empty()) failInput({scene.path}, "no mesh", "at least one to export");
    for (Output &output : outputs_) output.parts = partsOf(output, frames_, objects_);
    chargeOutputs();
    checkPaths();
}

/// What writers need beside the meshes.
void Exporter::chargeOutputs() const {
    constexpr double kGltfObject = 12e3;   // bytes of JSON
    constexpr double kGltfMaterial = 12e3; // of an object
    constexpr double kFile = 3e-4;         // seconds to make and name one
    if (!scene_.budget) return;
    std::size_t materials = 0;
    for (const GlossObject &object : objects_) materials += object.mesh.materials.size();
    for (const Output &output : outputs_) {
        if (output.info.format == Format::Gltf)
            scene_.budget->require(kGltfObject * static_cast<double>(objects_.size()) + kGltfMaterial * static_cast<double>(materials),
                                   output.pattern, std::to_string(objects_.size()) + " meshes in a glTF file");
        scene_.budget->work(kFile * static_cast<double>(output.parts.size()), output.pattern,
                            std::to_string(output.parts.size()) + " files");
    }
}

/// No file is written twice, and none over the scene. Files of one output differ by their frame numbers and parts.
void Exporter::checkPaths() {
    std::unordered_set<std::string> taken;
    for (const Output &output : outputs_) {
        const bool eachFrame = hasFramePattern(output.pattern);
        const std::size_t parts = std::max<std::size_t>(1, output.parts.size());
        for (std::size_t f = 0; f < (eachFrame ? frames_.size() : 1); ++f)
            for (std::size_t i = 0; i < parts; ++i) {
                const std::string path = pathOf(output, frames_[f], i);
                std::error_code ignored;
                if (fs::equivalent(path, scene_.path, ignored))
                    failInput({"-o"}, quoted(path) + ", which is the scene itself", "another file");
                if (outputs_.size() > 1 && !taken.insert(fs::absolute(path).lexically_normal().string()).second)
                    failInput({"-o"}, quoted(path) + " twice", "outputs that do not write over each other");
            }
    }
}

void Exporter::checkOutputs() {
    const bool increasing = std::is_sorted(frames_.begin(), frames_.end());
    for (const Output &output : outputs_) {
        const bool pattern = hasFramePattern(output.pattern);
        if (frames_.size() > 1 && !pattern && !output.info.manyFrames)
            failInput({"-o"}, quoted(output.pattern), "a frame number such as #### in the name, for more than one frame");
        if (output.info.format != Format::Cache && space_ == PointSpace::Object)
            failInput({"-o"}, quoted(output.pattern), "a .pc2 or .mdd for --space object; M is measured in the world");
        if (output.info.format == Format::Cache && pattern)
            failInput({"-o"}, quoted(output.pattern), "a name without a frame number: a point cache holds all frames");
        if (output.info.manyFrames && !increasing)
            failInput({"--frames"}, "frames that do not increase", "increasing ones in a file of many");
        if (output.info.extension == "pc2")
            for (std::size_t i = 2; i < frames_.size(); ++i)
                if (frames_[i] - frames_[i - 1] != frames_[1] - frames_[0])
                    failInput({"--frames"}, "frames at different distances", "evenly spaced ones for PC2 (MDD takes any)");
    }
}

void Exporter::open(Output &output) {
    if (output.info.format != Format::Cache) return;
    allowOpenFiles(outputs_.size() * objects_.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        PointCacheInfo info;
        info.format = output.info.extension == "mdd" ? PointCacheFormat::Mdd : PointCacheFormat::Pc2;
        info.points = static_cast<std::uint32_t>(objects_[i].surface.mesh().positions.size());
        info.samples = static_cast<std::uint32_t>(frames_.size());
        info.firstFrame = static_cast<float>(frames_.front());
        info.frameStep = frames_.size() > 1 ? static_cast<float>(frames_[1] - frames_[0]) : 1.0F;
        for (const int frame : frames_) info.seconds.push_back(static_cast<float>((frame - 1) / scene_.render.fps));
        output.caches.push_back(std::make_unique<PointCacheWriter>(newPathOf(output, 0, i), std::move(info)));
    }
}

/// The meshes of all objects side by side, as writers of many objects take them. Moved there and back: nothing is copied.
class MeshesTogether {
  public:
    explicit MeshesTogether(std::vector<GlossObject> &objects) : objects_(objects) {
        for (GlossObject &object : objects_) meshes.push_back(std::move(object.mesh));
    }
    MeshesTogether(const MeshesTogether &) = delete;
    MeshesTogether &operator=(const MeshesTogether &) = delete;
    ~MeshesTogether() {
        for (std::size_t i = 0; i < objects_.size(); ++i) objects_[i].mesh = std::move(meshes[i]);
    }
    std::vector<GlossMesh> meshes;

  private:
    std::vector<GlossObject> &objects_;
};

void Exporter::write(Output &output, int frame) {
    switch (output.info.format) {
    case Format::Cache:
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            pointsAtFrame(scene_, frame, space_, objects_[i], points_);
            output.caches[i]->write(points_);
        }
        return;
    case Format::Usda: {
        const MeshesTogether together(objects_);
        if (!output.usda) output.usda = std::make_unique<UsdaWriter>(newPathOf(output, frame, 0), together.meshes);
        output.usda->write(frame, together.meshes);
        if (!hasFramePattern(output.pattern)) return;
        output.usda->finish(together.meshes, scene_.render.fps);
        output.usda.reset();
        break;
    }
    case Format::Gltf: {
        const MeshesTogether together(objects_);
        std::vector<std::vector<MeanGloss>> means;
        for (const GlossMesh &mesh : together.meshes) {
            means.push_back(meanGloss(mesh));
            for (const MeanGloss &mean : means.back()) greatestSpread_ = std::fmax(greatestSpread_, mean.spread);
        }
        clippedMaterials_ += writeGlossGltf(newPathOf(output, frame, 0), together.meshes, means);
        break;
    }
    default:
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            const std::string path = newPathOf(output, frame, i);
            if (output.info.format == Format::Ply) writeGlossPly(path, objects_[i].mesh, arguments_.ascii);
            if (output.info.format == Format::Csv) writeGlossCsv(path, objects_[i].mesh);
            if (output.info.format == Format::Npz) writeGlossNpz(path, objects_[i].mesh);
            wrote(path);
        }
        return;
    }
    wrote(pathOf(output, frame, 0));
}

void Exporter::close(Output &output) {
    for (std::size_t i = 0; i < output.caches.size(); ++i) {
        output.caches[i]->finish();
        wrote(pathOf(output, 0, i));
    }
    if (!output.usda) return;
    const MeshesTogether together(objects_);
    output.usda->finish(together.meshes, scene_.render.fps);
    wrote(pathOf(output, 0, 0));
}

void Exporter::wrote(const std::string &path) {
    files_.push_back(path);
    std::error_code ignored;
    const std::uintmax_t size = fs::file_size(path, ignored);
    if (!ignored) bytes_ += size;
}

nlohmann::json Exporter::run(Warnings &warnings) {
    Stopwatch total;
    const bool onlyCaches =
        std::all_of(outputs_.begin(), outputs_.end(), [](const Output &output) { return output.info.format == Format::Cache; });
    for (Output &output : outputs_) open(output);
    for (const int frame : frames_) {
        Stopwatch watch;
        if (arguments_.startFrame) arguments_.startFrame(frame);
        if (!onlyCaches)
            for (GlossObject &object : objects_) glossAtFrame(scene_, frame, options_, object);
        for (Output &output : outputs_) write(output, frame);
        if (arguments_.finishFrame) arguments_.finishFrame(frame, pathOf(outputs_.front(), frame, 0), watch.lap());
    }
    for (Output &output : outputs_) close(output);
    return report(total.lap(), warnings);
}

nlohmann::json Exporter::report(double seconds, Warnings &warnings) {
    std::size_t vertices = 0;
    std::size_t clipped = 0;
    nlohmann::json objects = nlohmann::json::array();
    for (const GlossObject &object : objects_) {
        objects.push_back({{"name", object.mesh.name},
                           {"vertices", object.sources.size()},
                           {"triangles", object.mesh.triangles.size()},
                           {"clipped", object.clipped}});
        vertices += object.sources.size();
        clipped += object.clipped;
    }
    if (clipped > 0)
        warnings.add(fmt::format("--convention {}: {} of {} vertices x frames lay outside its limits and were clipped",
                                 arguments_.convention, clipped, vertices * frames_.size()));
    if (clippedMaterials_ > 0)
        warnings.add(
            fmt::format("glTF: {} materials x frames lay outside the limits of KHR_materials_anisotropy and were clipped; the _TAUT_ "
                        "attributes are not",
                        clippedMaterials_));
    if (greatestSpread_ > 0.02F)
        warnings.add(
            fmt::format("glTF: the gloss varies over a material by {:.3g} of its alpha squared; KHR_materials_anisotropy has its mean, "
                        "the _TAUT_ attributes all of it",
                        greatestSpread_));
    return {{"scene", scene_.path}, {"convention", arguments_.convention},    {"frames", frames_.size()}, {"objects", objects},
            {"clipped", clipped},   {"clipped_materials", clippedMaterials_}, {"files", files_},          {"bytes", bytes_},
            {"seconds", seconds}};
}

} // namespace

nlohmann::json exportFiles(const Scene &scene, const ExportRequest &request, Warnings &warnings) {
    return Exporter(scene, request).run(warnings);
}

} // namespace taut::app
