#include "scene_render.h"

#include "taut_app.h"

#include "../../taut/denoised_image.h"
#include "../../taut/image_output.h"

#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"
#include "taut/export/gloss_export.h"
#include "taut/pilot/plan_by_pilots.h"

#include <pybind11/stl.h>

#include <cmath>
#include <condition_variable>
#include <sstream>
#include <thread>

namespace taut::python {

namespace {

constexpr auto kSignalsEvery = std::chrono::milliseconds(10);

/// Frees the interpreter's lock, then waits for the scene.
class Alone {
  public:
    explicit Alone(Busy &busy) : busy_(notOurs(busy)) {
        busy_.mutex.lock();
        busy_.owner = std::this_thread::get_id();
    }
    Alone(const Alone &) = delete;
    Alone &operator=(const Alone &) = delete;
    ~Alone() {
        busy_.owner = std::thread::id();
        busy_.mutex.unlock();
    }

  private:
    static Busy &notOurs(Busy &busy) {
        if (busy.owner == std::this_thread::get_id())
            throw RunError("scene: used by a function that it has called; wait until that is over");
        return busy;
    }
    Busy &busy_;
    py::gil_scoped_release unlocked_; // once that is known
};

Array<float> arrayOf(std::size_t rows, const VertexAttribute &attribute) {
    const auto width = static_cast<std::size_t>(attribute.width);
    Array<float> out = newRows<float>(rows, attribute.width > 1 ? width : 0);
    float *to = out.mutable_data();
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t c = 0; c < width; ++c) to[row * width + c] = attribute.data[row * attribute.stride + c];
    return out;
}

template <class V> Array<float> arrayOf(const std::vector<V> &values) {
    constexpr auto kWidth = static_cast<std::size_t>(V::length());
    return arrayOf(values.size(), {"", static_cast<int>(kWidth), kWidth, values.empty() ? nullptr : &values.front()[0]});
}

} // namespace

PythonScene::PythonScene(Scene scene, Warnings warnings, PlanOptions plan, bool pointsOfPython)
    : loaded_(std::move(scene)), warnings_(std::move(warnings)), planOptions_(plan), planned_(plan.full || !pointsOfPython) {}

bool PythonScene::isPlanned(double frame) const {
    const auto [first, last] = std::minmax_element(scene().render.frames.begin(), scene().render.frames.end());
    return planOptions_.full || (planned_ && frame >= *first && frame <= *last);
}

std::vector<std::string> PythonScene::warnings() const {
    const std::lock_guard lock(warningsLock_);
    return warnings_.lines;
}

void PythonScene::warn(const Warnings &more) {
    const std::lock_guard lock(warningsLock_);
    for (const std::string &line : more.lines) warnings_.add(line);
}

RenderScene &PythonScene::ready(bool planned) {
    if (ready_ && planned_ == planned) return *ready_;
    // A function of Python may throw on the way, and the scene must outlive that: it is taken over as a copy.
    Scene copy = scene();
    const bool animated = copy.render.frames.size() > 1 || std::any_of(copy.objects.begin(), copy.objects.end(), moves);
    if (!isGrounded_) {
        Warnings found;
        ground_ = standOnGround(copy, found);
        warn(found);
        isGrounded_ = true;
    } else if (ground_) {
        standOn(*ground_, copy);
    }
    ScenePlan plan = planned ? planByPilots(copy, planOptions_).plan : defaultPlan(copy);
    ready_ = std::make_shared<RenderScene>(std::move(copy), std::move(plan), animated);
    planned_ = planned;
    return *ready_;
}

Index PythonScene::objectNamed(const std::string &name) const {
    const std::vector<Object> &objects = scene().objects;
    std::vector<std::string_view> names;
    for (Index i = 0; i < objects.size(); ++i) {
        if (objects[i].name == name) return i;
        names.emplace_back(objects[i].name);
    }
    if (name.empty() && objects.size() == 1) return 0;
    if (name.empty()) failInput({"object"}, "none of " + std::to_string(objects.size()), "a name");
    failUnknownName({"object"}, name, names);
}

