#include "elastic/finite/coupled_finite.hpp"

#include "control/method.hpp"
#include "elastic/finite/finite_minimum.hpp"
#include "elastic/ladder/ladder.hpp"
#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Bisections for the share of moves and loads that limits allow: to 3 %.
constexpr int halvings = 5;

void add_sentence(std::string& message, const std::string& sentence) {
  message += message.empty() ? sentence : "; " + sentence;
}

std::string message_for(const Scene& scene, const FiniteMinimum& minimum) {
  std::string message;
  if (minimum.fraction() < 1)
    add_sentence(message, fmt::format("cut short when {:.3g} % of moves and loads were on: handles are there",
                                      100 * minimum.fraction()));
  if (minimum.n_inverted() > 0)
    add_sentence(message, fmt::format("{} cells are turned inside out", minimum.n_inverted()));
  if (minimum.is_unstable())
    add_sentence(message, "unstable: a small push makes the body leave this state");
  if (scene.relaxation.extrapolation != Extrapolation::none)
    add_sentence(message, "nothing is extrapolated at finite strain");
  return message;
}

/// Calls solve(minimum, task, answer), which returns true if it converged.
/// @param fraction receives the applied share of moves and loads @param make the course for a task
template<class Make, class Solve>
Answer minimised(const Scene& scene, const Control& control, KeptBody* kept, double* fraction,
                 const Make& make, const Solve& solve) {
  const Clock clock;
  std::optional<Status> stopped;
  std::optional<ThreadTeam> own_team;
  ThreadTeam& team = kept != nullptr ? kept->team() : own_team.emplace(elastic_threads(scene, control));
  CoupledTask task{scene, control, scene.prescribed, team, clock, [&] {
                     if (!stopped)
                       stopped = reason_to_stop(control, clock);
                     return stopped.has_value();
                   }};
  task.kept = kept;
  Answer answer;
  answer.method = "coupled";
  std::unique_ptr<KeptHierarchy> own;
  std::unique_ptr<KeptHierarchy>& hierarchy = kept != nullptr ? kept->hierarchy : own;
  auto* course = dynamic_cast<FiniteCourse*>(hierarchy.get());
  if (course == nullptr || !course->has_fixed(scene.prescribed)) {
    hierarchy.reset(); // so that two never coexist
    auto made =
        std::make_unique<FiniteCourse>(kept != nullptr ? kept->scene() : scene, scene.prescribed, team, make);
    course = made.get();
    hierarchy = std::move(made);
  }
  FiniteMinimum minimum(task, *course);
  answer.seconds.setup = clock.seconds();
  const bool is_converged = solve(minimum, task, answer);
  answer.algorithm = fmt::format("lattice at finite strain, Newton steps around multigrid, "
                                 "{} increment{}",
                                 minimum.increments(), minimum.increments() == 1 ? "" : "s");
  answer.message = message_for(scene, minimum);
  if (fraction != nullptr)
    *fraction = minimum.fraction();
  const bool is_whole = is_converged && minimum.n_inverted() == 0;
  answer.status = is_whole ? Status::done : stopped.value_or(Status::budget_reached);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  return answer;
}

/// Minimises the energy without limits.
Answer least_elastic(const Scene& scene, const Control& control, KeptBody* kept = nullptr,
                     double* fraction = nullptr) {
  double reached = 1;
  Answer answer = minimised(scene, control, kept, &reached, make_operator,
                            [](FiniteMinimum& minimum, CoupledTask& task, Answer& found) {
                              Displacement start;
                              const std::optional<bool> has_arrived =
                                  task.kept != nullptr
                                      ? task.kept->answers.find_course(task.scene, task.prescribed, start)
                                      : std::nullopt;
                              task.start = &start;
                              return minimum.solve(found, has_arrived);
                            });
  if (kept != nullptr && reached > 0 && (is_converged(answer.status) || control.seconds_budget))
    kept->answers.add(reached < 1 ? scaled(scene, reached) : scene, answer.displacement);
  if (fraction != nullptr)
    *fraction = reached;
  return answer;
}

double energy_of(const Scene& scene, const Displacement& u, int threads) {
  const LatticeElasticity linear(scene);
  FiniteElasticity elasticity(scene, linear);
  ThreadTeam team(std::max(1, threads));
  Displacement forces(scene.specimen.grid);
  return elasticity.evaluate(u, forces, team);
}

/// Largest change over largest displacement.
double change_between(const Displacement& from, const Displacement& to) {
  double change = 0;
  for (std::size_t i = 0; i < from.values().size(); ++i)
    change = std::max(change, std::abs(to.values()[i] - from.values()[i]));
  return change > 0 ? change / std::max(largest_entry(from), largest_entry(to)) : 0;
}

/// Strain energy minus the work of loads [J].
double potential(const Scene& scene, const Answer& answer) {
  double sum = *answer.strain_energy;
  for (int b = 0; b < scene.dimension(); ++b) {
    const List<double> loads = nodal_forces(scene, b);
    for (std::size_t i = 0; i < loads.size(); ++i)
      sum -= loads[i] * answer.displacement(static_cast<std::size_t>(b), i);
  }
  return sum;
}

/// Margins of projections, as parts of the interval: from the elastic state; and from a state within the
/// limits but for its tolerance, where the first that suffices is used.
constexpr double narrowed_far = 1e-2;
constexpr std::array<double, 3> narrowed_near{1e-4, 1e-3, narrowed_far};

/// Minimises the energy within limits; cuts moves and loads back where limits allow less.
class WithinLimits {
public:
  WithinLimits(const Scene& scene, const Control& control, KeptBody* kept)
      : scene_(scene), control_(control), kept_(kept), limits_(scene) {}

