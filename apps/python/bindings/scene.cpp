/// taut.Scene's compiled part.

#include "scene_render.h"

#include "taut/base/frame_set.h"

#include <pybind11/stl.h>

namespace taut::python {

namespace {

/// A mesh of arrays: (rest, starts, corners, uvs, normals, points, first frame, face materials, material names), points None, arrays or
/// a function of the frame.
GivenMesh givenMesh(const py::tuple &given, double firstFrame) {
    const auto optional = [](const py::handle &value) {
        return value.is_none() ? std::nullopt : std::make_optional(py::cast<Array<float>>(value));
    };
    MeshArrays arrays{py::cast<Array<float>>(given[0]), py::cast<Array<std::uint32_t>>(given[1]), py::cast<Array<std::uint32_t>>(given[2]),
                      optional(given[3]), optional(given[4])};
    if (!given[7].is_none()) {
        arrays.faceMaterials = py::cast<Array<std::uint32_t>>(given[7]);
        arrays.materialNames = py::cast<std::vector<std::string>>(given[8]);
    }
    GivenMesh mesh{meshOf("mesh", arrays), nullptr};
    const py::object points = given[5];
    if (py::isinstance<py::function>(points))
        mesh.points = callbackPoints(mesh.mesh->positions.size(), points);
    else if (!points.is_none())
        mesh.points = arrayPoints(py::cast<std::vector<Array<float>>>(points), firstFrame);
    return mesh;
}

PlanOptions planOptionsOf(const std::string &model, const std::optional<float> &tolerance) {
    static constexpr std::string_view kModels[] = {"auto", "full"};
    if (model != "auto" && model != "full") failUnknownName({"model"}, model, kModels);
    if (tolerance && !(*tolerance >= 1e-6F && *tolerance <= 1)) failInput({"tolerance"}, formatNumber(*tolerance), "a number in [1e-6, 1]");
    PlanOptions options;
    options.tolerance = tolerance;
    options.full = model == "full";
    return options;
}

std::shared_ptr<PythonScene> loadPythonScene(const py::object &source, const std::string &folder,
                                             const std::map<std::string, py::tuple> &given, const std::vector<std::string> &overrides,
                                             const std::string &model, const std::optional<float> &tolerance) {
    const PlanOptions options = planOptionsOf(model, tolerance);
    Warnings warnings;
    if (py::isinstance<py::str>(source)) {
        const auto path = py::cast<std::string>(source);
        const py::gil_scoped_release unlocked;
        Scene scene = loadScene(path, overrides, warnings);
        return std::make_shared<PythonScene>(std::move(scene), std::move(warnings), options, false);
    }
    SceneTree tree{treeOf(source, ""), "scene", folder, {}};
    for (const auto &[name, mesh] : given) tree.meshes.emplace(name, givenMesh(mesh, py::cast<double>(mesh[6])));
    const bool points = std::any_of(tree.meshes.begin(), tree.meshes.end(), [](const auto &mesh) { return mesh.second.points != nullptr; });
    const py::gil_scoped_release unlocked;
    Scene scene = loadScene(std::move(tree), overrides, warnings);
    return std::make_shared<PythonScene>(std::move(scene), std::move(warnings), options, points);
}

/// (name, its channels in a film) of every AOV.
py::list aovChannels() {
    py::list aovs;
    for (const AovInfo &info : aovTable())
        aovs.append(py::make_tuple(std::string(info.name), std::vector<std::string>(info.channels.begin(), info.channels.end())));
    return aovs;
}

} // namespace

void addScene(py::module_ &module) {
    py::class_<PythonScene, std::shared_ptr<PythonScene>>(module, "Scene")
        .def(py::init(&loadPythonScene), py::arg("source"), py::arg("folder"), py::arg("given"), py::arg("overrides"), py::arg("model"),
             py::arg("tolerance"))
        .def_property_readonly("warnings", &PythonScene::warnings)
        .def_property_readonly("size", [](const PythonScene &s) { return py::make_tuple(s.scene().render.width, s.scene().render.height); })
        .def_property_readonly("spp", [](const PythonScene &s) { return s.scene().render.spp; })
        .def_property_readonly("image", [](const PythonScene &s) { return s.scene().image; })
        .def_property_readonly("fixed_seed", [](const PythonScene &s) { return s.scene().render.fixedSeed; })
        .def_property_readonly("fps", [](const PythonScene &s) { return s.scene().render.fps; })
        .def_property_readonly("frames", [](const PythonScene &s) { return s.scene().render.frames; })
        .def_property_readonly("objects",
                               [](const PythonScene &s) {
                                   std::vector<std::string> names;
                                   for (const Object &object : s.scene().objects) names.push_back(object.name);
                                   return names;
                               })
        .def("plan", &PythonScene::plan)
        .def("export", &PythonScene::exportFiles, py::arg("outputs"), py::arg("frames"), py::arg("objects"), py::arg("convention"),
             py::arg("positions"), py::arg("space"), py::arg("ascii"))
        .def("gloss", &PythonScene::glossAt, py::arg("frame"), py::arg("object"))
        .def(
            "set_points",
            [](PythonScene &scene, const std::string &object, const std::vector<Array<float>> &frames, double firstFrame) {
                scene.setPoints(object, arrayPoints(frames, firstFrame));
            },
            py::arg("object"), py::arg("frames"), py::arg("first_frame"))
        .def("stop", &PythonScene::stop);
    py::class_<PythonDenoiser, std::shared_ptr<PythonDenoiser>>(module, "Denoiser").def(py::init<bool>(), py::arg("over_frames"));
    py::class_<Refinement>(module, "Refinement")
        .def(py::init([](std::shared_ptr<PythonScene> scene, double frame, int spp, int firstSample, const std::optional<double> &noise,
                         const std::array<int, 4> &crop, const std::vector<std::string> &aovs, const std::optional<std::uint32_t> &seed,
                         std::shared_ptr<PythonDenoiser> denoiser, bool isTimed) {
                 return std::make_unique<Refinement>(
                     std::move(scene), RefinementOptions{frame, spp, firstSample, noise, crop, aovs, seed, std::move(denoiser), isTimed});
             }),
             py::arg("scene"), py::arg("frame"), py::arg("spp"), py::arg("first_sample"), py::arg("noise"), py::arg("crop"),
             py::arg("aovs"), py::arg("seed"), py::arg("denoiser"), py::arg("is_timed"))
        .def("advance", &Refinement::advance, py::arg("samples"), py::arg("seconds"), py::arg("progress"))
        .def("stop", &Refinement::stop)
        .def_property_readonly("done", &Refinement::done)
        .def_property_readonly("share", &Refinement::share)
        .def("film", &Refinement::film)
        .def("denoised", &Refinement::denoised)
        .def("save", &Refinement::save, py::arg("path"))
        .def("restore", &Refinement::restore, py::arg("path"));
    module.attr("aovs") = aovChannels();
}

} // namespace taut::python
