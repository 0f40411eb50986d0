#include "maille/fem_ref/solve.hpp"

#include "budget.hpp"
#include "distributed.hpp"
#include "geometric_multigrid.hpp"
#include "linear_solvers.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "problem.hpp"
#include "residual_size.hpp"
#include "thread_limit.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <mpi.h>
#include <new>
#include <sstream>
#include <utility>

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

/// Everything that answers depend on but loads and prescribed values.
bool is_same_body(const Scene& a, const Scene& b) {
  const Specimen &s = a.specimen, &t = b.specimen;
  const auto at = [](const Prescribed& p, const Prescribed& q) {
    return p.node == q.node && p.component == q.component;
  };
  if (!(s.grid.cells() == t.grid.cells() && s.grid.spacing() == t.grid.spacing() && s.origin == t.origin &&
        s.material_id == t.material_id && s.fibre == t.fibre && s.fibres == t.fibres && a.plane == b.plane &&
        a.materials.size() == b.materials.size() && std::ranges::equal(a.prescribed, b.prescribed, at)))
    return false;
  for (std::int64_t cell = 0; cell < s.grid.n_cells(); ++cell) // the first cell of every material tells
    if (s.is_matter(cell) && a.cell_stiffness(cell) != b.cell_stiffness(cell))
      return false;
    else if (a.materials.size() == 1 && s.is_matter(cell))
      break;
  return true;
}

} // namespace

class Solver::Kept {
public:
  virtual ~Kept() = default;
  virtual Result solve(const Scene& scene, Watch& watch) = 0;
  bool serves(const Scene& scene) const { return is_same_body(scene_, scene); }

protected:
  explicit Kept(const Scene& scene) : scene_(scene) {}
  const Scene scene_; ///< the first that was asked
};

namespace {

template<int dim>
class KeptProblem : public Solver::Kept {
public:
  KeptProblem(const Scene& scene, const Options& options, Watch& watch)
      : Kept(scene), options_(options), problem_(scene_, options_, !wants_multigrid(scene, options)) {
    watch.report(0.1, "assembling");
    prepare_solver(watch);
  }
  Result solve(const Scene& scene, Watch& watch) override;
  bool is_ready() const { return preparation_.solver != nullptr; }

private:
  void prepare_solver(Watch& watch);
  void fill(const Prescription& prescription, Solution& solution, Result& result) const;

  Options options_;
  Problem<dim> problem_;
  Preparation preparation_;
  std::int64_t n_free_ = 0;
};

template<int dim>
void KeptProblem<dim>::prepare_solver(Watch& watch) {
  const Prescription prescription = problem_.prescription();
  n_free_ = std::ranges::count(prescription.is_prescribed, false);
  if (watch.should_stop()) {
    preparation_ = give_up(watch.status(), "stopped before the solution");
  } else if constexpr (dim > 1) {
    if (wants_multigrid(scene_, options_)) {
      preparation_ = prepare_multigrid(scene_, problem_.body(), prescription.is_prescribed, options_, watch);
      preparation_.algorithm = solver_in_words(options_.degree, n_free_,
                                               options_.solver == LinearSolver::gmg_matrix
                                                   ? "CG with geometric multigrid, level matrices"
                                                   : "CG with geometric multigrid, matrix-free");
    }
  }
  if (!preparation_.solver && preparation_.status == Status::done) {
    LinearSystem system;
    problem_.assemble(system, prescription.is_prescribed);
    preparation_ = watch.should_stop() ? give_up(watch.status(), "stopped before the solution")
                                       : prepare(system, options_, watch);
    preparation_.bytes = std::max(preparation_.bytes, system.bytes());
  }
  preparation_.bytes += problem_.body().bytes();
}

template<int dim>
Result KeptProblem<dim>::solve(const Scene& scene, Watch& watch) {
  problem_.ask(scene);
  const Prescription prescription = problem_.prescription();
  Result result;
  Answer& answer = result.answer;
  answer.method = method_name(options_);
  answer.algorithm = preparation_.algorithm;
  answer.bytes = preparation_.bytes;
  result.degrees_of_freedom = static_cast<std::int64_t>(prescription.values.size());
  Solution solution = end_with(preparation_.status, preparation_.message);
  if (preparation_.solver) {
    dealii::Vector<double> f(prescription.values.size());
    problem_.residual_forces(prescription.values, f);
    const double all = f.l2_norm();
    for (unsigned i = 0; i < f.size(); ++i)
      f[i] = prescription.is_prescribed[i] ? 0 : -f[i];
    answer.seconds.setup = watch.seconds();
    solution = preparation_.solver->solve(f, watch);
    answer.residual = residual_size(f.l2_norm(), all); // until `fill` divides by it
  }
  fill(prescription, solution, result);
  const double total = watch.seconds();
  if (!preparation_.solver)
    answer.seconds.setup = total;
  answer.seconds.solve = total - answer.seconds.setup;
  if (options_.exact && has_displacement(answer.status))
    result.l2_error = problem_.l2_error(solution.u);
  watch.report(1, "done");
  problem_.ask(scene_);
  return result;
}

/// Displacement, forces, and by them what the solution leaves: K u - f where nothing is prescribed.
template<int dim>
void KeptProblem<dim>::fill(const Prescription& prescription, Solution& solution, Result& result) const {
  Answer& answer = result.answer;
  answer.status = solution.status;
  answer.message = std::move(solution.message);
  answer.iterations = solution.iterations;
  const double size = std::exchange(answer.residual, 0);
  if (!has_displacement(answer.status))
    return;
  if (solution.u.size() == 0) // stopped early: only what is prescribed has moved
    solution.u.reinit(prescription.values.size());
  solution.u += prescription.values;
  dealii::Vector<double> forces(solution.u.size());
  const double energy = problem_.residual_forces(solution.u, forces);
  double squared = 0;
  for (unsigned i = 0; i < forces.size(); ++i)
    squared += prescription.is_prescribed[i] ? 0 : forces[i] * forces[i];
  answer.residual = size > 0 ? std::sqrt(squared) / size : 0;
  const double most = std::max(1e-6, 2 * options_.tolerance); // who asked for less gets less
  if (answer.status == Status::done && !(answer.residual < most)) {
    answer.status = Status::failed;
    answer.message = fmt::format("the solution leaves a relative residual of {:.2g}", answer.residual);
    return;
  }
  answer.displacement = problem_.at_grid_nodes(solution.u);
  if (!is_settled(answer.status))
    return;
  answer.strain_energy = energy;
  if (options_.recover_stress)
    problem_.recover(solution.u, answer);
  if (!options_.boundary_displacement) // else what is prescribed is not the scene's
    answer.reaction = problem_.reactions(forces);
}

std::unique_ptr<Solver::Kept> keep(const Scene& scene, const Options& options, Watch& watch) {
  watch.report(0, "meshing");
  switch (scene.dimension()) {
  case 1:
    return std::make_unique<KeptProblem<1>>(scene, options, watch);
  case 2:
    return std::make_unique<KeptProblem<2>>(scene, options, watch);
  default:
    return std::make_unique<KeptProblem<3>>(scene, options, watch);
  }
}

} // namespace

