#pragma once
/// Minimises the energy at finite strain: increments of moves and loads, each by truncated Newton steps.
///
/// Moves and loads are applied in increments: a rotation by parts of its angle, a shift and a load by parts
/// of their size. Each increment starts at the last state, carried along with the object's frame:
///   1. the linear change by the tangent, or, where it turns cells, by linear elasticity in frames that are
///      turned by the angles that this change stands for, whichever has less energy. Pressures are those of
///      the linear change;
///   2. Newton steps: conjugate gradients on the tangent around TurnedPreconditioner, on a positive one far
///      from the minimum and where the exact one is not; then a line search (Armijo 1966) on the true energy.
///      Whole steps may raise it for up to two steps, as the next one brings volumes back; if that does not
///      lower it, the search goes back to the state before (watchdog).
/// Within limits (TurnedLimits) the energy is an augmented Lagrangian, whose multipliers improve between
/// steps; the search is the same.
///
/// A sequence of answers (EarlierAnswers) starts at an exact tangent where earlier answers lead, in one
/// increment. A tangent serves a second step if the state has hardly changed.
///
/// Following pressures (FaceLoad::follows) have the forces of the present state, constant during a step.
///
/// Exact: energy never rises while handles stay, and no accepted state has an inverted cell. Increments
/// between are settled to a hundredth only. One whose start or descent meets inverted cells, or no lower
/// energy, is halved, eight times in all.
///
/// Source  Nocedal and Wright 2006, Numerical Optimization, algorithms 7.1 (truncated Newton) and 15.2
///         (watchdog)

#include "elastic/finite/finite_elasticity.hpp"
#include "elastic/finite/follower_pressure.hpp"
#include "elastic/finite/turned_limits.hpp"
#include "elastic/finite/turned_operator.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/krylov/kept_body.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

/// What answers about one body with some fixed components hand on to the next.
struct FiniteCourse : KeptHierarchy {
  /// @param body must outlive this, as must the team @param make the operator at rest for a task
  FiniteCourse(const Scene& body, std::vector<Prescribed> fixed, ThreadTeam& team,
               const std::function<std::shared_ptr<ElasticOperator>(const CoupledTask&)>& make)
      : prescribed(std::move(fixed)), task{body, control, prescribed, team, clock, [] { return false; }},
        preconditioner(task, make(task)) {}
  bool has_fixed(const std::vector<Prescribed>& components) const {
    return FixedMask(task.scene.specimen.grid, components) == FixedMask(task.scene.specimen.grid, prescribed);
  }
  bool adopt_materials(double) override { return false; }

  const std::vector<Prescribed> prescribed;
  const Control control;
  const Clock clock;
  const CoupledTask task;
  TurnedPreconditioner preconditioner;
  Displacement response; ///< of the last tangent to the push that looks for instability; empty: none yet
  double push = 0;       ///< square of the push in the preconditioner's norm
};

class FiniteMinimum {
public:
  /// Both must outlive this.
  FiniteMinimum(const CoupledTask& task, FiniteCourse& course);

  /// Fills in displacement, iterations, residual, energy; reactions if it came to the end. @return false if
  /// stopped, or given up
  /// @param has_arrived begin at the task's start, from rest only where that leads to no minimum; true: it
  ///        differs little from what is prescribed, which is put in place. Nothing: from rest
  bool solve(Answer& answer, std::optional<bool> has_arrived = std::nullopt);
  /// Minimises the energy within limits, from a state with handles in place. The result is within the limits
  /// up to the estimated error. @param at_rest the operator in the preconditioner
  bool minimise_within(const LinkLimits& limits, PenalizedOperator& at_rest, Displacement start,
                       Answer& answer);
  /// Applied share of moves and loads in the present state: 1 at the end.
  double fraction() const { return fraction_; }
  int increments() const { return n_increments_; }
  std::int64_t n_inverted() const { return elasticity_.n_inverted(); }
  /// True if the tangent is not positive along some direction at the end: the state is unstable.
  bool is_unstable() const { return is_unstable_; }
  /// Called with every accepted state: applied share, and energy minus the work of loads [J].
  std::function<void(double fraction, double energy)> watch;

private:
  using Convexity = FiniteElasticity::Convexity;
  enum class End { settled, stopped, failed };
  struct State {
    Displacement u, gradient; ///< gradient of the energy minus loads, at all nodes
    double energy = 0;        ///< less the work of loads [J]
    double elastic = 0;       ///< [J]
  };

  int planned_increments() const;
  End go_on(bool has_arrived, Answer& answer);
  End go_to(double fraction, Answer& answer);
  void carry(const Scene& from, const Scene& to);
  End predict(const Scene& to, Answer& answer);
  bool solve_for(ElasticOperator& K, const Displacement& residual, double reduction, Displacement& d,
                 Answer& answer, double enough = 0);
  void linearise(Convexity convexity, bool may_refresh);
  void find_newton_direction(double goal, Displacement& direction, Answer& answer);
  End descend(double goal, Answer& answer, Convexity convexity = Convexity::positive);
  void look_for_instability(Answer& answer);
  double estimated_error(double slope) const;
  bool finish(End end, Answer& answer);
  bool step_downhill(const Displacement& direction, double slope, State& next);
  bool step_on_trial(const Displacement& direction, State& next);
  void evaluate(State& state);
  void put_on_loads_of(const Scene& step);
  bool turn_loads();
  void mask(Displacement& field) const;

  const CoupledTask& task_;
  Scene scene_; ///< the task's, without the search for a taut scale
  LatticeElasticity linear_;
  FiniteElasticity elasticity_;
  FiniteCourse& course_;
  TurnedPreconditioner& preconditioner_;
  FieldSums sums_;
  std::optional<TurnedLimits> limits_;     ///< if limits apply; so is the next
  PenalizedOperator* penalized_ = nullptr; ///< gets the penalties of limits_
  State state_;
  Displacement loads_;         ///< of the present increment [N]; no components: none
  Displacement dead_loads_;    ///< those that do not follow their faces [N]
  FollowerPressure followers_; ///< of the present increment
  double fraction_ = 0;
  double floor_ = 0; ///< twice an energy that is rounding [J]
  int n_increments_ = 0;
  FieldGradients gradients_;
  int solve_iterations_ = 0;            ///< of the last solve
  double first_product_ = 0;            ///< square of its residual, in the preconditioner's norm [J]
  bool has_negative_curvature_ = false; ///< the last solve met a direction of negative curvature
  bool has_failed_ = false;             ///< the last solve found no direction
  bool is_unstable_ = false;
};

} // namespace maille::deform
