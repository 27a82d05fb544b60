#pragma once
/// numpy arrays as the library takes them. Nothing is converted here: an argument of another type or layout is refused, and the Python
/// side (taut/_arrays.py) makes, and counts, the copies that are needed.

#include "taut/base/vec.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <span>

namespace taut::python {

namespace py = pybind11;

/// C-contiguous.
template <class T> using Array = py::array_t<T, py::array::c_style>;

/// The rows of an array [n, columns of V], as they lie in memory.
template <class V> std::span<const V> rowsOf(const Array<typename V::value_type> &array) {
    static_assert(sizeof(V) == sizeof(typename V::value_type) * static_cast<std::size_t>(V::length()));
    const auto columns = static_cast<std::size_t>(V::length());
    return {reinterpret_cast<const V *>(array.data()), static_cast<std::size_t>(array.size()) / columns};
}
template <class T> std::span<const T> valuesOf(const Array<T> &array) {
    return {array.data(), static_cast<std::size_t>(array.size())};
}

/// A new array [rows, columns], or [rows] where `columns` is 0; not filled.
template <class T> Array<T> newRows(std::size_t rows, std::size_t columns) {
    if (columns == 0) return Array<T>(static_cast<py::ssize_t>(rows));
    return Array<T>({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns)});
}

// Each adds its part to the module.
void addGloss(py::module_ &module);
void addMicrosurface(py::module_ &module);
void addScene(py::module_ &module);
void addImage(py::module_ &module);

} // namespace taut::python