std::string PythonScene::plan() {
    const Alone alone(busy_);
    PlanOptions options = planOptions_;
    options.report = true;
    Scene copy = scene();
    PlannedScene planned = planByPilots(copy, options);
    if (!planned_) planned.plan = defaultPlan(copy);
    const bool animated = copy.render.frames.size() > 1;
    std::vector<ObjectSurface> surfaces; // those of the plan, where it is the plan's model that is told of
    if (planned_) surfaces = std::move(planned.surfaces);
    const RenderScene reported(std::move(copy), std::move(planned.plan), animated, std::move(surfaces));
    return app::planText(reported, planned.fields);
}

std::string PythonScene::exportFiles(const std::vector<std::string> &outputs, const std::string &frames,
                                     const std::vector<std::string> &objects, const std::string &convention, const std::string &positions,
                                     const std::string &space, bool ascii) {
    const Alone alone(busy_);
    Scene copy = scene();
    if (!frames.empty()) copy.render.frames = parseFrameSet(frames, {"frames"});
    Warnings found;
    std::string text = app::exportText(copy, outputs, objects, convention, positions, space, ascii, found);
    warn(found);
    return text;
}

py::dict PythonScene::glossAt(double frame, const std::string &name) {
    GlossObject gloss;
    {
        const Alone alone(busy_);
        prepareGlossObject(scene(), scene().objects[objectNamed(name)], gloss);
        glossAtFrame(scene(), frame, {}, gloss);
    }
    const GlossMesh &mesh = gloss.mesh;
    py::dict out;
    out["P"] = arrayOf(mesh.positions);
    out["N"] = arrayOf(mesh.normals);
    if (!mesh.uvs.empty()) out["st"] = arrayOf(mesh.uvs);
    for (const VertexAttribute &attribute : vertexAttributes(mesh))
        if (attribute.name.rfind("M", 0) != 0) out[py::str(attribute.name)] = arrayOf(mesh.vertexCount(), attribute);
    Array<float> m = newRows<float>(mesh.vertexCount(), 5);
    Array<std::int32_t> faces = newRows<std::int32_t>(mesh.triangles.size(), 3);
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        const std::array<float, 5> row{mesh.m[v].x, mesh.m[v].y, mesh.m[v].z, mesh.lean[v].x, mesh.lean[v].y};
        std::copy(row.begin(), row.end(), m.mutable_data() + 5 * v);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            faces.mutable_data()[3 * t + static_cast<std::size_t>(k)] = static_cast<std::int32_t>(mesh.triangles[t][k]);
    out["M"] = m;
    out["faces"] = faces;
    return out;
}

void PythonScene::setPoints(const std::string &object, std::shared_ptr<const PointSource> points) {
    const Alone alone(busy_);
    ++changes_;
    const Index index = objectNamed(object);
    ready(planOptions_.full).setPoints(index, points);
    loaded_.objects[index].points = std::move(points);
}

void PythonScene::stop() {
    const std::lock_guard<std::mutex> lock(goingMutex_);
    if (going_ != nullptr) going_->stop();
}

Refinement::Refinement(std::shared_ptr<PythonScene> scene, const RefinementOptions &options) : scene_(std::move(scene)) {
    const Alone alone(scene_->busy_);
    FilmContents contents = filmContentsNamed(options.aovs, "aovs");
    FrameOptions frameOptions;
    frameOptions.aovs = std::move(contents.aovs);
    frameOptions.layers = std::move(contents.layers);
    ++scene_->changes_;
    RenderScene &ready = scene_->ready(scene_->isPlanned(options.frame));
    ready_ = scene_->ready_;
    const RenderSettings &render = ready.scene().render;
    frameOptions.spp = options.spp > 0 ? options.spp : render.spp;
    frameOptions.firstSample = options.firstSample;
    frameOptions.noise = options.noise;
    frameOptions.window = {options.crop[0], options.crop[1], options.crop[2], options.crop[3]};
    const Window &crop = frameOptions.window;
    if (crop != Window{} && (crop.empty() || crop.x0 < 0 || crop.y0 < 0 || crop.x1 > render.width || crop.y1 > render.height))
        failInput({"crop"}, "another part of the picture",
                  "(x0, y0, x1, y1) with 0 <= x0 < x1 <= " + std::to_string(render.width) +
                      " and 0 <= y0 < y1 <= " + std::to_string(render.height));
    frameOptions.seed = frameSeed(options.seed.value_or(render.seed), static_cast<int>(std::lround(options.frame)), render.fixedSeed);
    if (options.denoiser) {
        PythonDenoiser &denoiser = *options.denoiser;
        frameOptions.denoiseBlock = denoiseBlockOf(frameOptions.spp, !options.isTimed && !options.noise);
        if (denoiser.denoiser.overFrames() && denoiser.before) {
            ready.setFrame(*denoiser.before);
            frameOptions.before = &before_.emplace(ready);
        }
        denoiser_ = options.denoiser;
    }
    frame_ = options.frame;
    ready.setFrame(options.frame);
    change_ = scene_->changes_;
    render_ = std::make_unique<FrameRender>(ready, frameOptions);
}

