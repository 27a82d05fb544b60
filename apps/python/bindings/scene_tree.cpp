#include "scene_tree.h"

#include "taut/base/error.h"

namespace taut::python {

namespace {

/// One user's way through a function of Python: what it returned last is kept while it is read.
class CallbackReader final : public PointReader {
  public:
    explicit CallbackReader(Kept function) : function_(std::move(function)) {}
    std::span<const Vec3> at(double frame, double /*fps*/) override {
        const py::gil_scoped_acquire locked;
        const auto positions = py::cast<Array<float>>((*function_)(frame));
        last_ = keep(positions);
        return rowsOf<Vec3>(positions);
    }

  private:
    Kept function_, last_;
};

class CallbackSource final : public PointSource {
  public:
    CallbackSource(std::size_t points, Kept function) : points_(points), function_(std::move(function)) {}
    [[nodiscard]] std::size_t points() const override { return points_; }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<CallbackReader>(function_); }

  private:
    std::size_t points_;
    Kept function_;
};

/// A source of the caller's arrays that keeps them.
class KeepingSource final : public PointSource {
  public:
    KeepingSource(std::shared_ptr<const PointSource> source, Kept arrays) : source_(std::move(source)), arrays_(std::move(arrays)) {}
    [[nodiscard]] std::size_t points() const override { return source_->points(); }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return source_->open(); }

  private:
    std::shared_ptr<const PointSource> source_;
    Kept arrays_;
};

/// Of values in values: a dict that holds itself has no end.
constexpr int kDeepest = 64;

TomlValue tomlTableOf(const py::dict &dict, const std::string &where, int depth) {
    TomlValue table;
    table.where = {where.empty() ? "scene" : where};
    for (const auto &[key, value] : dict) {
        if (!py::isinstance<py::str>(key)) failInput(table.where, std::string(py::repr(key)) + " for a key", "a string");
        const auto name = py::cast<std::string>(key);
        const std::string place = where.empty() ? name : where + "." + name;
        TomlEntry entry;
        entry.key = name;
        entry.where.file = place;
        entry.value = treeOf(value, place, depth + 1);
        table.entries.push_back(std::move(entry));
    }
    return table;
}

TomlValue arrayOf(const py::sequence &sequence, const std::string &where, int depth) {
    TomlValue array;
    array.kind = TomlValue::Kind::Array;
    array.where = {where};
    std::size_t number = 0;
    for (const py::handle &item : sequence) array.items.push_back(treeOf(item, where + "[" + std::to_string(number++) + "]", depth + 1));
    return array;
}

} // namespace

Kept keep(py::object object) {
    return {new py::object(std::move(object)), [](const py::object *kept) {
                if (Py_IsInitialized() == 0) return; // the interpreter is gone, and the object with it
                const py::gil_scoped_acquire locked;
                delete kept;
            }};
}

TomlValue treeOf(const py::handle &given, const std::string &where, int depth) {
    if (depth > kDeepest)
        failInput({where.substr(0, 80)}, "values in values without an end", "at most " + std::to_string(kDeepest) + " levels");
    py::object value = py::reinterpret_borrow<py::object>(given);
    if (py::hasattr(value, "tolist")) value = value.attr("tolist")(); // arrays and numbers of numpy
    if (py::hasattr(value, "__fspath__")) value = value.attr("__fspath__")();
    TomlValue out;
    out.where = {where};
    if (py::isinstance<py::dict>(value)) return tomlTableOf(py::cast<py::dict>(value), where, depth);
    if (py::isinstance<py::bool_>(value)) {
        out.kind = TomlValue::Kind::Boolean;
        out.boolean = py::cast<bool>(value);
    } else if (py::isinstance<py::int_>(value)) {
        int overflow = 0;
        out.kind = TomlValue::Kind::Integer;
        out.integer = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
        if (overflow != 0) failInput(out.where, std::string(py::str(value)), "a number of 64 bits");
        out.number = static_cast<double>(out.integer);
    } else if (py::isinstance<py::float_>(value)) {
        out.kind = TomlValue::Kind::Number;
        out.number = py::cast<double>(value);
    } else if (py::isinstance<py::str>(value)) {
        out.kind = TomlValue::Kind::String;
        out.text = py::cast<std::string>(value);
    } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
        return arrayOf(py::cast<py::sequence>(value), where, depth);
    } else {
        failInput(out.where, std::string(py::str(py::type::of(value).attr("__name__"))) + " " + quoted(std::string(py::repr(value))),
                  "a number, a string, a list, a dict or an array");
    }
    return out;
}

std::shared_ptr<const PointSource> callbackPoints(std::size_t points, py::function function) {
    return std::make_shared<CallbackSource>(points, keep(std::move(function)));
}

std::shared_ptr<const PointSource> arrayPoints(const std::vector<Array<float>> &frames, double firstFrame) {
    std::vector<std::span<const Vec3>> spans;
    py::list arrays;
    for (const Array<float> &frame : frames) {
        spans.push_back(rowsOf<Vec3>(frame));
        arrays.append(frame);
    }
    return std::make_shared<KeepingSource>(pointFrames(std::move(spans), firstFrame), keep(std::move(arrays)));
}

} // namespace taut::python
