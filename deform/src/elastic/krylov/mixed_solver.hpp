#pragma once
/// One kind of body in mixed precision: iterative refinement in float32 of a state in float64.
///
/// Scheme: a round scales the float64 residual r = f - K u to float32 and runs conjugate gradients on K du =
/// r until r . B r has fallen by ten digits; u += du, and r is recomputed in float64. So accuracy is that of
/// float64 at the speed of float32. Stops when Convergence is within the tolerance. If r . B r of a
/// recomputed residual is not below a hundredth of that of the round before, the solve is at rounding level,
/// or stalled.
///
/// The ladder (elastic/ladder) calls solve(), and on failure goes on with system_of_slender() in float64.
/// BoxSolver and MaskedSolver derive from it; they define how a round begins and ends.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/convergence.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"

#include <functional>

namespace maille::deform {

class MixedSolver : private GradientWatch {
public:
  /// For reports.
  virtual const char* algorithm() const = 0;
  virtual ElasticOperator& system() = 0;
  /// The same, with K applied so that rounding in float64 does not hide the bending of slender bodies.
  virtual ElasticOperator& system_of_slender() { return system(); }
  /// Solves for u, unless stopped or stalled. An empty u starts at rest with the prescribed values.
  virtual CoupledRound solve(Displacement& u, Answer& answer);
  /// Energy, and reactions of the scene's prescribed components.
  virtual void find_energy_and_reactions(const Displacement& u, Answer& answer) = 0;
  /// Asked before every iteration: true if the ladder's next rung has become cheaper. None: never.
  std::function<bool(std::int64_t iterations)> should_fall_back;

protected:
  explicit MixedSolver(const CoupledTask& task);
  /// @param unit of the body's forces per displacement [N/m] @param smallest eigenvalue of the preconditioned
  /// operator that an earlier answer of this body has found; 0: none. Must outlive this
  void begin(double unit, double& smallest);
  /// Unit of residuals, over the body's unit [m].
  double scale() const { return scale_; }
  bool is_whole() const { return is_whole_; }
  /// The space holds the whole displacement and its residual, not a change: the first round begins from
  /// there. @param energy u . K u in the body's unit [m^2]
  void begin_whole(double energy) {
    is_whole_ = true;
    energy_ = energy;
  }

  struct Residual {
    double largest = 0; ///< entry, in the unit
    double energy = 0;  ///< u . K u in the body's unit [m^2]
  };
  virtual GradientSpace& space() = 0;
  /// r = loads - K u where components are free, found in float64 and stored in units of `scale` times the
  /// body's unit of force; the float32 correction becomes 0.
  /// @param u may be empty until the last round is finished, if the state knows where it begins
  virtual Residual begin_round(const Displacement& u, double scale) = 0;
  /// Work of the loads along the direction, in the unit; called only if there are loads.
  virtual double work_of_loads() = 0;
  /// Adds to u what the round has found. @param end used_up: more rounds follow
  virtual void finish_round(Displacement& u, CoupledRound end) = 0;

  const CoupledTask& task_;
  Loads loads_;
  bool has_loads_;

private:
  CoupledRound correct(Displacement& u);
  bool should_continue() override;
  bool should_continue_from(double product) override;
  bool should_continue_after(double step, double product) override;

  double* smallest_ = nullptr;
  Answer* answer_ = nullptr;
  bool is_whole_ = false;
  double scale_ = 1;
  double next_scale_ = 1;       ///< of the next round
  double energy_ = 0;           ///< u . K u in the body's unit [m^2]
  double first_ = 0, last_ = 0; ///< r . z of this round
  double round_began_ = 0;      ///< r . z of the last round [m^2]
  CoupledRound round_ = CoupledRound::used_up;
  Convergence convergence_;
};

} // namespace maille::deform
