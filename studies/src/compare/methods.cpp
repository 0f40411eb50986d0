#include "maille/studies/methods.hpp"

#include "maille/deform/solve.hpp"
#include "maille/studies/export/calculix.hpp"

#include <algorithm>

namespace maille::studies {

std::vector<std::string> all_methods() {
  std::vector<std::string> names;
  for (const Method method : every_method)
    names.emplace_back(to_string(method));
  return names;
}

bool is_method(std::string_view name) {
  return method_from_string(name).has_value();
}

Methods::Methods(fem_ref::LinearSolver solver, bool recover_stress) : solver_(solver) {
  for (int degree = 1; degree <= 2; ++degree) {
    fem_ref::Options options;
    options.degree = degree;
    options.solver = solver;
    options.recover_stress = recover_stress;
    of_degree_[static_cast<std::size_t>(degree) - 1] = std::make_unique<fem_ref::Solver>(std::move(options));
  }
}

Methods::~Methods() = default;

Answer Methods::answer(const Scene& scene, std::string_view name, const Control& control) {
  const auto method = method_from_string(name);
  if (method == Method::calculix)
    return solve_by_calculix(scene, control);
  if (method == Method::fem_q1 || method == Method::fem_q2)
    return of_degree_[method == Method::fem_q1 ? 0 : 1]->solve(scene, control).answer;
  return deform::solve(scene, name, control);
}

Answer answer_by(const Scene& scene, std::string_view name, const Control& control) {
  return Methods().answer(scene, name, control);
}

std::string default_reference(const std::vector<std::string>& methods) {
  const bool fine = std::find(methods.begin(), methods.end(), "fem_q2") != methods.end();
  return fine ? "fem_q2" : "fem_q1";
}

} // namespace maille::studies
