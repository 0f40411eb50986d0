#include "bench/bodies/body_case.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/link_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

namespace maille::lab {

namespace {

using fem_ref::LinearSolver;

constexpr double tight = 1e-7, tight_if_quick = 1e-6;
/// A factor that takes longer or more than that is not looked at.
constexpr double most_seconds_of_factor = 120, most_bytes_of_factor = 6e9;

Scene to(Scene scene, double tolerance) {
  scene.relaxation.tolerance = tolerance;
  return scene;
}

Measured measured_of(const Answer& answer, int runs) {
  return {answer.seconds, answer.iterations, answer.bytes, runs, {}, {}};
}

} // namespace

double BodyCase::own_bytes_per_unknown(const Measured& measured) const {
  const double beside = is_box() ? 24 * static_cast<double>(body_.scene.specimen.grid.n_nodes()) : 0;
  return (static_cast<double>(measured.bytes) - beside) / static_cast<double>(unknowns());
}

void BodyCase::add_row(const std::string& method, double tolerance, const Measured& measured, int threads,
                       const std::string& note) {
  nlohmann::ordered_json row{
      {"body", body_.name},
      {"unknowns", unknowns()},
      {"method", method},
      {"tolerance", tolerance},
      {"threads", threads},
      {"setup_s", measured.seconds.setup},
      {"solve_s", measured.seconds.solve},
      {"ns_per_unknown", 1e9 * measured.seconds.total() / static_cast<double>(unknowns())},
      {"iterations", measured.iterations},
      {"bytes_per_unknown", own_bytes_per_unknown(measured)},
      {"runs", measured.runs},
      {"algebra_error", nullptr},
      {"note", note}};
  if (measured.algebra_error)
    row["algebra_error"] = *measured.algebra_error;
  report_.add(std::move(row));
}

Measured BodyCase::coupled(double tolerance, int threads) {
  Control control = report_.one_thread();
  if (!converged_)
    converged_ =
        deform::solve(to(body_.scene, is_quick_ ? tight_if_quick : tight), "coupled", control).displacement;
  control.threads = threads;
  const Scene scene = to(body_.scene, tolerance);
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "coupled", control); });
  Measured measured = measured_of(answer, runs);
  measured.algebra_error = compare(scene, answer.displacement, *converged_).relative_l2;
  add_row("coupled", tolerance, measured, threads,
          *measured.algebra_error > tolerance ? "MISSES its tolerance" : "");
  return measured;
}

std::optional<Measured> BodyCase::fem(LinearSolver solver, double goal, const Displacement& converged) {
  const bool is_direct = solver == LinearSolver::cholmod;
  for (const double tolerance : std::array{1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const Answer answer = fem_answer(body_.scene, solver, 1, tolerance, report_.one_thread());
    Measured measured = measured_of(answer, 1);
    measured.algebra_error = compare(body_.scene, answer.displacement, converged).relative_l2;
    if (!is_direct && *measured.algebra_error > goal)
      continue;
    add_row("fem_q1 " + std::string(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]),
            tolerance, measured, 1);
    return measured;
  }
  return std::nullopt;
}

std::optional<Measured> BodyCase::quickest_fem(double goal) {
  fem_ref::Options factor;
  factor.solver = LinearSolver::cholmod;
  const fem_ref::Estimate of_factor = fem_ref::estimate(body_.scene, factor);
  const bool has_factor =
      of_factor.seconds < most_seconds_of_factor && of_factor.bytes < most_bytes_of_factor;
  const LinearSolver reference = has_factor ? LinearSolver::cholmod : LinearSolver::cg_amg;
  const Displacement converged =
      fem_answer(body_.scene, reference, 1, is_quick_ ? 1e-6 : 1e-8, report_.one_thread()).displacement;
  std::optional<Measured> quickest = fem(LinearSolver::cg_amg, goal, converged);
  if (has_factor) {
    const std::optional<Measured> direct = fem(LinearSolver::cholmod, goal, converged);
    if (!quickest || direct->seconds.total() < quickest->seconds.total())
      quickest = direct;
  }
  return quickest;
}

BodyCase::Limited BodyCase::within_limits(double tolerance) {
  const Scene scene = to(lab::within_limits(body_.scene), tolerance);
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "coupled", report_.one_thread()); });
  const LinkLimits limits(scene);
  Limited limited{measured_of(answer, runs), false};
  const Scene elastic = to(body_.scene, tolerance);
  const Answer free = deform::solve(elastic, "coupled", report_.one_thread());
  const double broken = largest_violation(scene, limits, free.displacement);
  limited.bind = broken > 1e-6;
  add_row("coupled, own limits", tolerance, limited.measured, 1,
          fmt::format("elastic breaks them by {:.2g}, this by {:.2g} of a link{}", broken,
                      largest_violation(scene, limits, answer.displacement),
                      answer.status == Status::budget_reached ? "; ENDED unconverged" : ""));
  return limited;
}

double BodyCase::next_frame_over_first(double tolerance) {
  const Scene first = to(scaled(body_.scene, 0.9), tolerance), next = to(body_.scene, tolerance);
  std::vector<double> of_first, of_next;
  for (int run = 0; run < (is_quick_ ? 1 : 5); ++run) {
    deform::ElasticBody kept;
    of_first.push_back(kept.answer(first, report_.one_thread()).seconds.total());
    of_next.push_back(kept.answer(next, report_.one_thread()).seconds.total());
  }
  const auto median = [](std::vector<double>& seconds) {
    std::ranges::nth_element(seconds, seconds.begin() + std::ssize(seconds) / 2);
    return seconds[seconds.size() / 2];
  };
  report_.add({{"frames of", body_.name}, {"first_s", median(of_first)}, {"next_s", median(of_next)}});
  return median(of_next) / median(of_first);
}

} // namespace maille::lab
