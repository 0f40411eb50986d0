#include "maille/fem_ref/solve.hpp"

namespace maille::fem_ref {

std::optional<LinearSolver> linear_solver_named(std::string_view name) {
  for (std::size_t i = 0; i < linear_solver_names.size(); ++i)
    if (name == linear_solver_names[i])
      return static_cast<LinearSolver>(i);
  return std::nullopt;
}

} // namespace maille::fem_ref
