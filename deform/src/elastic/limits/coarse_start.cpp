#include "elastic/limits/coarse_start.hpp"

#include "elastic/box/box_solver.hpp"
#include "elastic/box/box_system.hpp"
#include "elastic/limits/newton_optimum.hpp"
#include "elastic/masked/matter_solver.hpp"
#include "elastic/masked/matter_system.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "elastic/resample/interpolation.hpp"
#include "feasible/legal_state.hpp"

#include <algorithm>

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
    MatterSolver solver(task);
    MatterSystem system(task.scene.specimen.grid, solver.elasticity(), solver.multigrid(), task.team);
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
  const Admission admission = admit_fast(*scene, limits, task.control.threads);
  const CoupledTask coarse{*scene,         task.control, admission.prescribed, task.team, task.clock,
                           task.must_stop, &limits};
  Displacement v(scene->specimen.grid);
  for (const Prescribed& p : admission.prescribed)
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

} // namespace maille::deform
