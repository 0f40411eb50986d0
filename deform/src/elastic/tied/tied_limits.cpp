#include "elastic/tied/tied_limits.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

constexpr int most_rounds = 3000;
constexpr double forward = 1.6; ///< of a step, beyond the state
/// A round need not be exact: the next one begins where it ends.
constexpr int most_steps = 30;
constexpr double reduction = 0.2;
/// When one of the two residuals exceeds `imbalance` times the other, the penalty changes by
/// `change_of_penalty`; checked every `rounds_between_changes` rounds, and not after `last_change`, so that
/// rounds converge.
constexpr double imbalance = 8, change_of_penalty = 2;
constexpr int rounds_between_changes = 12, last_change = most_rounds / 2;

} // namespace

LeastWithinLimits::LeastWithinLimits(TiedModel& model, TiedLinks& links,
                                     const std::vector<List<double>>& loads, double penalty)
    : model_(model), links_(links), loads_(loads), penalty_(penalty),
      residual_(model.task().scene.specimen.grid), correction_(residual_), direction_(residual_),
      image_(residual_), sums_(model.task().scene.specimen.grid, model.task().team) {
  model_.set_penalty(penalty_);
}

void LeastWithinLimits::apply(const Displacement& u, Displacement& forces) {
  model_.apply(u, forces);
  links_.add_forces(u, penalty_, forces, model_.task().team);
}

void LeastWithinLimits::find_residual(const Displacement& u, Displacement& residual) {
  apply(u, image_);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < residual.n_nodes(); ++i)
      residual(b, i) = (loads_[b].empty() ? 0 : loads_[b][i]) - image_(b, i);
  links_.add_pull_to_parts(penalty_, residual, model_.task().team);
}

/// The state that is nearest to the parts of the links, less multipliers, at the price of its energy.
void LeastWithinLimits::take_state(Displacement& u, Answer& answer) {
  u_ = &u;
  find_residual(u, residual_);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < residual_.n_nodes(); ++i)
      if (model_.is_fixed()[b][i])
        residual_(b, i) = 0;
  ReductionWatch watch(most_steps, reduction, model_.task().must_stop);
  conjugate_gradients(*this, watch);
  answer.iterations += watch.iterations();
}

bool LeastWithinLimits::balance_forces(Displacement u, double tolerance, Displacement& forces,
                                       Answer& answer) {
  const auto& is_fixed = model_.is_fixed();
  for (int round = 0; round < most_rounds && !model_.task().must_stop(); ++round) {
    find_residual(u, forces);
    for (double& force : forces.values())
      force = -force; // what holds a fixed component
    model_.ties().take_out_tie_forces(forces);
    double missing = 0, all = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < forces.n_nodes(); ++i) {
        const double load = loads_[b].empty() ? 0 : std::abs(loads_[b][i]);
        missing += is_fixed[b][i] ? 0 : std::abs(forces(b, i));
        all += is_fixed[b][i] ? std::abs(forces(b, i)) : load;
      }
    if (missing <= tolerance * all)
      return true;
    take_state(u, answer);
  }
  return false;
}

double LeastWithinLimits::precondition() {
  model_.precondition(residual_, correction_);
  return sums_.dot(residual_, correction_);
}

std::optional<double> LeastWithinLimits::find_step(double beta, double) {
  sums_.add(1, correction_, beta, direction_);
  apply(direction_, image_);
  const double curvature = sums_.dot(direction_, image_);
  if (!(curvature > 0))
    return std::nullopt;
  return sums_.dot(residual_, direction_) / curvature;
}

void LeastWithinLimits::take_step(double step) {
  sums_.add(step, direction_, 1, *u_);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < residual_.n_nodes(); ++i)
      if (!model_.is_fixed()[b][i])
        residual_(b, i) -= step * image_(b, i);
  overlap_ = sums_.dot(residual_, correction_);
}

void LeastWithinLimits::balance(const TiedLinks::Round& round) {
  double factor = 1;
  if (round.apart > imbalance * round.moved)
    factor = change_of_penalty;
  else if (round.moved > imbalance * round.apart)
    factor = 1 / change_of_penalty;
  if (factor == 1)
    return;
  penalty_ *= factor;
  links_.scale_multipliers(1 / factor);
  model_.set_penalty(penalty_);
}

bool LeastWithinLimits::solve(Displacement& u, double tolerance, Answer& answer) {
  const CoupledTask& task = model_.task();
  links_.begin(u, task.team);
  for (int n = 1; n <= most_rounds && !task.must_stop(); ++n) {
    take_state(u, answer);
    const TiedLinks::Round round = links_.take(u, forward, task.team);
    missed_ = round.apart;
    if (std::max(round.apart, round.moved) <= tolerance)
      return true;
    if (n % rounds_between_changes == 0 && n <= last_change)
      balance(round);
    if (task.control.progress)
      task.control.progress(std::min(0.99, n / 100.0), "within limits");
  }
  return false;
}

} // namespace maille::deform
