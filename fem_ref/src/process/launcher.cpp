#include "maille/fem_ref/ranks.hpp"

#include "maille/fem_ref/solve.hpp"

#include <cstdlib>

namespace maille::fem_ref {

int announced_ranks() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name))
      return std::atoi(size);
  return 1;
}

std::optional<LinearSolver> linear_solver_named(std::string_view name) {
  for (std::size_t i = 0; i < linear_solver_names.size(); ++i)
    if (name == linear_solver_names[i])
      return static_cast<LinearSolver>(i);
  return std::nullopt;
}

} // namespace maille::fem_ref
