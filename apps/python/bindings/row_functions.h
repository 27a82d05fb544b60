#pragma once
/// Functions over rows of arrays: each argument is [n, width], or [1, width], which counts for every row.

#include "arrays.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/microsurface/transform.h"

#include <array>
#include <string>
#include <tuple>
#include <type_traits>
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
    [[nodiscard]] T numberAt(std::size_t row) const { return *at(row); }
    [[nodiscard]] Vector2<T> pairAt(std::size_t row) const { return {at(row)[0], at(row)[1]}; }
    [[nodiscard]] Vector3<T> vectorAt(std::size_t row) const {
        const T *v = at(row);
        return {v[0], v[1], v[2]};
    }
    /// A block [a b; c d] by rows.
    [[nodiscard]] BasicBlock<T> blockAt(std::size_t row) const {
        const T *b = at(row);
        return {b[0], b[1], b[2], b[3]};
    }
    /// A 3 x 3 matrix by rows.
    [[nodiscard]] DMat3 matrixAt(std::size_t row) const {
        DMat3 m;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) m[c][r] = static_cast<double>(at(row)[3 * r + c]);
        return m;
    }
};

/// Transforms: [a b d] or [a b d p q] a row.
template <class T> struct TransformRows : Rows<T> {
    /// Throws at the first row that is no transform.
    explicit TransformRows(const py::handle &argument) : Rows<T>(argument) {
        bool all = true;
        for (std::size_t row = 0; row < this->rows; ++row) all &= isTransform(row); // without a branch
        for (std::size_t row = 0; !all && row < this->rows; ++row)
            if (!isTransform(row))
                failInput({"M[" + std::to_string(row) + "]"},
                          "a = " + formatNumber(static_cast<double>(this->at(row)[0])) +
                              ", d = " + formatNumber(static_cast<double>(this->at(row)[2])),
                          "two numbers above 0 (taut.microsurface.canonical makes such an M of any 2 x 2 block)");
    }
    [[nodiscard]] bool isTransform(std::size_t row) const {
        const T *m = this->at(row);
        return (m[0] > 0) & (m[2] > 0);
    }
    [[nodiscard]] BasicMicroTransform<T> transformAt(std::size_t row) const {
        const T *m = this->at(row);
        const bool leans = this->width > 3;
        return {m[0], m[1], m[2], leans ? m[3] : T(0), leans ? m[4] : T(0), 1 / m[0], 1 / m[2], m[0] * m[2]};
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

/// A column of a result: a number a row, or several, as `C` is one cell of it.
template <class C> struct Column {
    using Number = C;
    static constexpr std::size_t kWidth = 0;
    static void put(Number *to, const C &cell) { *to = cell; }
};
template <class T, std::size_t N> struct Column<std::array<T, N>> {
    using Number = T;
    static constexpr std::size_t kWidth = N;
    static void put(T *to, const std::array<T, N> &cell) { std::copy(cell.begin(), cell.end(), to); }
};
template <class T> struct Column<Vector3<T>> {
    using Number = T;
    static constexpr std::size_t kWidth = 3;
    static void put(T *to, const Vector3<T> &cell) {
        for (int c = 0; c < 3; ++c) to[c] = cell[c];
    }
};
template <class T> struct Column<BasicMicroTransform<T>> {
    using Number = T;
    static constexpr std::size_t kWidth = 5;
    static void put(T *to, const BasicMicroTransform<T> &m) {
        for (const T value : {m.a, m.b, m.d, m.p, m.q}) *to++ = value;
    }
};

/// New arrays, one a column.
template <class... C> class Table {
  public:
    explicit Table(std::size_t rows) : arrays_(newRows<typename Column<C>::Number>(rows, Column<C>::kWidth)...) {
        std::apply([this](auto &...array) { data_ = std::tuple(array.mutable_data()...); }, arrays_);
    }
    void put(std::size_t row, const C &...cells) const {
        std::apply([&](auto *...to) { (Column<C>::put(to + row * std::max<std::size_t>(Column<C>::kWidth, 1), cells), ...); }, data_);
    }
    void put(std::size_t row, const std::tuple<C...> &cells) const {
        std::apply([&](const C &...cell) { put(row, cell...); }, cells);
    }
    /// The array, or a tuple of them.
    [[nodiscard]] py::object result() const {
        if constexpr (sizeof...(C) == 1)
            return std::get<0>(arrays_);
        else
            return std::apply([](const auto &...array) -> py::object { return py::make_tuple(array...); }, arrays_);
    }

  private:
    std::tuple<Array<typename Column<C>::Number>...> arrays_;
    std::tuple<typename Column<C>::Number *...> data_;
};
template <class R> struct TableFor { using Type = Table<R>; };
template <class... C> struct TableFor<std::tuple<C...>> { using Type = Table<C...>; };

/// What f(row) returns for all rows: a cell, as an array, or a tuple of cells, as a tuple of arrays.
template <class F> py::object tableOf(std::size_t count, const F &f) {
    const typename TableFor<std::invoke_result_t<F, std::size_t>>::Type table(count);
    forRows(count, [&](std::size_t row) { table.put(row, f(row)); });
    return table.result();
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
