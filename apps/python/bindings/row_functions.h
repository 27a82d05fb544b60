#pragma once
/// Functions over rows of arrays: each argument is [n, width], or [1, width], which counts for every row.

#include "arrays.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/microsurface/transform.h"

#include <array>
#include <atomic>
#include <string>
#include <vector>

namespace taut::python {

inline constexpr std::size_t kRowGrain = 1024;

/// One argument. Its array lives as long as the call's arguments do.
template <class T> struct Rows {
    const T *data = nullptr;
    std::size_t rows = 0, width = 1;
    explicit Rows(const py::handle &argument) {
        const auto array = py::cast<Array<T>>(argument);
        data = array.data();
        rows = static_cast<std::size_t>(array.ndim() > 0 ? array.shape(0) : 1);
        width = array.ndim() > 1 ? static_cast<std::size_t>(array.shape(1)) : 1;
    }
    [[nodiscard]] const T *at(std::size_t row) const { return data + (rows == 1 ? 0 : row * width); }
    [[nodiscard]] Vector3<T> vectorAt(std::size_t row) const {
        const T *v = at(row);
        return {v[0], v[1], v[2]};
    }
};

/// Transforms: [a b d] or [a b d p q] a row.
template <class T> struct TransformRows : Rows<T> {
    using Rows<T>::Rows;
    [[nodiscard]] bool isTransform(std::size_t row) const {
        const T *m = this->at(row);
        return (m[0] > 0) & (m[2] > 0);
    }
    [[nodiscard]] BasicMicroTransform<T> transformAt(std::size_t row) const {
        const T *m = this->at(row);
        const bool leans = this->width > 3;
        return {m[0], m[1], m[2], leans ? m[3] : T(0), leans ? m[4] : T(0), 1 / m[0], 1 / m[2], m[0] * m[2]};
    }
    /// Throws at the first row that is none.
    void check() const {
        bool all = true;
        for (std::size_t row = 0; row < this->rows; ++row) all &= isTransform(row); // without a branch
        for (std::size_t row = 0; !all && row < this->rows; ++row)
            if (!isTransform(row))
                failInput({"M[" + std::to_string(row) + "]"},
                          "a = " + formatNumber(static_cast<double>(this->at(row)[0])) +
                              ", d = " + formatNumber(static_cast<double>(this->at(row)[2])),
                          "two numbers above 0 (taut.microsurface.canonical makes such an M of any 2 x 2 block)");
    }
};

/// The number of rows of a call.
template <class... R> std::size_t rowCount(const R &...arguments) {
    std::size_t count = 1;
    bool empty = false;
    ((empty = empty || arguments.rows == 0, count = std::max(count, arguments.rows)), ...);
    return empty ? 0 : count;
}

/// Calls f(row) for all rows, on all threads, without the interpreter's lock.
template <class F> void forRows(std::size_t count, const F &f) {
    const py::gil_scoped_release unlocked;
    parallelFor(count, kRowGrain, f);
}

/// Whether an argument is an array of doubles. All arguments of a call are of one type.
inline bool isDouble(const py::handle &argument) {
    return py::isinstance<py::array_t<double>>(argument);
}

/// f<T>() by the type of the arguments.
template <class F> py::object byType(const py::handle &argument, const F &f) {
    return isDouble(argument) ? f.template operator()<double>() : f.template operator()<float>();
}

} // namespace taut::python
