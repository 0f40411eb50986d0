#include "maille/fem_ref/solve.hpp"

#include "maille/scene/memory.hpp"

#include "linear_solvers.hpp"
#include "maille/scene/rigid_motions.hpp"
#include "problem.hpp"
#include "thread_limit.hpp"

#include <cmath>
#include <fmt/format.h>
#include <new>
#include <sstream>

namespace maille::fem_ref {
namespace {

std::string method_name(const Options& options) {
  return options.degree == 2 ? "fem_q2" : "fem_q1";
}

Answer failure(const Options& options, std::string reason) {
  Answer answer = refusal(method_name(options), std::move(reason));
  answer.status = Status::failed;
  return answer;
}

/// Matrix, its copy in Trilinos and the hierarchy: the least that any of the solvers holds at once in 3D.
double bytes_at_least(const Scene& scene, int degree) {
  const int d = scene.dimension();
  const double nodes = static_cast<double>(scene.specimen.n_matter_nodes()) * std::pow(degree, d);
  const double coupled_nodes = std::pow(degree + 2, d); // of a node, on average, in the interior
  const double bytes_per_entry = 35; // of process memory: 50 at 32^3 cells Q1, 35 at 16^3 cells Q2
  return bytes_per_entry * nodes * coupled_nodes * d * d;
}

/// Why the scene cannot be solved; empty where it can.
std::string why_refused(const Scene& scene, const Options& options) {
  if (options.degree != 1 && options.degree != 2)
    return fmt::format("expected elements of degree 1 or 2, found {}", options.degree);
  if (scene.dimension() < 1 || scene.dimension() > 3 || scene.specimen.n_matter_cells() == 0)
    return "the specimen holds no matter";
  const double needed = bytes_at_least(scene, options.degree);
  if (const auto available = static_cast<double>(available_memory()); needed > available)
    return fmt::format("matrix and solver need about {}, {} are available", bytes_in_words(needed),
                       bytes_in_words(available));
  if (!options.boundary_displacement) {
    if (scene.prescribed.empty())
      return "nothing is held or moved, so the body can move anywhere";
    if (std::string motion = remaining_rigid_motion(scene); !motion.empty())
      return motion + ": hold or move more of it";
  }
  return {};
}

template<int dim>
Result run(const Scene& scene, const Options& options, Watch& watch) {
  Result result;
  result.answer.method = method_name(options);
  watch.report(0, "meshing");
  Problem<dim> problem(scene, options);
  watch.report(0.1, "assembling");
  LinearSystem system;
  problem.assemble(system);
  result.degrees_of_freedom = system.n();

  Solution solution = watch.should_stop() ? end_with(watch.status(), "stopped before the solution")
                                          : solve_linear_system(system, options, watch);
  Answer& answer = result.answer;
  answer.status = solution.status;
  answer.message = std::move(solution.message);
  answer.algorithm = std::move(solution.algorithm);
  answer.iterations = solution.iterations;
  answer.residual = solution.residual;
  answer.bytes = problem.bytes() + std::max(solution.bytes, system.bytes());
  if (solution.status == Status::done && !(solution.residual < 1e-6)) {
    answer.status = Status::failed;
    answer.message = fmt::format("the solution leaves a relative residual of {:.2g}", solution.residual);
  }
  if (has_displacement(answer.status)) {
    if (solution.u.size() == 0) // stopped early: only what is prescribed has moved
      solution.u.reinit(system.right_hand_side.size());
    system.constraints.distribute(solution.u);
    answer.displacement = problem.at_grid_nodes(solution.u);
    if (is_settled(answer.status))
      problem.react(solution.u, answer);
  }
  const double total = watch.seconds();
  answer.seconds.setup = solution.seconds_setup > 0 ? solution.seconds_setup : total;
  answer.seconds.solve = total - answer.seconds.setup;
  if (options.exact && has_displacement(answer.status))
    result.l2_error = problem.l2_error(solution.u);
  watch.report(1, "done");
  return result;
}

Result run(const Scene& scene, const Options& options, Watch& watch) {
  switch (scene.dimension()) {
  case 1:
    return run<1>(scene, options, watch);
  case 2:
    return run<2>(scene, options, watch);
  default:
    return run<3>(scene, options, watch);
  }
}

} // namespace

Result solve(const Scene& scene, const Options& options, const Control& control) {
  Watch watch(control);
  Result result;
  try {
    if (std::string reason = why_refused(scene, options); !reason.empty()) {
      result.answer = refusal(method_name(options), std::move(reason));
      return result;
    }
    const ThreadLimit limit(watch.threads());
    return run(scene, options, watch);
  } catch (const std::bad_alloc&) {
    result.answer = failure(options, "out of memory");
  } catch (const dealii::ExceptionBase& error) {
    std::ostringstream text;
    error.print_info(text);
    result.answer = failure(options, fmt::format("deal.II: {}: {}", error.get_exc_name(), text.str()));
  } catch (const std::exception& error) {
    result.answer = failure(options, error.what());
  }
  return result;
}

} // namespace maille::fem_ref
