#include "elastic/ladder/ladder.hpp"

#include "control/method.hpp"
#include "elastic/box/box_solver.hpp"
#include "elastic/direct/direct_system.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/masked/masked_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace maille::deform {

namespace {

/// Estimate the cost of a factor after this many iterations; most bodies are solved by then.
constexpr std::int64_t first_doubt = 64;

/// If a rung failed, clears its message for the next one. @return whether it failed
bool clear_failure(Answer& answer) {
  const bool has_failed = answer.status == Status::failed;
  if (has_failed) {
    answer.status = Status::done;
    answer.message.clear();
  }
  return has_failed;
}

/// Gathers the state on the first rank after freeing the hierarchy.
bool solve_by_ranks(const CoupledTask& task, Answer& answer) {
  auto solver = std::make_unique<MaskedSolver>(task);
  answer.algorithm = solver->algorithm();
  answer.seconds.setup = task.clock.seconds();
  Displacement part; // its planes, in the end
  const CoupledRound end = solver->solve(part, answer);
  if (end != CoupledRound::stalled)
    solver->find_energy_and_reactions(part, answer);
  const Slabs slabs = solver->slabs();
  solver.reset();
  if (end == CoupledRound::stalled) { // whole, on every rank
    const auto by_factor = solve_coupled_by_factor(task, make_direct_system(task), answer);
    return by_factor && !clear_failure(answer) ? *by_factor : solve_coupled_body(task, answer);
  }
  const Grid& grid = task.scene.specimen.grid;
  if (slabs.is_first())
    answer.displacement = Displacement(grid);
  const auto node = [&](int plane) { return grid.node({0, 0, plane}); };
  const PlaneRange own = slabs.own();
  for (std::size_t c = 0; c < 3; ++c)
    slabs.gather_planes(part.component(c).subspan(node(own.first) - node(slabs.layers().first),
                                                  static_cast<std::size_t>(node(own.end) - node(own.first))),
                        slabs.is_first() ? answer.displacement.component(c) : std::span<double>());
  if (end != CoupledRound::finished)
    answer.reaction.clear();
  return end == CoupledRound::finished;
}

/// True if rounding in float32 would move the box by more than its tolerance. Measured on rods and plates,
/// rounding moves a body by 1e-8 of its displacement, over the ratio of the operator's smallest eigenvalue to
/// its largest. The smallest one is that of a cantilever's first mode.
bool is_slender_box(const Scene& scene) {
  constexpr double slender = 3, rounding = 4e-8;
  const Grid& grid = scene.specimen.grid;
  double longest = 0, thinnest = INFINITY, cell = INFINITY;
  for (std::size_t a = 0; a < 3; ++a) {
    const double h = grid.spacing()[a], length = h * grid.cells()[a];
    longest = std::max(longest, length);
    thinnest = std::min(thinnest, length);
    cell = std::min(cell, h);
  }
  const Matrix6 C = scene.object_stiffness(0);
  const double softest = 1 / C.inverse().diagonal().head<3>().maxCoeff();
  const double smallest =
      softest / C.diagonal().maxCoeff() * std::pow(cell * thinnest / (longest * longest), 2);
  return longest > slender * thinnest && smallest * scene.relaxation.tolerance < rounding;
}

} // namespace

bool needs_float64(const Scene& scene) {
  return is_uniform_box(scene) ? is_slender_box(scene) : is_very_slender(scene.specimen);
}

namespace {

/// @pre dimension 3
std::unique_ptr<MixedSolver> make_mixed_solver(const CoupledTask& task) {
  if (is_uniform_box(task.scene))
    return std::make_unique<BoxSolver>(task);
  return std::make_unique<MaskedSolver>(task);
}

} // namespace

std::shared_ptr<ElasticOperator> make_operator(const CoupledTask& task) {
  if (task.scene.dimension() < 3)
    return std::make_shared<BodySystem>(task);
  std::shared_ptr<MixedSolver> solver = make_mixed_solver(task);
  return {solver, &solver->system()};
}

std::shared_ptr<PenalizedOperator> make_operator_within_limits(const CoupledTask& task) {
  if (task.scene.dimension() == 3 && needs_float64(task.scene))
    if (std::shared_ptr<DirectSystem> factor = make_direct_system(task);
        factor != nullptr && factor->factor())
      return factor;
  return std::make_shared<BodySystem>(task);
}

namespace {

/// Rungs 2 to 4. @param solver that stalled; null: not made yet @param factor null: none may be made
bool fall_back(const CoupledTask& task, std::unique_ptr<MixedSolver> solver,
               std::unique_ptr<DirectSystem> factor, Answer& answer) {
  Displacement start = std::move(answer.displacement);
  const auto by_factor = solve_coupled_by_factor(task, std::move(factor), answer);
  if (by_factor && !clear_failure(answer))
    return *by_factor;
  if (solver == nullptr)
    solver = make_mixed_solver(task);
  answer.algorithm = std::string(solver->algorithm()) + ", in float64";
  const bool is_usable = !start.empty() && std::ranges::all_of(start.values(), [](double value) {
    return std::isfinite(value);
  });
  answer.displacement = is_usable ? std::move(start) : task.initial_state();
  if (answer.iterations == 0)
    answer.seconds.setup = task.clock.seconds();
  // On very oblong cells float32 can make the multigrid indefinite. The componentwise one stays positive, at
  // the price of more iterations.
  const bool is_converged = FlexibleGradients(task).finish(solver->system_of_slender(), answer);
  return clear_failure(answer) ? solve_coupled_body(task, answer) : is_converged;
}

} // namespace

bool solve_on_ladder(const CoupledTask& task, Answer& answer) {
  if (task.scene.dimension() < 3)
    return solve_coupled_body(task, answer);
  if (task.control.communicator != nullptr)
    return solve_by_ranks(task, answer);
  if (needs_float64(task.scene))
    return fall_back(task, nullptr, make_direct_system(task), answer);
  std::unique_ptr<MixedSolver> solver = make_mixed_solver(task);
  answer.algorithm = solver->algorithm();
  answer.seconds.setup = task.clock.seconds();
  std::optional<std::unique_ptr<DirectSystem>> factor; // ordered when it is first asked for
  solver->should_fall_back = [&](std::int64_t iterations) {
    if (iterations < first_doubt)
      return false;
    if (!factor)
      factor = make_direct_system(task);
    return *factor != nullptr && iterations >= (*factor)->iterations_worth_it();
  };
  if (task.start != nullptr)
    answer.displacement = task.initial_state();
  const CoupledRound end = solver->solve(answer.displacement, answer);
  if (end == CoupledRound::stalled)
    return fall_back(task, std::move(solver), factor ? *std::move(factor) : make_direct_system(task), answer);
  solver->find_energy_and_reactions(answer.displacement, answer);
  if (end != CoupledRound::finished)
    answer.reaction.clear();
  return end == CoupledRound::finished;
}

} // namespace maille::deform
