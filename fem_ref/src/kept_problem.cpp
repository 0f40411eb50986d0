#include "kept_problem.hpp"

#include "finite/finite_problem.hpp"
#include "maille/mechanics/friction.hpp"
#include "problem.hpp"
#include "solvers/linear_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::fem_ref {

std::string method_name(const Options& options) {
  return options.degree == 2 ? "fem_q2" : "fem_q1";
}

bool Solver::Kept::serves(const Scene& scene) const {
  const Scene& kept = scene_;
  const Specimen &s = kept.specimen, &t = scene.specimen;
  const auto at = [](const Prescribed& p, const Prescribed& q) {
    return p.node == q.node && p.component == q.component;
  };
  const auto is_same_tie = [](const NodeTie& p, const NodeTie& q) {
    return p.one == q.one && p.other == q.other && p.normal == q.normal && p.friction == q.friction &&
           p.spring == q.spring;
  };
  const auto is_same_spring = [](const FaceSpring& p, const FaceSpring& q) {
    return p.cell == q.cell && p.axis == q.axis && p.upper == q.upper && p.stiffness == q.stiffness &&
           p.direction == q.direction;
  };
  if (scene.strain == Strain::finite) // each increment has its own tangent
    return false;
  if (!(kept.strain == scene.strain && s.grid.cells() == t.grid.cells() &&
        s.grid.spacing() == t.grid.spacing() && s.origin == t.origin && s.material_id == t.material_id &&
        s.fibre == t.fibre && s.fibres == t.fibres && s.tissue == t.tissue &&
        s.stiffness_ratio == t.stiffness_ratio &&
        std::ranges::equal(kept.springs, scene.springs, is_same_spring) && kept.sliding == scene.sliding &&
        s.label == t.label && std::ranges::equal(kept.tied.ties, scene.tied.ties, is_same_tie) &&
        kept.plane == scene.plane && kept.materials.size() == scene.materials.size() &&
        std::ranges::equal(kept.prescribed, scene.prescribed, at)))
    return false;
  for (std::int64_t cell = 0; cell < s.grid.n_cells(); ++cell) // checks the first cell of every material
    if (s.is_matter(cell) && kept.cell_stiffness(cell) != scene.cell_stiffness(cell))
      return false;
    else if (kept.materials.size() == 1 && s.is_matter(cell))
      break;
  return true;
}

namespace {

/// A solution with its forces, energy and residual.
struct State {
  dealii::Vector<double> u;      ///< including prescribed values
  dealii::Vector<double> forces; ///< K u - f
  double energy = 0;             ///< u K u / 2
  std::vector<double> cell_energy;
  double residual = 0;         ///< |K u - f| at free unknowns, relative to the loads there
  std::optional<double> error; ///< relative size of the last correction, if any
};

template<int dim>
class KeptProblem : public Solver::Kept {
public:
  KeptProblem(const Scene& scene, const Options& options, Watch& watch)
      : Kept(scene), options_(options), problem_(scene_, options_, !wants_multigrid(scene, options)) {
    watch.report(0.1, "assembling");
    prepare_solver(watch);
  }
  Result solve(const Scene& scene, Watch& watch) override;

private:
  void prepare_solver(Watch& watch);
  void evaluate(const Prescription& prescription, double size, State& state) const;
  void correct(const Prescription& prescription, double size, Watch& watch, Solution& solution, State& state);
  void fill(const Prescription& prescription, double size, Watch& watch, Solution& solution, Result& result);
  /// Upper bound of the residual; larger if a looser tolerance was requested.
  double most_residual() const { return std::max(1e-6, 2 * options_.tolerance); }

