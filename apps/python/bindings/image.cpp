/// Pictures to and from files.

#include "arrays.h"
#include "scene_tree.h"

#include "study/measures/image_error.h"
#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <pybind11/stl.h>

namespace taut::python {

void addImage(py::module_ &module) {
    py::class_<ImageSettings>(module, "ImageSettings").def(py::init<>());
    module.def(
        "write_image",
        [](const std::string &path, const Array<float> &pixels, const std::vector<std::string> &channels, const Metadata &metadata,
           const ImageSettings &given, const py::object &image, const std::string &folder) {
            if (!isImagePath(path)) failInput({"path"}, quoted(path), "a file name that ends in .exr or .png");
            const ImageSettings settings = readImageSettings(treeOf(image, "image"), given, folder);
            checkCompressionOf(settings.exrCompression, channels);
            const auto height = static_cast<int>(pixels.shape(0));
            const auto width = static_cast<int>(pixels.shape(1));
            const Image whole{{0, 0, width, height}, width, height, channels, {pixels.data(), pixels.data() + pixels.size()}};
            const py::gil_scoped_release unlocked;
            writeImage(path, whole, metadata, settings);
        },
        py::arg("path"), py::arg("pixels").noconvert(), py::arg("channels"), py::arg("metadata"), py::arg("settings"), py::arg("image"),
        py::arg("folder"));
    module.def(
        "relative_error",
        [](const Array<float> &image, const Array<float> &reference, int box) {
            const auto values = [&](const Array<float> &pixels) {
                return chart::boxed({pixels.data(), static_cast<std::size_t>(pixels.size())}, static_cast<int>(pixels.shape(1)),
                                    static_cast<int>(pixels.shape(0)), box);
            };
            return chart::relativeMse(values(image), values(reference));
        },
        py::arg("image").noconvert(), py::arg("reference").noconvert(), py::arg("box"));
    module.def(
        "read_image",
        [](const std::string &path) {
            Image image;
            {
                const py::gil_scoped_release unlocked;
                image = readImage(path);
            }
            Array<float> pixels({static_cast<py::ssize_t>(image.window.height()), static_cast<py::ssize_t>(image.window.width()),
                                 static_cast<py::ssize_t>(image.channels.size())});
            std::copy(image.values.begin(), image.values.end(), pixels.mutable_data());
            return py::make_tuple(pixels, image.channels);
        },
        py::arg("path"));
}

} // namespace taut::python
