#include "arrays.h"
namespace taut::python {
void addScene(py::module_ &) {}
} // namespace taut::python
