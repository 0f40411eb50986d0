#include "maille/studies/methods.hpp"

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/studies/export/calculix.hpp"

#include <algorithm>

namespace maille::studies {

std::vector<std::string> all_methods() {
  std::vector<std::string> names(deform::methods().begin(), deform::methods().end());
  names.insert(names.end(), {"fem_q1", "fem_q2", "calculix"});
  return names;
}

bool is_method(std::string_view name) {
  const auto names = all_methods();
  return std::find(names.begin(), names.end(), name) != names.end();
}

Answer answer_by(const Scene& scene, std::string_view name, const Control& control) {
  if (name == "calculix")
    return solve_by_calculix(scene, control);
  if (name != "fem_q1" && name != "fem_q2")
    return deform::solve(scene, name, control);
  fem_ref::Options options;
  options.degree = name == "fem_q1" ? 1 : 2;
  return fem_ref::solve(scene, options, control).answer;
}

std::string default_reference(const std::vector<std::string>& methods) {
  const bool fine = std::find(methods.begin(), methods.end(), "fem_q2") != methods.end();
  return fine ? "fem_q2" : "fem_q1";
}

} // namespace maille::studies
