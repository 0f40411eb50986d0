// The module `maille._core`: scene and deform for Python. The package `maille` around it gives names, types
// and words.

#include "binding.hpp"
#include "maille/materials/library.hpp"
#include "maille/materials/quantity.hpp"

namespace maille::python {

namespace {

/// maille.SceneFaults: ValueError with `faults`.
py::object* scene_faults = nullptr;

void raise_faults(const InputError& error) {
  py::list faults;
  for (const Fault& fault : error.faults())
    faults.append(py::make_tuple(fault.file, fault.line, fault.key, fault.expected, fault.found));
  const py::object raised = (*scene_faults)(error.what(), faults);
  PyErr_SetObject(scene_faults->ptr(), raised.ptr());
}

} // namespace

} // namespace maille::python

PYBIND11_MODULE(_core, module) {
  using namespace maille;
  using namespace maille::python;
  namespace py = pybind11;
  scene_faults =
      new py::object(py::module_::import("maille._faults").attr("SceneFaults")); // as long as the process
  py::register_exception_translator([](std::exception_ptr raised) {
    try {
      if (raised)
        std::rethrow_exception(raised);
    } catch (const InputError& error) {
      raise_faults(error);
    }
  });
  module.attr("knows_numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;
  module.def("materials", [] {
    std::vector<std::string> names;
    for (const LibraryEntry& entry : material_library())
      names.push_back(entry.material.name);
    return names;
  });
  module.def("length", [](const std::string& text) { return parse_quantity(text, Dimension::length); });
  bind_scenes(module);
  bind_fits(module);
  bind_answers(module);
  bind_warps(module);
  bind_worlds(module);
}
