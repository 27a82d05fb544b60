#pragma once
/// A scene file as Python has it: dicts, lists, numbers, strings, arrays; and meshes that move by arrays or functions of Python.

#include "mesh_arrays.h"

#include "taut/scene/load_scene.h"

#include <pybind11/functional.h>

namespace taut::python {

/// A Python object that C++ may keep and drop on any thread.
using Kept = std::shared_ptr<const py::object>;
Kept keep(py::object object);

/// Values of a scene file. `where` is the place that errors name: "mesh[0].material".
TomlValue treeOf(const py::handle &value, const std::string &where, int depth = 0);

/// Positions by a function of Python: called with the frame, it returns [points, 3], which is read in place. What it throws comes out.
std::shared_ptr<const PointSource> callbackPoints(std::size_t points, py::function function);
/// Positions by arrays of Python, [points, 3] each, read in place.
std::shared_ptr<const PointSource> arrayPoints(const std::vector<Array<float>> &frames, double firstFrame);

} // namespace taut::python
