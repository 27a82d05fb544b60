/// taut._taut: the compiled part of the Python package. What a user sees, with its documentation, is in ../taut/*.py.

#include "arrays.h"

#include "taut/base/error.h"

#include <tbb/global_control.h>

#include <memory>

namespace py = pybind11;

namespace {

/// All threads where `threads` is 0.
void limitThreads(int threads) {
    static std::unique_ptr<tbb::global_control> limit;
    limit.reset();
    if (threads < 0) taut::failInput({"threads"}, std::to_string(threads), "a number of threads, or 0 for all");
    if (threads > 0)
        limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
}

} // namespace

PYBIND11_MODULE(_taut, module) {
    module.doc() = "The compiled part of taut. Use the package's own functions, which say what they take.";
    module.attr("version") = TAUT_VERSION;
    py::register_exception<taut::InputError>(module, "InputError", PyExc_ValueError).doc() =
        "Bad input: one line that says what was found where, and what was expected.";
    py::register_exception<taut::RunError>(module, "RunError", PyExc_RuntimeError).doc() =
        "Something failed while running: a full disk, positions that are not finite.";
    module.def("limit_threads", limitThreads, py::arg("threads"),
               "Limits the threads of everything that taut computes to this many; 0: all of the machine's.");
    taut::python::addGloss(module);
    taut::python::addMicrosurface(module);
    taut::python::addImage(module);
    taut::python::addScene(module);
}
