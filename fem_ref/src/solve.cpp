#include "maille/fem_ref/solve.hpp"

#include "distributed_mesh.hpp"
#include "kept_problem.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/mechanics/friction.hpp"
#include "maille/scene/sliding.hpp"
#include "process/abandonable.hpp"
#include "process/thread_limit.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <new>
#include <sstream>
#include <utility>

namespace maille::fem_ref {
namespace {

Answer failure(const Options& options, std::string reason) {
  Answer answer = refusal(method_name(options), std::move(reason));
  answer.status = Status::failed;
  return answer;
}

/// True for distributed solves; manufactured solutions and lines are small, so every rank solves them alone.
bool is_for_all_ranks(const Scene& scene, const Options& options) {
  return ranks().size > 1 && scene.dimension() > 1 && !options.body_force && !options.boundary_displacement &&
         !options.exact && !options.shape;
}

Result solve_together(const Scene& scene, const Options& options, Watch& watch) {
  Result result;
  std::string reason = why_refused(scene, options);
  if (reason.empty() && options.solver != LinearSolver::automatic && options.solver != LinearSolver::cg_amg)
    reason = "several ranks solve by CG with AMG only";
  if (reason.empty() && (!scene.springs.empty() || !scene.tied.ties.empty()))
    reason = "several ranks know no springs to the ground and no sliding borders: solve on one";
  // Memory may be insufficient on one rank only.
  int refused = reason.empty() ? 0 : 1, anyone = 0;
  MPI_Allreduce(&refused, &anyone, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (anyone == 0)
    return solve_distributed(scene, options, watch);
  result.answer = refusal(method_name(options),
                          reason.empty() ? "another rank has too little memory" : std::move(reason));
  return result;
}

/// Converts exceptions of libraries to failed answers.
template<class Work>
Result guarded(const Options& options, const Work& work) {
  Result result;
  try {
    return work();
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

/// Reuses the cached factors if they fit this scene; interrupted solves are not cached.
Result solve_kept(std::unique_ptr<Solver::Kept>& kept, const Scene& scene, const Options& options,
                  const Control& control) {
  Watch watch(control);
  Result result = guarded(options, [&] {
    const ThreadLimit limit(watch.threads());
    if (!kept || !kept->serves(scene)) {
      kept.reset(); // frees memory for the next one
      Result refused;
      if (std::string reason = why_refused(scene, options); !reason.empty()) {
        refused.answer = refusal(method_name(options), std::move(reason));
        return refused;
      }
      if (!has_blas_memory()) {
        refused.answer = failure(options, "out of memory for the products of dense blocks");
        return refused;
      }
      kept = keep(scene, options, watch);
    }
    return kept->solve(scene, watch);
  });
  if (watch.status() != Status::done || !is_converged(result.answer.status))
    kept.reset();
  return result;
}

/// A solve with all its data, for a thread that may outlive its caller.
struct Job {
  Scene scene;
  Options options;
  std::unique_ptr<Solver::Kept> kept;
  Result result;
};

/// Displacement with prescribed values only.
Displacement prescribed_alone(const Scene& scene) {
  Displacement u(scene.specimen.grid);
  for (const Prescribed& at : scene.prescribed)
    u(at.component, at.node) = at.value;
  return u;
}

bool has_functions(const Options& options) {
  return options.body_force || options.shape || options.boundary_displacement || options.exact;
}

} // namespace

Solver::Solver(Options options) : options_(std::move(options)) {}
Solver::~Solver() = default;

Result Solver::solve(const Scene& scene, const Control& control) {
  if (!scene.sliding.empty()) {
    SplitScene split = split_borders(scene);
    Result result = solve_rubbing(split.scene, control);
    result.answer = joined(scene, split, std::move(result.answer));
    return result;
  }
  if (is_for_all_ranks(scene, options_)) {
    Watch watch(control);
    return guarded(options_, [&] {
      const ThreadLimit limit(watch.threads());
      return solve_together(scene, options_, watch);
    });
  }
  // Functions of the caller may use objects that end with the caller.
  if (!control.stop_requested || has_functions(options_))
    return solve_kept(kept_, scene, options_, control);
  const auto job = std::make_shared<Job>(Job{scene, options_, std::move(kept_), {}});
  if (run_abandonable(control, [job](const Control& own) {
        job->result = solve_kept(job->kept, job->scene, job->options, own);
      })) {
    kept_ = std::move(job->kept);
    return std::move(job->result);
  }
  Result result;
  result.answer = failure(options_, "stopped in the midst of a step that cannot be stopped: it was left");
  result.answer.status = Status::interrupted;
  result.answer.displacement = prescribed_alone(scene);
  return result;
}

/// Friction iterations with a cached matrix.
Result Solver::solve_rubbing(Scene& split, const Control& control) {
  Friction friction(split);
  Result result = solve(split, control);
  Answer& answer = result.answer;
  while (is_converged(answer.status) && friction.needs_another_round(answer.displacement, answer.tie_press)) {
    for (std::size_t t = 0; t < split.tied.ties.size(); ++t)
      split.tied.ties[t].pull = friction.pulls()[t];
    const Seconds before = answer.seconds;
    const std::int64_t iterations = answer.iterations;
    result = solve(split, control);
    answer.seconds.setup += before.setup;
    answer.seconds.solve += before.solve;
    answer.iterations += iterations;
  }
  if (!is_converged(answer.status))
    return result;
  answer.rubbing = friction.borders();
  if (!friction.message().empty())
    answer.message += (answer.message.empty() ? "" : "; ") + friction.message();
  if (friction.status() != Status::done)
    answer = failure(options_, friction.message());
  return result;
}

Result solve(const Scene& scene, const Options& options, const Control& control) {
  return Solver(options).solve(scene, control);
}

} // namespace maille::fem_ref