void Refinement::checkCurrent() const {
    if (change_ != scene_->changes_)
        throw RunError("refinement: its scene has gone on to another frame or other points; ask the scene for a new one");
}

std::string Refinement::advance(int samples, double seconds, const py::object &progress) {
    FrameState state = FrameState::Going;
    std::exception_ptr failure;
    bool over = false;
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<Alone> alone;
    alone.emplace(scene_->busy_);
    checkCurrent();
    {
        const std::lock_guard<std::mutex> lock(scene_->goingMutex_);
        scene_->going_ = render_.get();
    }
    std::thread worker([&] {
        try {
            state = render_->advance({samples, seconds});
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard<std::mutex> lock(mutex);
        over = true;
        changed.notify_all();
    });
    // Signals and functions of Python are this thread's to run.
    std::exception_ptr fromPython;
    const auto ask = [&] {
        const py::gil_scoped_acquire locked;
        try {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            if (progress.is_none()) return;
            const py::object answer = progress(render_->share());
            if (py::isinstance<py::bool_>(answer) && !py::cast<bool>(answer)) render_->stop();
        } catch (...) {
            fromPython = std::current_exception();
            render_->stop();
        }
    };
    for (std::unique_lock<std::mutex> lock(mutex); !over;) {
        if (changed.wait_for(lock, kSignalsEvery, [&] { return over; })) break;
        lock.unlock();
        if (!fromPython) ask();
        lock.lock();
    }
    worker.join();
    if (!fromPython) ask();
    {
        const std::lock_guard<std::mutex> lock(scene_->goingMutex_);
        scene_->going_ = nullptr;
    }
    alone.reset();
    if (fromPython) std::rethrow_exception(fromPython);
    if (failure) std::rethrow_exception(failure);
    return state == FrameState::Done ? "done" : state == FrameState::Stopped ? "stopped" : "going";
}

namespace {

py::tuple pictureOf(const Film &film, const Image &image, const Metadata &metadata) {
    const Window &window = film.window();
    const auto width = static_cast<py::ssize_t>(window.width());
    const auto height = static_cast<py::ssize_t>(window.height());
    Array<float> pixels({height, width, static_cast<py::ssize_t>(image.channels.size())});
    std::copy(image.values.begin(), image.values.end(), pixels.mutable_data());
    Array<std::uint32_t> samples({height, width});
    std::uint32_t *to = samples.mutable_data();
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) *to++ = film.samplesAt(x, y);
    return py::make_tuple(pixels, image.channels, samples, metadata);
}

} // namespace

py::tuple Refinement::film() const {
    const Film film = render_->film();
    return pictureOf(film, imageOf(film, ready_->scene().render), metadataOf(film));
}

py::tuple Refinement::denoised() {
    const Film film = render_->film();
    Image image = imageOf(film, ready_->scene().render);
    {
        const py::gil_scoped_release unlocked;
        app::addDenoised(film, denoiser_->denoiser, image);
    }
    denoiser_->before = frame_;
    Metadata metadata = metadataOf(film);
    app::markDenoised(metadata, denoiser_->denoiser.overFrames());
    return pictureOf(film, image, metadata);
}

/// What a file says of the picture.
Metadata Refinement::metadataOf(const Film &film) const {
    Metadata all = app::frameMetadata(ready_->scene(), frame_, film.layers());
    const Metadata ofSamples = app::sampleMetadata(film);
    all.insert(all.end(), ofSamples.begin(), ofSamples.end());
    return all;
}

void Refinement::save(const std::string &path) const {
    const Alone alone(scene_->busy_);
    std::ostringstream bytes;
    render_->save(bytes);
    writeFileWhole(path, bytes.str());
}

void Refinement::restore(const std::string &path) {
    const Alone alone(scene_->busy_);
    checkCurrent();
    std::istringstream bytes(readFileBytes(path));
    render_->restore(bytes);
}

} // namespace taut::python
