#include "bench/relax/relax_case.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace maille::lab {

namespace {

using fem_ref::LinearSolver;

constexpr double slow = 5; // seconds, from which on once has to do

bool is_direct(LinearSolver solver) {
  return solver == LinearSolver::cholmod;
}

nlohmann::ordered_json or_nothing(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nullptr;
}

/// What others have freed would spare the next method the page faults that it has in a process of its own,
/// but only where its arrays are small enough to come from there.
void give_back_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void expect_displacement(const Answer& answer) {
  if (answer.status == Status::interrupted)
    throw BenchStopped();
  if (!has_displacement(answer.status))
    throw std::runtime_error(
        fmt::format("{} gave no answer to the benchmark's box: {}", answer.method, answer.message));
}

} // namespace

std::pair<Answer, int> median_answer(bool is_quick, const std::function<Answer()>& run_warm) {
  const auto run = [&] {
    give_back_memory();
    return run_warm();
  };
  std::vector<Answer> answers{run()};
  expect_displacement(answers[0]);
  const double first = answers[0].seconds.total();
  const int more = is_quick ? 0 : first < 1 ? 5 : first < slow ? 2 : 0;
  if (more == 5)
    answers.clear(); // it warmed up
  for (int i = 0; i < more; ++i)
    answers.push_back(run());
  const auto middle = answers.begin() + static_cast<std::ptrdiff_t>(answers.size() / 2);
  std::ranges::nth_element(answers, middle, {}, [](const Answer& a) { return a.seconds.total(); });
  return {std::move(*middle), static_cast<int>(answers.size())};
}

Answer fem_answer(const Scene& scene, LinearSolver solver, int degree, double tolerance,
                  const Control& control) {
  fem_ref::Options options;
  options.degree = degree;
  options.solver = solver;
  options.tolerance = tolerance;
  Answer answer = fem_ref::solve(scene, options, control).answer;
  expect_displacement(answer);
  return answer;
}

RelaxCase::RelaxCase(const BoxQuestion& question, int cells, Displacement reference,
                     std::string reference_words, bool is_quick, BenchReport& report)
    : question_(question), scene_(box_scene(question, cells)), reference_(std::move(reference)),
      reference_words_(std::move(reference_words)), is_quick_(is_quick), report_(report) {}

Measured RelaxCase::measure(const Answer& answer, int runs,
                            const std::optional<Displacement>& converged) const {
  Measured measured{answer.seconds, answer.iterations, answer.bytes, runs, {}, {}};
  if (converged)
    measured.algebra_error = compare(scene_, answer.displacement, *converged).relative_l2;
  if (!reference_.empty())
    measured.error = compare(scene_, answer.displacement, reference_).relative_l2;
  return measured;
}

void RelaxCase::add_row(const std::string& method, std::optional<double> tolerance, const Measured& measured,
                        const std::string& note) {
  report_.add({{"box", question_.load_name()},
               {"material", question_.material},
               {"nodes", nodes_in_words(scene_)},
               {"method", method},
               {"tolerance", or_nothing(tolerance)},
               {"setup_s", measured.seconds.setup},
               {"solve_s", measured.seconds.solve},
               {"total_s", measured.seconds.total()},
               {"runs", measured.runs},
               {"iterations", measured.iterations},
               {"mib", static_cast<double>(measured.bytes) / (1 << 20)},
               {"algebra_error", or_nothing(measured.algebra_error)},
               {"error", or_nothing(measured.error)},
               {"reference", measured.error ? reference_words_ : "-"},
               {"note", note}});
}

const Displacement& RelaxCase::converged_coupled() {
  if (!converged_coupled_) {
    Scene scene = scene_;
    scene.relaxation.tolerance = 1e-8;
    Answer answer = deform::solve(scene, "coupled", report_.one_thread());
    expect_displacement(answer);
    converged_coupled_ = std::move(answer.displacement);
  }
  return *converged_coupled_;
}

/// By the quickest of the solvers: which it is does not matter to the answer.
const Displacement& RelaxCase::converged_q1() {
  if (!converged_q1_)
    converged_q1_ = fem_answer(scene_, LinearSolver::gmg, 1, 1e-8, report_.one_thread()).displacement;
  return *converged_q1_;
}

