#include "elastic/tied/tied_model.hpp"

#include "control/method.hpp"
#include "elastic/limits/constrained_minimum.hpp"
#include "feasible/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace maille::deform {

namespace {

/// The search ends by the energy norm, and the forces of slender bodies need more accuracy than that.
constexpr double share_of_tolerance = 0.1;

std::string border_of(const NodeTie& tie) {
  return tie.normal == Vec3{}
             ? std::string("where labels are joined")
             : fmt::format("the border between labels {} and {}", tie.label[0], tie.label[1]);
}

} // namespace

void subtract_loads(const Loads& loads, Displacement& field) {
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < loads[b].size(); ++i)
      field(b, i) -= loads[b][i];
}

std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces) {
  model.ties().take_out_tie_forces(forces);
  return reactions_of(model.task().scene, Loads{}, forces);
}

bool keep_within_limits(TiedModel& model, const Loads& loads, const SearchScale& scale, bool knows_forces,
                        Displacement& u, Answer& answer) {
  const CoupledTask& task = model.task();
  const double tolerance = task.scene.relaxation.tolerance;
  ConstrainedMinimum minimum(task, model, model.moduli(), all_components(task.scene), loads, scale.stiffer);
  const bool is_found = minimum.solve(u, share_of_tolerance * tolerance / scale.sharper, answer);
  answer.reaction.clear();
  if (knows_forces && is_found) {
    answer.message = fmt::format("limits are active: least energy within them, with multipliers of {} links",
                                 minimum.n_active());
    Displacement forces = minimum.release_residual();
    model.apply(u, forces);
    minimum.add_forces_of_limits(forces);
    subtract_loads(loads, forces);
    answer.reaction = reactions_of_tied(model, forces);
  }
  FeasibleSet(task.scene, *task.limits, task.control.threads).bring_in(task.prescribed, u);
  const double largest = largest_entry(u);
  if (largest == 0)
    return is_found;
  const OpenTie widest = widest_tie(task.scene.tied, u);
  answer.residual = std::min(1.0, std::max(minimum.error(), widest.gap / largest));
  if (widest.gap <= tolerance * largest)
    return is_found;
  answer.message =
      fmt::format("within the limits {} stays open by up to {:.3g} mm, {:.2g} of the largest displacement: "
                  "{}",
                  border_of(*widest.tie), widest.gap * 1e3, widest.gap / largest,
                  task.must_stop() ? "the solve was cut short"
                                   : "what is asked for on its two sides cannot be had together, or the "
                                     "search has not converged");
  return false;
}

} // namespace maille::deform
