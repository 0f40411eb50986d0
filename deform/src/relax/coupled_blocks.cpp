#include "relax/coupled_blocks.hpp"

#include "maille/scene/block_frames.hpp"
#include "method.hpp"
#include "relax/corotated_relaxation.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace maille::deform {

namespace {

constexpr std::int64_t nodes_worth_threads = 3000;

void add_sentence(std::string& message, const std::string& sentence) {
  message += message.empty() ? sentence : "; " + sentence;
}

std::string message_for(const Scene& scene, const Answer& answer, const CorotatedRelaxation& relaxation) {
  std::string message;
  if (relaxation.fraction() < 1)
    add_sentence(message, fmt::format("cut short when {:.3g} % of moves and loads were on: handles are there",
                                      100 * relaxation.fraction()));
  if (relaxation.n_inverted() > 0)
    add_sentence(message, fmt::format("{} cells are turned inside out", relaxation.n_inverted()));
  if (scene.limits.from != LimitSource::taut) {
    const double violation = largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement);
    add_sentence(message,
                 "limits are not enforced in blocks" +
                     (violation > 1e-9 ? fmt::format(": broken by up to {:.3g} of a link's length", violation)
                                       : std::string(", and none is broken")));
  }
  if (scene.relaxation.extrapolation != Extrapolation::none)
    add_sentence(message, "nothing is extrapolated in blocks");
  return message;
}

} // namespace

Answer solve_coupled_in_blocks(const Scene& scene, const Control& control) {
  const Clock clock;
  std::optional<Status> stopped;
  ThreadTeam team(scene.specimen.grid.n_nodes() < nodes_worth_threads ? 1 : std::max(1, control.threads));
  const CoupledTask task{scene, control, scene.prescribed, team, clock, [&] {
                           if (!stopped)
                             stopped = reason_to_stop(control, clock);
                           return stopped.has_value();
                         }};
  Answer answer;
  answer.method = "coupled";
  CorotatedRelaxation relaxation(task);
  answer.seconds.setup = clock.seconds();
  const bool came_to_the_end = relaxation.solve(answer);
  answer.algorithm =
      fmt::format("lattice elasticity in a frame for every cell, quasi-Newton around multigrid, "
                  "{} increment{}",
                  relaxation.increments(), relaxation.increments() == 1 ? "" : "s");
  answer.message = message_for(scene, answer, relaxation);
  answer.status = came_to_the_end ? Status::done : stopped.value_or(Status::budget_reached);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  answer.bytes += bytes_of(answer.displacement);
  return answer;
}

} // namespace maille::deform
