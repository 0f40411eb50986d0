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
#include <numeric>
#include <optional>
#include <span>
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

/// Finds the reactions of all prescribed components, where the forces of the limits are part of the balance.
void find_reactions(const CoupledTask& task, PenalizedOperator& system, const ConstrainedMinimum& minimum,
                    const Displacement& u, Displacement& forces, Answer& answer) {
  system.apply(u, forces);
  minimum.add_forces_of_limits(forces);
  answer.reaction.clear();
  const Loads loads = loads_of(task.scene);
  for (const Prescribed& p : task.scene.prescribed) {
    const auto& load = loads[p.component];
    answer.reaction.push_back(forces(p.component, p.node) - (load.empty() ? 0 : load[p.node]));
  }
}

double energy_of(PenalizedOperator& system, const Displacement& u, Displacement& forces) {
  system.apply(u, forces);
  const std::span<const double> values = u.values();
  return 0.5 * std::inner_product(values.begin(), values.end(), forces.values().begin(), 0.0);
}

/// Euclidean, of the change over the first.
double relative_change(const Displacement& from, const Displacement& to) {
  double change = 0, size = 0;
  for (std::size_t i = 0; i < from.values().size(); ++i) {
    change += std::pow(to.values()[i] - from.values()[i], 2);
    size += std::pow(from.values()[i], 2);
  }
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
    find_reactions(task, system, minimum, u, spare, answer);
    answer.message =
        from_last_answer && n_pulling == 0
            ? ""
            : fmt::format("limits are active: least energy within them, with multipliers of {} links",
                          minimum.n_active());
    return true;
  }
  return false;
}

bool enforce_limits(const CoupledTask& task, PenalizedOperator& system, bool is_converged, Displacement& u,
                    Answer& answer) {
  answer.reaction.clear();
  Displacement spare; // forces, then the state before the projection
  answer.message =
      "limits are active: the solve was cut short, and its state brought to the nearest feasible one";
  if (is_converged)
    is_converged = find_least_energy(task, system, u, spare, answer);
  spare = u; // reuses its memory
  FeasibleSet(task.scene, *task.limits, task.control.threads).bring_in(task.prescribed, u);
  answer.residual = std::min(1.0, std::max(answer.residual, relative_change(spare, u)));
  answer.strain_energy = energy_of(system, u, spare) - energy_of_springs(nodal_springs(task.scene), u);
  return is_converged;
}

} // namespace

bool obey_limits(const CoupledTask& task, bool is_converged, Displacement& u, Answer& answer) {
  if (!begins_within_limits(task) && !breaks_limits(task.scene, *task.limits, task.team, u, 0))
    return is_converged;
  const std::shared_ptr<PenalizedOperator> system =
      is_converged ? make_operator_within_limits(task) : std::make_shared<BodySystem>(task);
  return enforce_limits(task, *system, is_converged, u, answer);
}

} // namespace maille::deform