  Answer run();

private:
  enum class Brought { was_within, within, not_within };
  Brought bring_within(const Scene& scene, double narrowed, Answer& answer) const;
  double find_granted(double reached, std::optional<Status>& stopped, Answer& answer) const;
  void minimise(const Scene& scene, Answer& answer) const;
  Answer at_rest() const;
  Control remaining() const;

  const Scene& scene_;
  const Control& control_;
  KeptBody* kept_;
  Clock clock_;
  LinkLimits limits_;
};

/// Remaining time budget of one more solve.
Control WithinLimits::remaining() const {
  Control control = control_;
  if (control.seconds_budget)
    control.seconds_budget = std::max(0.0, *control.seconds_budget - clock_.seconds());
  return control;
}

/// @param scene with the prescribed values of this answer; unchanged if no feasible state is found
WithinLimits::Brought WithinLimits::bring_within(const Scene& scene, double narrowed, Answer& answer) const {
  Displacement feasible = answer.displacement;
  const std::optional<int> sweeps = project_in_turned_frames(scene, limits_, feasible, narrowed);
  if (!sweeps)
    return Brought::not_within;
  if (*sweeps == 0)
    return Brought::was_within;
  answer.residual = std::min(1.0, std::max(answer.residual, change_between(answer.displacement, feasible)));
  answer.displacement = std::move(feasible);
  answer.strain_energy = energy_of(scene, answer.displacement, control_.threads);
  answer.iterations += *sweeps;
  return Brought::within;
}

/// @param answer feasible, and stays feasible; becomes the minimum unless its status differs
void WithinLimits::minimise(const Scene& scene, Answer& answer) const {
  std::shared_ptr<PenalizedOperator> at_rest;
  Answer least = minimised(
      scene, remaining(), nullptr, nullptr,
      [&](const CoupledTask& task) { return at_rest = make_operator_within_limits(task); },
      [&](FiniteMinimum& minimum, const CoupledTask&, Answer& found) {
        return minimum.minimise_within(limits_, *at_rest, answer.displacement, found);
      });
  answer.status = least.status;
  answer.iterations += least.iterations;
  answer.algorithm += ", limits by multipliers";
  if (std::ranges::all_of(narrowed_near, [&](double narrowed) {
        return bring_within(scene, narrowed, least) == Brought::not_within;
      }))
    answer.status = is_converged(answer.status) ? Status::budget_reached : answer.status;
  else if (potential(scene, least) <= potential(scene, answer)) {
    answer.displacement = std::move(least.displacement);
    answer.strain_energy = least.strain_energy;
    answer.reaction = std::move(least.reaction);
  } else if (is_converged(answer.status) &&
             change_between(answer.displacement, least.displacement) > scene.relaxation.tolerance)
    answer.status = Status::budget_reached;
  if (is_converged(answer.status))
    answer.residual = least.residual;
}

Answer WithinLimits::at_rest() const {
  Answer answer;
  answer.method = "coupled";
  answer.algorithm = "nothing moves";
  answer.displacement = Displacement(scene_.specimen.grid);
  answer.strain_energy = 0;
  answer.residual = 1;
  return answer;
}

/// @param answer becomes feasible @return the applied share of moves and loads
double WithinLimits::find_granted(double reached, std::optional<Status>& stopped, Answer& answer) const {
  answer = at_rest();
  double low = 0, high = reached;
  for (int i = 0; i < halvings && !stopped; ++i) {
    const double middle = (low + high) / 2;
    const Scene part = scaled(scene_, middle);
    Answer tried = least_elastic(part, remaining());
    if (!is_converged(tried.status))
      stopped = tried.status;
    else if (bring_within(part, narrowed_far, tried) != Brought::not_within) {
      low = middle;
      answer = std::move(tried);
    } else
      high = middle;
  }
  return low;
}

Answer WithinLimits::run() {
  double share = 1; // an interrupted solve may have applied a part of the moves
  Answer answer = least_elastic(scene_, control_, kept_, &share);
  if (!has_displacement(answer.status))
    return answer;
  std::optional<Status> stopped = is_converged(answer.status) ? std::nullopt : std::optional(answer.status);
  const Brought brought = bring_within(share < 1 ? scaled(scene_, share) : scene_, narrowed_far, answer);
  if (brought == Brought::was_within)
    return answer;
  const bool is_granted = brought == Brought::within;
  if (!is_granted)
    share = find_granted(share, stopped, answer);
  answer.reaction.clear();
  if (!stopped && share > 0)
    minimise(share < 1 ? scaled(scene_, share) : scene_, answer);
  const bool is_least = !stopped && is_converged(answer.status);
  add_sentence(answer.message, is_least
                                   ? "limits are active: least energy within them, each link in the frame "
                                     "of its cells"
                                   : "limits are active: the solve was cut short, and its state brought "
                                     "to a feasible one, each link in the frame of its cells");
  if (!is_granted) {
    answer.status = is_least ? Status::clamped : stopped.value_or(answer.status);
    add_sentence(answer.message,
                 fmt::format("limits grant {:.3g} % of moves and loads, as far as was found: handles "
                             "are there",
                             100 * share));
  }
  answer.seconds.solve = clock_.seconds() - answer.seconds.setup;
  return answer;
}

} // namespace

Answer solve_coupled_finite(const Scene& scene, const Control& control, KeptBody* kept) {
  if (!scene.limits_bind_coupled())
    return least_elastic(scene, control, kept);
  return WithinLimits(scene, control, kept).run();
}

} // namespace maille::deform
