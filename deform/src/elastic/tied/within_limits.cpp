#include "elastic/tied/within_limits.hpp"

#include "control/method.hpp"
#include "elastic/tied/tied_limits.hpp"
#include "feasible/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace maille::deform {

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

bool keep_within_limits(TiedModel& model, TiedLinks& links, const std::vector<List<double>>& loads,
                        double penalty, bool knows_forces, Displacement& u, Answer& answer) {
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
