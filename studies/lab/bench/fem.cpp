#include "bench/fem.hpp"

#include "maille/fem_ref/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille::lab {

namespace {

/// A cube held below and poked on a quarter of its side; `cells` divisible by 8.
Scene poked_cube(int cells) {
  return parse_scene(
      fmt::format(
          "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [{0}, {0}, {0}]\nspacing = \"1 mm\"\n"
          "material = {{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }}\n[[hold]]\nwhere = \"z-\"\n"
          "[[move]]\nwhere = {{ box = [[{1}, {1}, {2}], [{3}, {3}, {2}]] }}\nby = [0, 0, \"-1 mm\"]\n",
          cells, 3e-3 * cells / 8, 1e-3 * cells, 5e-3 * cells / 8),
      "cube.toml");
}

/// What one process found, as plain data that fits into a pipe.
struct Figures {
  double setup = 0, solve = 0, next_step = 0, residual = 0;
  long long iterations = 0, unknowns = 0, peak_kib = 0;
  std::array<char, 120> algorithm{};
};

Figures solve_here(const Scene& scene, int degree, fem_ref::LinearSolver linear_solver) {
  fem_ref::Options options;
  options.degree = degree;
  options.solver = linear_solver;
  fem_ref::Solver solver(options);
  const fem_ref::Result first = solver.solve(scene);
  Figures figures;
  figures.setup = first.answer.seconds.setup;
  figures.solve = first.answer.seconds.solve;
  figures.iterations = first.answer.iterations;
  figures.unknowns = first.degrees_of_freedom;
  figures.residual =
      is_converged(first.answer.status) ? first.answer.residual : std::numeric_limits<double>::quiet_NaN();
  figures.next_step = solver.solve(scaled(scene, 0.5)).answer.seconds.total();
  const std::string words = is_converged(first.answer.status) ? first.answer.algorithm : first.answer.message;
  std::copy_n(words.begin(), std::min(words.size(), figures.algorithm.size() - 1), figures.algorithm.begin());
  return figures;
}

/// The same in a process of its own. Nothing where it died, of too little memory for instance.
std::optional<Figures> solve_apart(const Scene& scene, int degree, fem_ref::LinearSolver linear_solver,
                                   const Control& control) {
  int ends[2];
  if (pipe(ends) != 0)
    return std::nullopt;
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0)
    return std::nullopt;
  if (child == 0) {
    close(ends[0]);
    const Figures figures = solve_here(scene, degree, linear_solver);
    const bool is_written = write(ends[1], &figures, sizeof figures) == static_cast<ssize_t>(sizeof figures);
    _exit(is_written ? 0 : 1); // without the parent's clean-up
  }
  close(ends[1]);
  pollfd heard{ends[0], POLLIN, 0};
  while (poll(&heard, 1, 200) == 0 && !control.should_stop()) {
  }
  if (control.should_stop())
    kill(child, SIGKILL);
  Figures figures;
  const bool is_read = read(ends[0], &figures, sizeof figures) == static_cast<ssize_t>(sizeof figures);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  figures.peak_kib = usage.ru_maxrss;
  return is_read && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? std::optional(figures) : std::nullopt;
}

nlohmann::ordered_json row(int cells, int degree, const char* solver, const Figures& figures) {
  return {{"nodes", fmt::format("{}^3", cells + 1)},
          {"element", fmt::format("Q{}", degree)},
          {"solver", solver},
          {"unknowns", figures.unknowns},
          {"setup_s", figures.setup},
          {"solve_s", figures.solve},
          {"total_s", figures.setup + figures.solve},
          {"next_step_s", figures.next_step},
          {"iterations", figures.iterations},
          {"residual", figures.residual},
          {"peak_mib", static_cast<double>(figures.peak_kib) / 1024}};
}

/// A factor of more would take minutes, or more memory than most machines have.
constexpr int largest_for_cholmod = 32;

} // namespace

void bench_fem(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  using enum fem_ref::LinearSolver;
  double amg_total = 0, default_total = 0, default_peak = 0;
  const std::vector<int> sizes = options.quick ? std::vector<int>{8, 16} : std::vector<int>{16, 32, 64};
  for (const int cells : sizes)
    for (const fem_ref::LinearSolver solver : {automatic, cholmod, cg_amg, gmg}) {
      if (solver == cholmod && cells > largest_for_cholmod)
        continue;
      const auto figures = solve_apart(poked_cube(cells), 1, solver, report.control);
      if (report.control.should_stop())
        throw BenchStopped();
      if (!figures)
        continue;
      report.add(
          row(cells, 1, fem_ref::linear_solver_names[static_cast<std::size_t>(solver)].data(), *figures));
      const double total = figures->setup + figures->solve;
      if (solver == cg_amg && cells == sizes.back())
        amg_total = total;
      if (solver == automatic && cells == sizes.back()) {
        default_total = total;
        default_peak = static_cast<double>(figures->peak_kib) / 1024;
      }
    }
  if (const auto figures = solve_apart(poked_cube(sizes.back() / 2), 2, automatic, report.control))
    report.add(row(sizes.back() / 2, 2, "automatic", *figures));
  report.checks.push_back({"amg_total_over_default_65", amg_total / default_total});
  report.checks.push_back({"peak_mib_65", default_peak});
}

} // namespace maille::lab
