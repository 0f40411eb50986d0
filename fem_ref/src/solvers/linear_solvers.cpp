#include "solvers/linear_solvers.hpp"

#include "maille/scene/memory.hpp"

#include "solvers/cholmod_solver.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace maille::fem_ref {
namespace {

/// Times of one core of a server of 2023 with OpenBLAS, fitted to bodies of 2,000 to 130,000 unknowns, Q1 and
/// Q2, in 2D and 3D (to 30 %). Only their ratio matters: a slower machine is slower at both.
constexpr double seconds_per_flop = 1 / 3.5e10;
constexpr double seconds_per_factor_byte = 1.2e-9;
constexpr double seconds_per_entry_of_cg = 2.4e-7; ///< copy, hierarchy and iterations to 1e-10

/// Largest over smallest diagonal entry: what different materials, anisotropy and voids make of the
/// stiffness.
double contrast(const LinearSystem& system) {
  double least = std::numeric_limits<double>::infinity(), greatest = 0;
  for (dealii::types::global_dof_index i = 0; i < system.matrix.m(); ++i) {
    if (system.constraints.is_constrained(i))
      continue;
    least = std::min(least, system.matrix.diag_element(i));
    greatest = std::max(greatest, system.matrix.diag_element(i));
  }
  return greatest > 0 && least > 0 ? greatest / least : 1;
}

/// Half of the time of a homogeneous body is iterations. Their number grows with the contrast: 14 at 1, 136
/// at 3,000 (muscle between tendons), measured.
double seconds_by_cg(const LinearSystem& system) {
  const double growth = 1 + 2.5 * std::log10(contrast(system));
  return seconds_per_entry_of_cg * static_cast<double>(system.n_entries()) * (0.5 + 0.5 * growth);
}

/// Flops of the factor by nested dissection, from the body's mean cross-section alone: 17 dense factors of
/// the first separator for every stretch that is as long as it is wide. Good to 10 % on cubes, low elsewhere.
double flops_at_least(const LinearSystem& system) {
  const double nodes = static_cast<double>(system.n()) / system.dimension;
  const auto longest = static_cast<double>(system.longest);
  const double section = std::max(1.0, nodes / longest);
  const double width = system.dimension > 1 ? std::pow(section, 1.0 / (system.dimension - 1)) : 1.0;
  return 17.0 / 3.0 * std::pow(system.dimension * section, 3) * std::max(1.0, longest / width);
}

std::string with_commas(std::int64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t place = text.size(); place > 3; place -= 3)
    text.insert(place - 3, 1, ',');
  return text;
}

std::string in_words(const LinearSystem& system, std::string_view solver, const std::string& why = {}) {
  return solver_in_words(system.degree, system.n_free(), solver, why);
}

Preparation by_cg(LinearSystem& system, const Options& options, Watch& watch, const std::string& why = {}) {
  const std::string words = in_words(system, "CG with smoothed-aggregation AMG", why);
  Preparation preparation = prepare_amg(system, options.tolerance, watch);
  preparation.algorithm = words;
  return preparation;
}

/// @param cholmod analysed
Preparation by_cholmod(const LinearSystem& system, std::unique_ptr<CholmodSolver> cholmod, Watch& watch,
                       const std::string& why = {}) {
  Preparation preparation = cholmod->factorise(watch);
  preparation.algorithm =
      in_words(system, cholmod->is_supernodal() ? "CHOLMOD supernodal" : "CHOLMOD simplicial", why);
  if (preparation.status == Status::done)
    preparation.solver = std::move(cholmod);
  return preparation;
}

Preparation by_cholmod_alone(const LinearSystem& system, Watch& watch) {
  auto cholmod = std::make_unique<CholmodSolver>(system);
  if (!cholmod->analyse())
    return give_up(Status::failed, "out of memory for the analysis of the matrix");
  const auto needed = static_cast<double>(cholmod->factor_bytes()),
             available = static_cast<double>(available_memory());
  if (needed > available)
    return give_up(Status::refused, fmt::format("CHOLMOD's factor needs {}, {} are available",
                                                bytes_in_words(needed), bytes_in_words(available)));
  return by_cholmod(system, std::move(cholmod), watch);
}

/// The quicker way by the times above, and CG where the factor does not fit into memory.
Preparation by_the_quicker(LinearSystem& system, const Options& options, Watch& watch) {
  const double by_iterations = seconds_by_cg(system);
  // Where a factor is far out of reach, even counting its entries would be a waste.
  if (const double flops = flops_at_least(system); flops * seconds_per_flop > 1.2 * by_iterations)
    return by_cg(system, options, watch, fmt::format("a factor would take some {:.0f} GFLOP", flops / 1e9));
  std::string why_not;
  {
    auto cholmod = std::make_unique<CholmodSolver>(system);
    if (!cholmod->analyse())
      why_not = "no memory for the analysis of a factor";
    else if (const auto needed = static_cast<double>(cholmod->factor_bytes());
             needed > static_cast<double>(available_memory()))
      why_not = fmt::format("a factor would need {}", bytes_in_words(needed));
    else if (cholmod->flops() * seconds_per_flop + needed * seconds_per_factor_byte > by_iterations)
      why_not = fmt::format("a factor would take {:.2g} GFLOP and {}", cholmod->flops() / 1e9,
                            bytes_in_words(needed));
    else
      return by_cholmod(system, std::move(cholmod), watch,
                        fmt::format("a factor of {}", bytes_in_words(needed)));
  }
  return by_cg(system, options, watch, why_not);
}

} // namespace

std::string solver_in_words(int degree, std::int64_t n_free, std::string_view solver,
                            const std::string& why) {
  return fmt::format("Q{}, {}{}{}{}, {} unknowns", degree, solver, why.empty() ? "" : " (", why,
                     why.empty() ? "" : ")", with_commas(n_free));
}

Solution end_with(Status status, std::string message) {
  Solution solution;
  solution.status = status;
  solution.message = std::move(message);
  return solution;
}

Preparation give_up(Status status, std::string message) {
  Preparation preparation;
  preparation.status = status;
  preparation.message = std::move(message);
  return preparation;
}

Preparation prepare(LinearSystem& system, const Options& options, Watch& watch) {
  switch (options.solver) {
  case LinearSolver::cholmod:
    return by_cholmod_alone(system, watch);
  case LinearSolver::cg_amg:
    return by_cg(system, options, watch);
  default:
    return by_the_quicker(system, options, watch);
  }
}

} // namespace maille::fem_ref
