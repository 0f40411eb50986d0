

#include "elastic/limits/coupled_limits.hpp"

#include "elastic/box/box_solver.hpp"
#include "elastic/box/box_system.hpp"
#include "elastic/limits/newton_optimum.hpp"
#include "elastic/links/link_ranges.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/projection.hpp"
#include "maille/scene/nodal_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Half a spacing is about a hundredth of an answer: more accuracy would be lost on the way to the finer
/// body.
constexpr double tolerance = 1e-2;

class LatticeSystem : public CoupledSystem {
public:
  LatticeSystem(const Scene& scene, ThreadTeam& team) : elasticity_(scene), team_(team) {}
  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }

private:
  LatticeElasticity elasticity_;
  ThreadTeam& team_;
};

/// Calls visit(system), which has a multigrid of its own if it is to and can.
template<class Visit>
void with_system(const CoupledTask& task, bool has_multigrid, const Visit& visit) {
  if (has_multigrid && is_uniform_box(task.scene)) {
    BoxSolver solver(task);
    BoxSystem system(solver.multigrid(), solver.unit());
    visit(system);
  } else if (has_multigrid && task.scene.dimension() == 3) {
    MaskedSolver solver(task);
    MaskedSystem system(task.scene.specimen.grid, solver.elasticity(), solver.multigrid(), task.team);
    visit(system);
  } else {
    LatticeSystem system(task.scene, task.team);
    visit(system);
  }
}

} // namespace

bool start_from_coarser(const CoupledTask& task, CoupledOptimum& optimum, Displacement& u) {
  std::optional<Scene> scene = coarser_scene(task.scene, task.prescribed);
  if (!scene)
    return false;
  scene->relaxation.tolerance = std::max(tolerance, task.scene.relaxation.tolerance);
  const LinkLimits limits(*scene);
  const Clipping clipping = clip_fast(*scene, limits, task.control.threads);
  const CoupledTask coarse{*scene,         task.control, clipping.prescribed, task.team, task.clock,
                           task.must_stop, &limits};
  Displacement v(scene->specimen.grid);
  for (const Prescribed& p : clipping.prescribed)
    v(p.component, p.node) = p.value;
  with_system(coarse, optimum.has_multigrid(), [&](CoupledSystem& system) {
    const auto coarse_optimum = make_optimum(coarse, system);
    start_from_coarser(coarse, *coarse_optimum, v);
    Answer unused;
    coarse_optimum->solve(v, unused);
    optimum.take_over(*coarse_optimum);
  });
  if (task.must_stop()) // half a coarse answer is worse than the finer elastic one
    return false;
  interpolate(scene->specimen, v, task.scene.specimen, u, task.team);
  for (const Prescribed& p : task.prescribed)
    u(p.component, p.node) = p.value;
  return true;
}

namespace {

/// What holds every prescribed component, where the limits' forces are in balance with the others.
void find_reactions(const CoupledTask& task, CoupledSystem& system, const CoupledOptimum& optimum,
                    const Displacement& u, Displacement& forces, Answer& answer) {
  system.apply_at(task.scene.prescribed, u, forces);
  optimum.add_forces_of_limits(forces);
  answer.reaction.clear();
  std::vector<std::vector<double>> loads;
  for (int component = 0; component < task.scene.dimension(); ++component)
    loads.push_back(nodal_forces(task.scene, component));
  for (const Prescribed& p : task.scene.prescribed) {
    const auto& load = loads[static_cast<std::size_t>(p.component)];
    answer.reaction.push_back(forces(p.component, p.node) -
                              (load.empty() ? 0 : load[static_cast<std::size_t>(p.node)]));
  }
}

double energy_of(CoupledSystem& system, const Displacement& u, Displacement& forces) {
  system.apply(u, forces);
  double sum = 0;
  for (std::size_t b = 0; b < u.component.size(); ++b)
    for (std::size_t i = 0; i < u.component[b].size(); ++i)
      sum += u.component[b][i] * forces.component[b][i];
  return 0.5 * sum;
}

/// Euclidean, of the change over the first.
double relative_change(const Displacement& from, const Displacement& to) {
  double change = 0, size = 0;
  for (std::size_t b = 0; b < from.component.size(); ++b)
    for (std::size_t i = 0; i < from.component[b].size(); ++i) {
      change += std::pow(to.component[b][i] - from.component[b][i], 2);
      size += std::pow(from.component[b][i], 2);
    }
  return size > 0 ? std::sqrt(change / size) : 0;
}

} // namespace

bool obey_limits(const CoupledTask& task, CoupledSystem& system, bool is_converged, Displacement& u,
                 Answer& answer) {
  if (task.limits == nullptr || !breaks_limits(task.scene, *task.limits, task.team, u, 0))
    return is_converged;
  answer.reaction.clear();
  Displacement spare; // forces, then the state before the projection
  answer.message =
      "limits are active: the solve was cut short, and its state brought to the nearest feasible one";
  if (is_converged) {
    const std::unique_ptr<CoupledOptimum> chosen = make_optimum(task, system);
    CoupledOptimum& optimum = *chosen;
    if (start_from_coarser(task, optimum, u)) {
      answer.algorithm += ", from coarser bodies";
      optimum.rely_on_multipliers();
    }
    is_converged = optimum.solve(u, answer);
    answer.residual = optimum.residual();
    answer.bytes += optimum.bytes() + system.bytes();
    spare = optimum.give_away_field();
    answer.algorithm += ", limits by multipliers";
    if (is_converged) {
      find_reactions(task, system, optimum, u, spare, answer);
      answer.message = fmt::format(
          "limits are active: least energy within them, with multipliers of {} links", optimum.n_active());
    }
  }
  spare = u; // in the memory that it has, if any
  make_feasible(task.scene, *task.limits, task.prescribed, u, task.control.threads);
  answer.residual = std::min(1.0, std::max(answer.residual, relative_change(spare, u)));
  answer.strain_energy = energy_of(system, u, spare);
  answer.bytes += bytes_of(u);
  return is_converged;
}

} // namespace maille::deform
