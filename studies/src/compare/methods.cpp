#include "compare/methods.hpp"

#include "export/calculix/calculix.hpp"
#include "maille/fem_ref/ranks.hpp"

namespace maille::studies {

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

bool Methods::is_for_all_ranks(const Scene& scene, std::string_view name) const {
  return name.starts_with("fem_") ||
         (body_ == nullptr && deform::is_for_all_ranks(scene, name, fem_ref::ranks().size));
}

Answer Methods::answer(const Scene& scene, std::string_view name, const Control& control) {
  const auto method = method_from_string(name);
  if (method == Method::calculix)
    return solve_by_calculix(scene, control);
  if (method == Method::fem_q1 || method == Method::fem_q2)
    return of_degree_[method == Method::fem_q1 ? 0 : 1]->solve(scene, control).answer;
  if (method == Method::coupled && body_ != nullptr)
    return body_->answer(scene, control);
  return deform::solve(scene, name, control);
}

Answer answer_by(const Scene& scene, std::string_view name, const Control& control) {
  return Methods().answer(scene, name, control);
}

} // namespace maille::studies
