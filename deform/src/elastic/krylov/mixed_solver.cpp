#include "elastic/krylov/mixed_solver.hpp"

#include "elastic/krylov/kept_body.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Reduction of r . z per round in float32; then the residual is recomputed in float64.
constexpr double reduction_per_round = 1e-10;
/// Residuals above this or below its inverse are rescaled, to stay in the range of float32.
constexpr double largest_residual = 1e8;

} // namespace

MixedSolver::MixedSolver(const CoupledTask& task)
    : task_(task), loads_(loads_of(task.scene)),
      has_loads_(std::ranges::any_of(loads_, [](const auto& along) { return !along.empty(); })),
      convergence_(task.scene.relaxation.tolerance) {}

void MixedSolver::begin(double unit, double& smallest) {
  smallest_ = &smallest;
  if (smallest > 0 && task_.kept != nullptr && !task_.kept->begins_anew)
    convergence_.begin_with(smallest);
  scale_ = task_.scene.largest_prescribed();
  if (!(scale_ > 0)) // loads alone
    for (const auto& along : loads_)
      for (const double load : along)
        scale_ = std::max(scale_, std::abs(load) / unit);
  if (!(scale_ > 0))
    scale_ = 1;
}

bool MixedSolver::should_continue() {
  if (first_ != 0 && last_ <= reduction_per_round * first_) {
    next_scale_ = scale_ * std::sqrt(last_ / first_);
    round_ = CoupledRound::used_up;
    return false;
  }
  if (answer_->iterations >= most_coupled_iterations || task_.must_stop()) {
    round_ = CoupledRound::stopped;
    return false;
  }
  if (should_fall_back && should_fall_back(answer_->iterations)) {
    round_ = CoupledRound::stalled;
    return false;
  }
  task_.show_progress(answer_->residual);
  return true;
}

bool MixedSolver::should_continue_from(double product) {
  const double began = product * scale_ * scale_;
  if (convergence_.starts_within(began, energy_)) {
    answer_->residual = convergence_.residual();
    round_ = CoupledRound::finished;
    return false;
  }
  if (first_ != 0)
    return true;
  convergence_.starts(began);
  if (!(product > 0) || (round_began_ > 0 && began > 0.01 * round_began_)) {
    const bool is_converged = convergence_.without_descent(began, energy_) == Convergence::End::converged;
    round_ = is_converged ? CoupledRound::finished : CoupledRound::stalled;
    return false;
  }
  round_began_ = began;
  first_ = product;
  return true;
}

bool MixedSolver::should_continue_after(double step, double product) {
  const double gain = step * product * scale_ * scale_;
  // u . K u after a step, from p . K p = p . f - p . r
  energy_ += (has_loads_ ? 2 * step * scale_ * work_of_loads() : 0) - gain;
  last_ = product;
  ++answer_->iterations;
  convergence_.add(step, product, scale_);
  const bool is_within = convergence_.is_within(energy_);
  answer_->residual = convergence_.residual();
  if (is_within)
    round_ = CoupledRound::finished;
  return !is_within;
}

/// One round with a residual that is carried along.
CoupledRound MixedSolver::correct(Displacement& u) {
  if (!is_whole_) {
    if (!(scale_ > 0))
      scale_ = 1;
    Residual residual = begin_round(u, scale_);
    if (residual.largest > 0 &&
        (residual.largest < 1 / largest_residual || residual.largest > largest_residual)) {
      scale_ *= residual.largest;
      residual = begin_round(u, scale_);
    }
    energy_ = residual.energy;
  }
  next_scale_ = scale_;
  first_ = last_ = 0;
  convergence_.restart();
  if (conjugate_gradients(space(), *this) != GradientsEnd::told)
    round_ = CoupledRound::used_up;
  finish_round(u, round_);
  if (is_whole_ && round_ == CoupledRound::used_up) {
    round_began_ = 0; // float64 residuals resolve what float32 ones cannot
    is_whole_ = false;
  }
  scale_ = next_scale_;
  return round_;
}

CoupledRound MixedSolver::solve(Displacement& u, Answer& answer) {
  answer_ = &answer;
  answer.residual = 1;
  while (correct(u) == CoupledRound::used_up) {
  }
  if (round_ == CoupledRound::finished && convergence_.is_empty() && answer.residual == 1)
    answer.residual = 0; // nothing was left to begin with
  if (round_ == CoupledRound::finished && (*smallest_ > 0 || convergence_.is_measured()))
    *smallest_ = convergence_.smallest_eigenvalue();
  return round_;
}

} // namespace maille::deform
