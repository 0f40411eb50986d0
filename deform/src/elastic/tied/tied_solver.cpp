#include "elastic/tied/tied_solver.hpp"

#include "control/method.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "elastic/tied/tied_nodes.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

namespace maille::deform {

namespace {

std::vector<std::vector<bool>> fixed_components(const CoupledTask& task) {
  const Specimen& body = task.scene.specimen;
  std::vector<bool> is_void(static_cast<std::size_t>(body.grid.n_nodes()));
  for (std::size_t node = 0; node < is_void.size(); ++node)
    is_void[node] = !body.is_node(body.grid.node_at(static_cast<std::int64_t>(node)));
  std::vector<std::vector<bool>> is_fixed(3, is_void);
  for (const Prescribed& p : task.prescribed)
    is_fixed[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  return is_fixed;
}

class TiedSystem : public FlexibleOperator {
public:
  explicit TiedSystem(const CoupledTask& task)
      : task_(task), elasticity_(task.scene), held_softly_(task.scene), is_fixed_(fixed_components(task)),
        diagonal_(elasticity_.diagonal()), ties_(task.scene.tied, is_fixed_, diagonal_),
        shared_(task.scene.specimen.grid) {
    held_softly_.set_springs(springs_at_ties(task.scene, diagonal_));
    multigrid_ = std::make_unique<MaskedMultigrid>(
        std::make_unique<MaskedLevel>(task.scene, held_softly_, task.prescribed),
        relaxation_steps(largest_contrast(task.scene)), task.team);
    of_single_bodies_ =
        std::make_unique<MaskedSystem>(task.scene.specimen.grid, held_softly_, *multigrid_, task.team);
  }

  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task_.team);
  }
  void precondition(const Displacement& residual, Displacement& correction) override {
    shared_ = residual;
    ties_.share(shared_);
    std::ranges::fill(correction.values(), 0.0);
    of_single_bodies_->precondition(shared_, correction);
    ties_.bring_together(correction);
  }
  Displacement diagonal() const override { return diagonal_; }

  const TiedNodes& ties() const { return ties_; }
  FlexibleGradients gradients() const { return FlexibleGradients(task_, forces_of_loads(), is_fixed_); }
  /// Energy, and what holds every prescribed component: what ties bring to it is theirs.
  void find_energy_and_reactions(const Displacement& u, Answer& answer);

private:
  std::vector<List<double>> forces_of_loads() const {
    std::vector<List<double>> forces;
    for (int b = 0; b < 3; ++b)
      forces.push_back(nodal_forces(task_.scene, b));
    return forces;
  }

  const CoupledTask& task_;
  LatticeElasticity elasticity_, held_softly_;
  std::vector<std::vector<bool>> is_fixed_;
  Displacement diagonal_;
  TiedNodes ties_;
  Displacement shared_;
  std::unique_ptr<MaskedMultigrid> multigrid_;
  std::unique_ptr<MaskedSystem> of_single_bodies_;
};

void TiedSystem::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  Displacement forces(task_.scene.specimen.grid);
  apply(u, forces);
  double twice = 0;
  for (std::size_t i = 0; i < u.values().size(); ++i)
    twice += u.values()[i] * forces.values()[i];
  answer.strain_energy = 0.5 * twice - energy_of_springs(elasticity_.springs(), u);
  const auto loads = forces_of_loads();
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < loads[b].size(); ++i)
      forces(b, i) -= loads[b][i];
  ties_.take_out_tie_forces(forces);
  answer.reaction.clear();
  for (const Prescribed& p : task_.scene.prescribed)
    answer.reaction.push_back(forces(p.component, p.node));
}

} // namespace

bool solve_coupled_tied(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around multigrid of bodies that slide";
  answer.displacement = task.initial_state();
  TiedSystem system(task);
  system.ties().bring_together(answer.displacement);
  FlexibleGradients gradients = system.gradients();
  answer.seconds.setup = task.clock.seconds();
  const CoupledRound end = gradients.solve(system, answer.displacement, answer);
  if (end == CoupledRound::stalled) {
    answer.status = Status::failed;
    answer.message = gradients.problem();
    answer.displacement = {};
    return false;
  }
  system.find_energy_and_reactions(answer.displacement, answer);
  if (end != CoupledRound::finished)
    answer.reaction.clear();
  return end == CoupledRound::finished;
}

} // namespace maille::deform
