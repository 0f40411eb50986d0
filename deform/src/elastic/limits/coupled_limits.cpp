#include "elastic/limits/constrained_minimum.hpp"

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/ladder/ladder.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

namespace maille::deform {

namespace {

/// Half a spacing is about a hundredth of an answer: more accuracy would be lost on the way to the finer
/// body.
constexpr double tolerance = 1e-2;

} // namespace

bool start_from_coarser(const CoupledTask& task, ConstrainedMinimum& minimum, Displacement& u) {
  std::optional<Scene> scene = coarser_scene(task.scene, task.prescribed);
  if (!scene)
    return false;
  scene->relaxation.tolerance = std::max(tolerance, task.scene.relaxation.tolerance);
  const LinkLimits limits(*scene);
  const Clipping clipping = FeasibleSet(*scene, limits, task.control.threads).clip();
  const CoupledTask coarse{*scene,         task.control, clipping.prescribed, task.team, task.clock,
                           task.must_stop, &limits};
  Displacement v(scene->specimen.grid);
  for (const Prescribed& p : clipping.prescribed)
    v(p.component, p.node) = p.value;
  const CellModuli moduli(*scene);
  const std::shared_ptr<PenalizedOperator> system = make_operator_within_limits(coarse);
  ConstrainedMinimum coarse_minimum(coarse, *system, moduli, all_components(*scene), loads_of(*scene));
  start_from_coarser(coarse, coarse_minimum, v);
  Answer unused;
  coarse_minimum.solve(v, scene->relaxation.tolerance, unused);
  minimum.begin_with(coarse_minimum);
  if (task.must_stop()) // an incomplete coarse answer is worse than the elastic one
    return false;
  interpolate(scene->specimen, v.values(), task.scene.specimen, u.values(), task.team);
  for (const Prescribed& p : task.prescribed)
    u(p.component, p.node) = p.value;
  return true;
}

namespace {

/// Euclidean, of the change over the first.
double relative_change(const Displacement& from, const Displacement& to) {
  const double size = product(from, from);
  double change = 0;
  for (std::size_t i = 0; i < from.values().size(); ++i)
    change += std::pow(to.values()[i] - from.values()[i], 2);
  return size > 0 ? std::sqrt(change / size) : 0;
}

/// Searches from the multipliers of the previous answer; without them, or if that fails, from coarser bodies.
/// Stores the multipliers of this answer.
/// @return true if the minimum was found
bool find_least_energy(const CoupledTask& task, PenalizedOperator& system, Displacement& u,
                       Displacement& spare, Answer& answer) {
  const CellModuli moduli(task.scene);
  const bool has_multipliers = begins_within_limits(task);
  for (const bool from_last_answer : {true, false}) {
    if (from_last_answer && !has_multipliers)
      continue;
    ConstrainedMinimum minimum(task, system, moduli, all_components(task.scene), loads_of(task.scene));
    if (from_last_answer)
      minimum.begin_with(task.kept->multipliers);
    else {
      if (has_multipliers) // the search from them may have diverged
        u = task.initial_state();
      if (start_from_coarser(task, minimum, u))
        answer.algorithm += ", from coarser bodies";
    }
    const bool is_found = minimum.solve(u, task.scene.relaxation.tolerance, answer);
    answer.residual = minimum.error();
    List<KeptMultiplier> multipliers = is_found ? minimum.multipliers() : List<KeptMultiplier>();
    const std::size_t n_pulling = multipliers.size();
    if (task.kept != nullptr)
      task.kept->multipliers = std::move(multipliers);
    if (!is_found && from_last_answer && !task.must_stop())
      continue;
    spare = minimum.release_residual();
    answer.algorithm +=
        from_last_answer ? ", limits by multipliers from the last answer on" : ", limits by multipliers";
    if (!is_found)
      return false;
    system.apply(u, spare);
    minimum.add_forces_of_limits(spare); // part of the balance
    answer.reaction = reactions_of(task.scene, loads_of(task.scene), spare);
    answer.message =
        from_last_answer && n_pulling == 0
            ? ""
            : fmt::format("limits are active: least energy within them, with multipliers of {} links",
                          minimum.n_active());
    return true;
  }
  return false;
}

} // namespace

bool solve_within_limits(const CoupledTask& task, Answer& answer) {
  const bool begins_there = begins_within_limits(task);
  bool is_converged = true;
  if (begins_there) {
    answer.algorithm = "lattice elasticity";
    answer.displacement = task.initial_state();
    answer.seconds.setup = task.clock.seconds();
  } else
    is_converged = solve_on_ladder(task, answer);
  if (answer.status == Status::failed || task.limits == nullptr ||
      (!begins_there && !breaks_limits(task.scene, *task.limits, task.team, answer.displacement, 0)))
    return is_converged;
  const std::shared_ptr<PenalizedOperator> system =
      is_converged ? make_operator_within_limits(task) : std::make_shared<BodySystem>(task);
  Displacement& u = answer.displacement;
  Displacement spare; // forces, then the state before the projection
  answer.reaction.clear();
  answer.message =
      "limits are active: the solve was cut short, and its state brought to the nearest feasible one";
  if (is_converged)
    is_converged = find_least_energy(task, *system, u, spare, answer);
  spare = u; // reuses its memory
  FeasibleSet(task.scene, *task.limits, task.control.threads).bring_in(task.prescribed, u);
  answer.residual = std::min(1.0, std::max(answer.residual, relative_change(spare, u)));
  system->apply(u, spare);
  answer.strain_energy = 0.5 * product(u, spare) - energy_of_springs(nodal_springs(task.scene), u);
  return is_converged;
}

} // namespace maille::deform
