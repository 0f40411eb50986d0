#pragma once
/// Conjugate gradients in float32 for corrections of a state in float64.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_error.hpp"
#include "elastic/krylov/coupled_task.hpp"

#include <array>

namespace maille::deform {

/// Forces of loads, dense, per component; empty: none [N].
using Loads = std::array<List<double>, 3>;

/// Connects the float32 fields of a solver with the float64 state. Residuals are stored in units of `scale`
/// times the
/// body's unit of force.
class MixedState {
public:
  virtual ~MixedState() = default;
  struct Residual {
    double largest = 0; ///< entry, in the unit
    double energy = 0;  ///< u . K u in the body's unit [m^2]
  };
  /// r = loads - K u where components are free, found in float64; the state is to become no change of u.
  /// @param u may be empty until the last round is finished, if the state knows where it begins
  virtual Residual begin_round(const Displacement& u, double scale) = 0;
  /// Work of the loads along the direction, in the unit; called only if there are loads.
  virtual double work_of_loads() = 0;
  /// Takes over into u what the round has found. @param is_last u is the answer
  virtual void finish_round(Displacement& u, bool is_last) = 0;
  /// True if the solver should hand over to its fallback.
  virtual bool gives_up(std::int64_t iterations) {
    (void)iterations;
    return false;
  }
};

/// Iterative refinement in rounds. A round scales the float64 residual r = f - K u to float32 and runs
/// conjugate gradients on K du = r until r . B r has fallen by five digits; u += du, and r is recomputed in
/// float64. So accuracy is that of float64 at the speed of float32. Stops when CoupledError is within the
/// tolerance. If a recomputed residual is not below a hundredth of the one before, the solve is at rounding
/// level, or stalled.
class MixedGradients : private GradientWatch {
public:
  /// @param unit of the body's forces per displacement [N/m] @param expected iterations, for the progress
  MixedGradients(const CoupledTask& task, const Loads& loads, double unit, int expected);

  /// Unit of residuals, over the body's unit [m].
  double scale() const { return scale_; }
  bool is_whole() const { return is_whole_; }
  /// The space holds the whole displacement and its residual, not a change: the first round begins from
  /// there.
  /// @param energy u . K u in the body's unit [m^2]
  void begin_whole(double energy) {
    is_whole_ = true;
    energy_ = energy;
  }
  /// The smallest eigenvalue of the preconditioned operator, as it was met on the way to an earlier answer.
  /// So a residual says from the first iteration on how far the state is, and one that is near enough needs
  /// none.
  void begin_with(double smallest) {
    error_.begin_with(smallest);
    knows_spectrum_ = true;
  }
  double smallest_eigenvalue() const { return error_.smallest_eigenvalue(); }
  /// Solves for u, unless stopped or stalled.
  CoupledRound solve(GradientSpace& space, MixedState& state, Displacement& u, Answer& answer);

private:
  CoupledRound correct(Displacement& u);
  bool goes_on() override;
  bool goes_on_from(double product) override;
  bool is_near_enough(double product);
  bool goes_on_after(double step, double product) override;

  const CoupledTask& task_;
  bool has_loads_;
  int expected_;
  GradientSpace* space_ = nullptr;
  MixedState* state_ = nullptr;
  Answer* answer_ = nullptr;
  bool is_whole_ = false, knows_spectrum_ = false;
  double scale_ = 1;
  double next_scale_ = 1;       ///< of the next round
  double energy_ = 0;           ///< u . K u in the body's unit [m^2]
  double first_ = 0, last_ = 0; ///< r . z of this round
  double round_began_ = 0;      ///< r . z of the last round [m^2]
  double first_began_ = 0;      ///< of the first
  CoupledRound round_ = CoupledRound::used_up;
  CoupledError error_;
};

} // namespace maille::deform
