#include "elastic/tied/tied_limits.hpp"

#include "control/method.hpp"
#include "feasible/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

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

LeastWithinLimits::LeastWithinLimits(TiedModel& model, TiedLinks& links, const Loads& loads, double penalty)
    : FieldGradients(3, model.fixed(), FieldSums(model.task().scene.specimen.grid, model.task().team)),
      model_(model), links_(links), loads_(loads), penalty_(penalty) {
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
  begin(*this, u);
  find_residual(u, residual_);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < residual_.n_nodes(); ++i)
      if (fixed_(b, i))
        residual_(b, i) = 0;
  ReductionWatch watch(most_steps, reduction, model_.task().must_stop);
  conjugate_gradients(*this, watch);
  answer.iterations += watch.iterations();
}

bool LeastWithinLimits::balance_forces(Displacement u, double tolerance, Displacement& forces,
                                       Answer& answer) {
  for (int round = 0; round < most_rounds && !model_.task().must_stop(); ++round) {
    find_residual(u, forces);
    for (double& force : forces.values())
      force = -force; // what holds a fixed component
    model_.ties().take_out_tie_forces(forces);
    double missing = 0, all = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < forces.n_nodes(); ++i) {
        const double load = loads_[b].empty() ? 0 : std::abs(loads_[b][i]);
        missing += fixed_(b, i) ? 0 : std::abs(forces(b, i));
        all += fixed_(b, i) ? std::abs(forces(b, i)) : load;
      }
    if (missing <= tolerance * all)
      return true;
    take_state(u, answer);
  }
  return false;
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

namespace {

/// Rounds end by changes, and what is left of a long body is more than the last one.
constexpr double share_of_tolerance = 0.1;

std::string border_of(const NodeTie& tie) {
  return tie.normal == Vec3{}
             ? std::string("where labels are joined")
             : fmt::format("the border between labels {} and {}", tie.label[0], tie.label[1]);
}

} // namespace

std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces) {
  model.ties().take_out_tie_forces(forces);
  std::vector<double> reaction;
  for (const Prescribed& p : model.task().scene.prescribed)
    reaction.push_back(forces(p.component, p.node));
  return reaction;
}

bool keep_within_limits(TiedModel& model, TiedLinks& links, const Loads& loads, double penalty,
                        bool knows_forces, Displacement& u, Answer& answer) {
  const CoupledTask& task = model.task();
  const double tolerance = task.scene.relaxation.tolerance, before = largest_entry(u);
  links.set_limits(task.scene, *task.limits);
  LeastWithinLimits least(model, links, loads, penalty);
  bool is_found = least.solve(u, share_of_tolerance * tolerance * before, answer);
  answer.reaction.clear();
  if (knows_forces && is_found) {
    answer.message = fmt::format("limits are active: least energy within them, with multipliers of {} links",
                                 links.n_active());
    Displacement forces(task.scene.specimen.grid);
    is_found = least.balance_forces(u, share_of_tolerance * tolerance, forces, answer);
    for (const Prescribed& p : task.scene.prescribed)
      if (is_found)
        answer.reaction.push_back(forces(p.component, p.node));
    if (!is_found)
      answer.message += "; their forces do not balance to the tolerance, so none are given";
  }
  FeasibleSet(task.scene, *task.limits, task.control.threads).bring_in(task.prescribed, u);
  const double largest = largest_entry(u);
  if (largest == 0)
    return is_found;
  const OpenTie widest = widest_tie(task.scene.tied, u);
  answer.residual = std::max(is_found ? 0.0 : answer.residual, std::min(1.0, widest.gap / largest));
  if (widest.gap <= tolerance * largest)
    return is_found;
  answer.message =
      fmt::format("within the limits {} stays open by up to {:.3g} mm, {:.2g} of the largest displacement: "
                  "{}",
                  border_of(*widest.tie), widest.gap * 1e3, widest.gap / largest,
                  task.must_stop() ? "the solve was cut short"
                                   : "what is asked for on its two sides cannot be had together, or rounds "
                                     "came to no end");
  return false;
}

} // namespace maille::deform
