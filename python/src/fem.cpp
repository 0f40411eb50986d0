// The module `maille._fem`: finite elements for scenes of `maille._core`, whose types it shares.

#include "binding.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/plausibility.hpp"

namespace maille::python {

namespace {

AnswerHandle run(const SceneHandle& handle, const std::string& method, int threads,
                 std::optional<double> seconds, py::object progress) {
  if (method != "fem_q1" && method != "fem_q2")
    throw py::value_error("expected fem_q1 or fem_q2, found \"" + method + "\"");
  Steering steering(threads, seconds, {}, std::move(progress));
  AnswerHandle made{handle.asked, {}};
  {
    const py::gil_scoped_release unlocked;
    fem_ref::Options options;
    options.degree = method == "fem_q1" ? 1 : 2;
    made.answer = fem_ref::Solver(std::move(options)).solve(made.scene(), steering.control()).answer;
    fail_where_inside_out(made.scene(), made.answer);
  }
  // Once deal.II is loaded: what is registered last is called first.
  if (fem_ref::works_left_behind() > 0)
    skip_destructors_while([] { return fem_ref::works_left_behind() > 0; });
  steering.finish();
  return made;
}

} // namespace

} // namespace maille::python

PYBIND11_MODULE(_fem, module) {
  pybind11::module_::import("maille._core");
  module.def("run", &maille::python::run);
  module.def("works_left_behind", &maille::fem_ref::works_left_behind);
}
