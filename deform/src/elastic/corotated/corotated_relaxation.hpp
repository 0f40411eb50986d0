#pragma once
/// Large turns: the least energy of CorotatedElasticity, reached in increments, around the multigrid of the
/// body at rest.

#include "elastic/corotated/corotated_elasticity.hpp"
#include "elastic/corotated/limits_in_blocks.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"

#include "maille/base/arena.hpp"

#include <deque>
#include <functional>
#include <memory>
#include <optional>

namespace maille::deform {

/// The preconditioner of the body at rest, for the bent body: forces are turned back node by node, by the
/// mean of the frames around, and the correction is turned forth. In coordinates that turn with the body its
/// stiffness is nearly that at rest; the rest is of the order of a cell over the radius of a bend. So the
/// hierarchy is made once and serves every state.
///
/// Nodes of which only some components are free stay unturned: their directions are the world's.
class CorotatedPreconditioner {
public:
  /// @param at_rest preconditioner of the body at rest
  CorotatedPreconditioner(const CoupledTask& task, std::shared_ptr<ElasticOperator> at_rest);

  void turn_with(const CorotatedElasticity& elasticity);
  /// See ElasticOperator. @param residual changed
  void apply(Displacement& residual, Displacement& correction);

private:
  void turn(Displacement& field, bool forth) const;

  const CoupledTask& task_;
  std::shared_ptr<ElasticOperator> at_rest_;
  List<bool> may_turn_;               ///< by node
  List<Eigen::Quaterniond> rotation_; ///< by node
};

/// Limited-memory BFGS around a preconditioner. Its direction leads downhill whatever the energy is, for only
/// steps along which the energy curves upwards are remembered.
///
/// Source  Nocedal 1980 (Math. Comput. 35); with the multigrid of a constant operator in its middle: Liu,
///         Bouaziz, Kavan 2017 (ACM TOG 36), "Quasi-Newton methods for real-time simulation of hyperelastic
///         materials". docs/theory.md, section 4, accelerates local and global steps by Anderson's method,
///         which mixes the same past steps but minimises no energy
class QuasiNewton {
public:
  QuasiNewton(const Grid& grid, FieldSums& sums) : grid_(grid), sums_(sums) {}

  /// Turns `field`, the gradient where components are free and zero elsewhere, into minus a direction.
  /// @param precondition (residual, changed; correction)
  void apply(Displacement& field, const std::function<void(Displacement&, Displacement&)>& precondition);
  /// Remembers a step and what it did to the gradient, if energy curves upwards along it. @param slope of the
  /// energy along the whole step at its beginning, negative
  void remember(Displacement step, Displacement change_of_gradient, double slope);
  void forget() { pairs_.clear(); }
  bool is_empty() const { return pairs_.empty(); }

private:
  struct Pair {
    Displacement step, change;
    double inverse = 0; ///< of step . change
  };
  static constexpr std::size_t most_pairs = 6;
  static constexpr double least_curvature = 0.05; ///< of the slope

  Grid grid_;
  FieldSums& sums_;
  std::deque<Pair> pairs_; ///< oldest first
};

/// Moves and loads are put on in increments: a turn by parts of its angle, a shift and a load by parts of
/// their size. Each begins from the last one's state, carried along with the object's frame, then
///   1. conjugate gradients for the linear change in the frames that cells have (to a hundredth, for it is
///      only a start);
///   2. frames turned by the angles that the change stands for, and the least energy in those, if that is
///      less in the true energy;
///   3. quasi-Newton descent of the true energy, every step of which must lower it (Armijo 1966).
/// Energy therefore never rises while handles stay. Increments between are settled to a hundredth only. One
/// in which cells would be turned inside out, or turn by more than 120 degrees, is halved.
class CorotatedRelaxation {
public:
  /// @param task of a scene in 2D or 3D; must outlive this
  /// @param at_rest operator of the body at rest, whose preconditioner it takes
  CorotatedRelaxation(const CoupledTask& task, std::shared_ptr<ElasticOperator> at_rest);

  /// Fills in displacement, iterations, residual, energy; reactions if it came to the end. @return false if
  /// stopped, or given up
  bool solve(Answer& answer);
  /// Likewise for the least energy within limits, from a state in which handles are in place: step 3 with an
  /// augmented Lagrangian, whose penalties the multigrid knows. Each step is followed by better multipliers
  /// unless the minimum for these is farther away than the limits are. The state found is within the limits
  /// but for the estimated error. @param at_rest the operator of the constructor
  bool minimise_within(const LinkLimits& limits, PenalizedOperator& at_rest, Displacement start,
                       Answer& answer);
  /// How much of moves and loads is on in the present state: 1 at the end.
  double fraction() const { return fraction_; }
  int increments() const { return n_increments_; }
  std::int64_t n_inverted() const { return elasticity_.n_inverted(); }
  /// Told of every state that the descent accepts: how much is on, and the energy less the work of loads [J].
  std::function<void(double fraction, double energy)> watch;

private:
  enum class End { settled, stopped, torn };
  struct State {
    Displacement u, gradient; ///< gradient of the energy less loads; everywhere
    double energy = 0;        ///< less the work of loads [J]
    double elastic = 0;       ///< [J]
  };

  int planned_increments() const;
  double turn_of_handles(const Scene& to) const;
  End go_to(double fraction, Answer& answer);
  void carry(const Scene& from, const Scene& to);
  End predict(const Scene& to, Answer& answer);
  class FixedFrames;
  bool solve_in_fixed_frames(Displacement& d, const Displacement& residual, Answer& answer);
  End descend(double goal, Answer& answer);
  double estimated_error(double slope) const;
  bool finish(End end, Answer& answer);
  bool step_downhill(const Displacement& direction, double slope, State& next);
  void evaluate(State& state);
  void put_on_loads_of(const Scene& step);
  void mask(Displacement& field) const;
  bool is_torn() const;
  void find_reactions(Answer& answer) const;

  const CoupledTask& task_;
  Scene scene_; ///< the task's, its taut scale out of the way
  LatticeElasticity linear_;
  CorotatedElasticity elasticity_;
  CorotatedPreconditioner preconditioner_;
  FieldSums sums_;
  QuasiNewton memory_;
  std::optional<LimitsInBlocks> limits_;   ///< once they count, as the next
  PenalizedOperator* penalized_ = nullptr; ///< gets the penalties of limits_
  State state_;
  Displacement loads_; ///< of the present increment [N]; no components: none
  double fraction_ = 0;
  double floor_ = 0; ///< twice an energy that is rounding [J]
  int n_increments_ = 0;
};

} // namespace maille::deform