Measured RelaxCase::coupled(double tolerance, int threads) {
  Scene scene = scene_;
  scene.relaxation.tolerance = tolerance;
  Control control = report_.one_thread();
  control.threads = threads;
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "coupled", control); });
  const Measured measured = measure(answer, runs, converged_coupled());
  add_row("coupled", tolerance, measured, threads > 1 ? fmt::format("{} threads", threads) : "");
  return measured;
}

Measured RelaxCase::extrapolated() {
  Scene scene = scene_;
  scene.relaxation.tolerance = 1e-3;
  scene.relaxation.extrapolation = Extrapolation::nested;
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "coupled", report_.one_thread()); });
  const Measured measured = measure(answer, runs, std::nullopt);
  add_row("coupled extrapolated", scene.relaxation.tolerance, measured,
          answer.message.empty()
              ? fmt::format("extrapolated at {:.0f} % of the nodes", 100 * answer.extrapolated.value_or(0))
              : answer.message);
  return measured;
}

Measured RelaxCase::relaxed() {
  Scene scene = scene_;
  scene.relaxation.tolerance = 1e-3;
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "relaxed", report_.one_thread()); });
  const Measured measured = measure(answer, runs, std::nullopt);
  add_row("relaxed", scene.relaxation.tolerance, measured, "no Poisson effect");
  return measured;
}

std::int64_t RelaxCase::sweep() {
  Scene scene = with_wide_limits(scene_);
  scene.relaxation.tolerance = 1e-3;
  const auto [answer, runs] =
      median_answer(is_quick_, [&] { return deform::solve(scene, "sweep", report_.one_thread()); });
  add_row("sweep", scene.relaxation.tolerance, measure(answer, runs, std::nullopt), "equal weights");
  return answer.iterations;
}

void RelaxCase::extrapolated_sweep(std::int64_t sweeps_of_small, int cells_of_small) {
  Scene scene = with_wide_limits(scene_);
  scene.relaxation.tolerance = 1e-3;
  scene.relaxation.sweeps = 20;
  const Answer begun = deform::solve(scene, "sweep", report_.one_thread());
  expect_displacement(begun);
  const double ratio = static_cast<double>(scene.specimen.grid.cells()[0]) / cells_of_small,
               sweeps = ratio * ratio * static_cast<double>(sweeps_of_small);
  Measured measured{begun.seconds, std::llround(sweeps), begun.bytes, 1, {}, {}};
  measured.seconds.solve *= sweeps / static_cast<double>(std::max<std::int64_t>(1, begun.iterations));
  add_row("sweep", scene.relaxation.tolerance, measured,
          fmt::format("EXTRAPOLATED from {} sweeps", begun.iterations));
}

std::optional<Answer> RelaxCase::loosest_within(double goal, LinearSolver solver) {
  std::optional<Answer> loosest;
  double tolerance = last_tolerance_;
  for (int attempt = 0; attempt < 5; ++attempt) {
    Answer answer = fem_answer(scene_, solver, 1, tolerance, report_.one_thread());
    const double error = compare(scene_, answer.displacement, converged_q1()).relative_l2;
    // One iteration is worth a factor of 2 to 10; a slow solver is not asked again for less than that.
    const double near = answer.seconds.total() > slow ? goal / 10 : goal / 4;
    const bool is_near = error > near || attempt > 1;
    if (error <= goal && (!loosest || tolerance > last_tolerance_)) {
      last_tolerance_ = tolerance;
      loosest = std::move(answer);
    }
    if (error <= goal && is_near)
      break;
    tolerance = std::min(0.5, tolerance * std::clamp(0.7 * goal / error, 1.0 / 30, 30.0));
  }
  return loosest;
}

Measured RelaxCase::fem_q1(LinearSolver solver, double goal) {
  const std::string name =
      "fem_q1 " + std::string(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]);
  std::optional<Answer> answer;
  if (!is_direct(solver))
    answer = loosest_within(goal, solver);
  int runs = 1;
  if (!answer || answer->seconds.total() < slow)
    std::tie(answer, runs) = median_answer(
        is_quick_, [&] { return fem_answer(scene_, solver, 1, last_tolerance_, report_.one_thread()); });
  const Measured measured = measure(*answer, runs, converged_q1());
  add_row(name, is_direct(solver) ? std::nullopt : std::optional(last_tolerance_), measured,
          *measured.algebra_error > goal ? "MISSES the accuracy of its algebra" : "");
  return measured;
}

} // namespace maille::lab
