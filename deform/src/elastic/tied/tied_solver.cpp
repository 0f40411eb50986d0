#include "elastic/tied/tied_methods.hpp"

#include "control/method.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "elastic/tied/tied_model.hpp"
#include "maille/mechanics/friction.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Full elasticity plus the springs of friction.
class TiedSystem : public TiedModel {
public:
  explicit TiedSystem(const CoupledTask& task) : TiedSystem(task, LatticeElasticity(task.scene, task.team)) {}

  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task().team);
    for (const NodeTie& tie : task().scene.tied.ties)
      if (tie.spring > 0)
        add_rub(tie, rub_of(tie, u), forces, -1);
  }
  /// Switches to the componentwise preconditioner, which supports penalties.
  void set_penalties(const List<PenaltyLink>& links) override {
    of_single_bodies_.reset();
    multigrid_.reset();
    TiedModel::set_penalties(links);
  }
  /// @param pulls  by tie, of springs between its nodes
  FlexibleGradients gradients(const std::vector<Vec3>& pulls) const {
    return FlexibleGradients(task(), forces_of_loads(pulls), fixed());
  }
  /// What ties bring to nodes, or what holds them where they are prescribed.
  Displacement beyond_loads(const Displacement& u, const std::vector<Vec3>& pulls);
  /// Energy, and what holds every prescribed component: what ties bring to it is theirs.
  void find_energy_and_reactions(const Displacement& u, const std::vector<Vec3>& pulls, Answer& answer);
  /// Without that of springs to the ground [J].
  double energy(const Displacement& u) const;
  /// @param pulls  empty: none
  Loads forces_of_loads(const std::vector<Vec3>& pulls) const;

private:
  TiedSystem(const CoupledTask& task, LatticeElasticity&& elasticity)
      : TiedSystem(task, std::move(elasticity), elasticity.diagonal()) {}
  TiedSystem(const CoupledTask& task, LatticeElasticity&& elasticity, const Displacement& diagonal)
      : TiedModel(task, CellModuli(task.scene), diagonal, springs_at_ties(task.scene, diagonal)),
        elasticity_(std::move(elasticity)), held_softly_(task.scene) {
    held_softly_.set_springs(springs_at_ties(task.scene, diagonal));
    multigrid_ = std::make_unique<MaskedMultigrid>(
        std::make_unique<MaskedLevel>(task.scene, held_softly_, task.prescribed, task.team),
        relaxation_steps(largest_contrast(task.scene)), task.team);
    of_single_bodies_ =
        std::make_unique<MaskedSystem>(task.scene.specimen.grid, held_softly_, *multigrid_, task.team);
  }
  void precondition_bodies(const Displacement& residual, Displacement& correction) override {
    if (of_single_bodies_)
      of_single_bodies_->precondition(residual, correction);
    else
      TiedModel::precondition_bodies(residual, correction);
  }
  static void add_rub(const NodeTie& tie, const Vec3& rub, Displacement& forces, double factor) {
    for (std::size_t b = 0; b < 3; ++b) {
      forces(b, tie.one) += factor * rub[b];
      forces(b, tie.other) -= factor * rub[b];
    }
  }

  LatticeElasticity elasticity_, held_softly_;
  std::unique_ptr<MaskedMultigrid> multigrid_;
  std::unique_ptr<MaskedSystem> of_single_bodies_; ///< null within limits
};

Loads TiedSystem::forces_of_loads(const std::vector<Vec3>& pulls) const {
  const NodeTies& tied = task().scene.tied;
  Loads forces = loads_of(task().scene);
  for (int b = 0; b < 3; ++b) {
    List<double>& along = forces[b];
    for (std::size_t t = 0; t < pulls.size(); ++t) {
      const double pull = pulls[t][b];
      if (pull == 0)
        continue;
      if (along.empty())
        along.assign(task().scene.specimen.grid.n_nodes(), 0);
      along[tied.ties[t].one] += pull;
      along[tied.ties[t].other] -= pull;
    }
  }
  return forces;
}

Displacement TiedSystem::beyond_loads(const Displacement& u, const std::vector<Vec3>& pulls) {
  Displacement forces(task().scene.specimen.grid);
  apply(u, forces);
  subtract_loads(forces_of_loads(pulls), forces);
  return forces;
}

void TiedSystem::find_energy_and_reactions(const Displacement& u, const std::vector<Vec3>& pulls,
                                           Answer& answer) {
  answer.strain_energy = energy(u);
  Displacement forces = beyond_loads(u, pulls);
  answer.reaction = reactions_of_tied(*this, forces);
}

double TiedSystem::energy(const Displacement& u) const {
  Displacement forces(task().scene.specimen.grid);
  elasticity_.apply(u, forces, task().team);
  return 0.5 * product(u, forces) - energy_of_springs(elasticity_.springs(), u);
}

/// Corrects an elastic state that breaks limits. @return as keep_within_limits()
bool obey_limits(TiedSystem& system, Answer& answer) {
  answer.algorithm += ", limits by multipliers";
  const bool is_found =
      keep_within_limits(system, system.forces_of_loads({}), {}, true, answer.displacement, answer);
  answer.strain_energy = system.energy(answer.displacement);
  return is_found;
}

bool give_up(Answer& answer, const std::string& why) {
  answer.status = Status::failed;
  answer.message = why;
  answer.displacement = {};
  return false;
}

} // namespace

bool solve_coupled_tied(const CoupledTask& asked, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around multigrid of bodies that slide";
  answer.displacement = asked.initial_state();
  Friction friction(asked.scene);
  // Slip is small compared with pressing displacements, so rounds need a smaller error.
  Scene exact;
  if (!friction.empty()) {
    exact = asked.scene;
    exact.relaxation.tolerance *= 0.1;
    answer.algorithm += ", in rounds of friction";
  }
  const CoupledTask task{friction.empty() ? asked.scene : exact,
                         asked.control,
                         asked.prescribed,
                         asked.team,
                         asked.clock,
                         asked.must_stop,
                         asked.limits};
  TiedSystem system(task);
  system.ties().bring_together(answer.displacement);
  answer.seconds.setup = task.clock.seconds();
  CoupledRound end = CoupledRound::finished;
  do {
    FlexibleGradients gradients = system.gradients(friction.pulls());
    Answer round;
    end = gradients.solve(system, answer.displacement, round);
    answer.iterations += round.iterations;
    answer.residual = round.residual;
    if (end == CoupledRound::stalled)
      return give_up(answer, gradients.problem());
    if (end != CoupledRound::finished || friction.empty())
      break;
    answer.tie_press = press_of_ties(task.scene, system.beyond_loads(answer.displacement, friction.pulls()));
  } while (friction.needs_another_round(answer.displacement, answer.tie_press));
  if (friction.status() != Status::done)
    return give_up(answer, friction.message());
  answer.rubbing = friction.borders();
  system.find_energy_and_reactions(answer.displacement, friction.pulls(), answer);
  if (end != CoupledRound::finished)
    answer.reaction.clear();
  if (task.limits == nullptr || !breaks_limits(task.scene, *task.limits, task.team, answer.displacement, 0))
    answer.message = friction.message();
  else if (!obey_limits(system, answer))
    return false;
  else if (!friction.message().empty())
    answer.message += (answer.message.empty() ? "" : "; ") + friction.message();
  return end == CoupledRound::finished;
}

} // namespace maille::deform