namespace {

/// Manufactured solutions and lines are small: every rank solves them whole.
bool is_for_all_ranks(const Scene& scene, const Options& options) {
  return ranks().size > 1 && scene.dimension() > 1 && !options.body_force && !options.boundary_displacement &&
         !options.exact && !options.shape;
}

Result solve_together(const Scene& scene, const Options& options, Watch& watch) {
  Result result;
  std::string reason = why_refused(scene, options);
  if (reason.empty() && options.solver != LinearSolver::automatic && options.solver != LinearSolver::cg_amg)
    reason = "several ranks solve by CG with AMG only";
  // Memory may stand in the way of one rank alone.
  int refused = reason.empty() ? 0 : 1, anyone = 0;
  MPI_Allreduce(&refused, &anyone, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (anyone == 0)
    return solve_distributed(scene, options, watch);
  result.answer = refusal(method_name(options),
                          reason.empty() ? "another rank has too little memory" : std::move(reason));
  return result;
}

} // namespace

Solver::Solver(Options options) : options_(std::move(options)) {}
Solver::~Solver() = default;

Result Solver::solve(const Scene& scene, const Control& control) {
  Watch watch(control);
  Result result;
  try {
    const ThreadLimit limit(watch.threads());
    if (is_for_all_ranks(scene, options_))
      return solve_together(scene, options_, watch);
    if (!kept_ || !kept_->serves(scene)) {
      kept_.reset(); // before the next, which needs the memory
      if (std::string reason = why_refused(scene, options_); !reason.empty()) {
        result.answer = refusal(method_name(options_), std::move(reason));
        return result;
      }
      kept_ = keep(scene, options_, watch);
    }
    result = kept_->solve(scene, watch);
    if (watch.status() != Status::done || !is_settled(result.answer.status))
      kept_.reset(); // what was cut short serves nobody
    return result;
  } catch (const std::bad_alloc&) {
    result.answer = failure(options_, "out of memory");
  } catch (const dealii::ExceptionBase& error) {
    std::ostringstream text;
    error.print_info(text);
    result.answer = failure(options_, fmt::format("deal.II: {}: {}", error.get_exc_name(), text.str()));
  } catch (const std::exception& error) {
    result.answer = failure(options_, error.what());
  }
  kept_.reset();
  return result;
}

Result solve(const Scene& scene, const Options& options, const Control& control) {
  return Solver(options).solve(scene, control);
}

} // namespace maille::fem_ref