  Options options_;
  Problem<dim> problem_;
  Ties ties_;
  Preparation preparation_;
  std::int64_t n_free_ = 0;
};

template<int dim>
void KeptProblem<dim>::prepare_solver(Watch& watch) {
  const Prescription prescription = problem_.prescription();
  n_free_ = std::ranges::count(prescription.is_prescribed, false);
  ties_ = Ties(scene_, problem_.body(), prescription.is_prescribed);
  if (watch.should_stop()) {
    preparation_ = give_up(watch.status(), "stopped before the solution");
  } else if constexpr (dim > 1) {
    if (wants_multigrid(scene_, options_)) {
      preparation_ = prepare_multigrid(scene_, problem_.body(), prescription.is_prescribed, options_, watch);
      preparation_.algorithm =
          solver_in_words(options_.degree, n_free_, "CG with geometric multigrid, matrix-free");
    }
  }
  if (!preparation_.solver && preparation_.status == Status::done) {
    LinearSystem system;
    problem_.assemble(system, prescription.is_prescribed, ties_);
    preparation_ = watch.should_stop() ? give_up(watch.status(), "stopped before the solution")
                                       : prepare(system, options_, watch);
    preparation_.bytes = std::max(preparation_.bytes, system.bytes());
  }
  preparation_.bytes += problem_.body().bytes();
}

template<int dim>
Result KeptProblem<dim>::solve(const Scene& scene, Watch& watch) {
  problem_.ask(scene);
  Prescription prescription = problem_.prescription();
  ties_.distribute(prescription.values);
  Result result;
  Answer& answer = result.answer;
  answer.method = method_name(options_);
  answer.algorithm = preparation_.algorithm;
  answer.bytes = preparation_.bytes;
  result.degrees_of_freedom = static_cast<std::int64_t>(prescription.values.size());
  Solution solution = end_with(preparation_.status, preparation_.message);
  double size = 0;
  if (preparation_.solver) {
    dealii::Vector<double> f(prescription.values.size());
    problem_.residual_forces(prescription.values, f);
    ties_.condense(f);
    const double all = f.l2_norm();
    for (unsigned i = 0; i < f.size(); ++i)
      f[i] = prescription.is_prescribed[i] ? 0 : -f[i];
    size = residual_size(f.l2_norm(), all);
    answer.seconds.setup = watch.seconds();
    solution = preparation_.solver->solve(f, watch);
    if (solution.u.size() > 0)
      ties_.distribute(solution.u);
  }
  fill(prescription, size, watch, solution, result);
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

template<int dim>
void KeptProblem<dim>::evaluate(const Prescription& prescription, double size, State& state) const {
  state.forces.reinit(state.u.size());
  state.energy = problem_.residual_forces(state.u, state.forces, &state.cell_energy);
  ties_.condense(state.forces);
  double squared = 0;
  for (unsigned i = 0; i < state.forces.size(); ++i)
    squared += prescription.is_prescribed[i] ? 0 : state.forces[i] * state.forces[i];
  state.residual = size > 0 ? std::sqrt(squared) / size : 0;
}

/// Iterative refinement (Wilkinson 1963). A slender body moves far under forces that are small compared with
/// those of its single cells, so the rounding of the latter may exceed the load. The criterion is the error
/// of the displacement, measured by the size of a correction: this is the error before it, to the accuracy of
/// the solver.
template<int dim>
void KeptProblem<dim>::correct(const Prescription& prescription, double size, Watch& watch,
                               Solution& solution, State& state) {
  constexpr int most_corrections = 5;
  constexpr double small_enough = 1e-8; ///< below all displayed digits
  double before = 1;
  for (int i = 0; i < most_corrections && !watch.should_stop(); ++i) {
    dealii::Vector<double> f(state.forces);
    for (unsigned k = 0; k < f.size(); ++k)
      f[k] = prescription.is_prescribed[k] ? 0 : -f[k];
    Solution correction = preparation_.solver->solve(f, watch);
    if (correction.u.size() > 0)
      ties_.distribute(correction.u);
    solution.iterations += correction.iterations;
    if (correction.status != Status::done || correction.u.size() == 0)
      break;
    const double change = correction.u.l2_norm() / state.u.l2_norm();
    if (!(change < before)) // corrections are rounding
      break;
    state.u += correction.u;
    state.error = change;
    evaluate(prescription, size, state);
    if (change < small_enough || state.residual < options_.tolerance)
      break;
    before = 0.5 * change;
  }
  if (watch.status() != Status::done)
    solution.status = watch.status();
}

/// Fills the displacement, the forces, and the solver error from the forces: K u - f at free unknowns.
template<int dim>
void KeptProblem<dim>::fill(const Prescription& prescription, double size, Watch& watch, Solution& solution,
                            Result& result) {
  constexpr double most_error = 1e-5; ///< far below the discretisation error
  Answer& answer = result.answer;
  State state;
  if (has_displacement(solution.status)) {
    if (solution.u.size() == 0) // stopped early: only prescribed nodes have moved
      solution.u.reinit(prescription.values.size());
    state.u = prescription.values;
    state.u += solution.u;
    evaluate(prescription, size, state);
    constexpr double beyond_doubt = 1e-8;
    if (solution.status == Status::done && !(state.residual < std::max(beyond_doubt, 2 * options_.tolerance)))
      correct(prescription, size, watch, solution, state);
    solution.u = state.u;
  }
  answer.status = solution.status;
  answer.message = std::move(solution.message);
  answer.iterations = solution.iterations;
  if (!has_displacement(answer.status))
    return;
  const bool is_solved = state.residual < most_residual() || (state.error && *state.error < most_error);
  answer.residual = state.error ? std::min(*state.error, state.residual) : state.residual;
  if (answer.status == Status::done && !is_solved) {
    answer.status = Status::failed;
    answer.message = fmt::format("the solution leaves a relative residual of {:.2g}", state.residual);
    if (state.error)
      answer.message += fmt::format(", the last correction of the displacement was {:.2g}", *state.error);
    return;
  }
  answer.displacement = problem_.at_grid_nodes(solution.u);
  if (!is_converged(answer.status))
    return;
  answer.strain_energy = state.energy;
  answer.cell_energy = std::move(state.cell_energy);
  // For linear elements the corner displacements suffice.
  if (options_.degree > 1 && !options_.shape)
    answer.cell_strain = problem_.mean_strains(solution.u);
  if (options_.recover_stress)
    problem_.recover(solution.u, answer);
  if (!options_.boundary_displacement) // else prescribed values are not the scene's
    answer.reaction = problem_.reactions(state.forces);
  if (has_friction(scene_.tied)) { // recomputes forces before those of ties are transferred
    dealii::Vector<double> forces(solution.u.size());
    problem_.residual_forces(solution.u, forces);
    answer.tie_press = press_of_ties(scene_, problem_.at_grid_nodes(forces));
  }
}

} // namespace

std::unique_ptr<Solver::Kept> keep(const Scene& scene, const Options& options, Watch& watch) {
  watch.report(0, "meshing");
  if (scene.strain == Strain::finite)
    return keep_finite(scene, options);
  switch (scene.dimension()) {
  case 1:
    return std::make_unique<KeptProblem<1>>(scene, options, watch);
  case 2:
    return std::make_unique<KeptProblem<2>>(scene, options, watch);
  default:
    return std::make_unique<KeptProblem<3>>(scene, options, watch);
  }
}

} // namespace maille::fem_ref
