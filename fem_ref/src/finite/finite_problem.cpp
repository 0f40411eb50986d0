#include "finite/finite_problem.hpp"

#include "finite/finite_cell.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::fem_ref {

namespace {

using Vector = dealii::Vector<double>;

template<int dim>
struct State {
  Vector u;                        ///< including prescribed values [m]
  Vector forces;                   ///< forces that hold every unknown, in addition to the loads [N]
  double strain_energy = 0;        ///< [J]
  std::vector<double> cell_energy; ///< energy per grid cell
  std::vector<typename FiniteCell<dim>::Fields> fields; ///< by cell of the mesh
};

template<int dim>
class FiniteProblem : public Solver::Kept {
public:
  FiniteProblem(const Scene& scene, const Options& options)
      : Kept(scene), options_(options), problem_(scene_, options_, true),
        cell_(problem_.body().element(), scene_.specimen.grid.spacing(), scene_.plane), loads_(n_unknowns()) {
    Scene relaxed = scene_;
    relaxed.active_stress.clear();
    problem_.ask(relaxed);
    problem_.residual_forces(Vector(n_unknowns()), loads_); // dead loads: independent of the deformation
    loads_ *= -1;
    problem_.ask(scene_);
  }
  Result solve(const Scene& scene, Watch& watch) override;

private:
  unsigned n_unknowns() const { return dim * problem_.body().n_nodes(); }
  bool evaluate(const Scene& step, double fraction, State<dim>& state, const Vector& move, Vector& right);
  std::string advance(const Scene& step, double fraction, State<dim>& state, Watch& watch);
  std::string correct(const Scene& step, double fraction, State<dim>& state, const Vector& move,
                      Watch& watch);

  Options options_;
  Problem<dim> problem_;
  FiniteCell<dim> cell_;
  Vector loads_;        ///< full traction and gravity loads [N]
  LinearSystem system_; ///< the tangent
  std::string solver_;  ///< in words
  std::int64_t bytes_ = 0;
  std::int64_t iterations_ = 0;
  double change_ = 0; ///< last correction: the larger of u's (relative) and theta's
  double error_ = 0;  ///< estimated error after the last correction
};

/// Forces, energy and tangent at a state. @param move change of prescribed values in the next correction [m]
/// @param right  receives the forces at free unknowns @return false if a cell is inverted
template<int dim>
bool FiniteProblem<dim>::evaluate(const Scene& step, double fraction, State<dim>& state, const Vector& move,
                                  Vector& right) {
  const Body<dim>& body = problem_.body();
  const auto n = static_cast<unsigned>(body.element().n_unknowns());
  state.forces = loads_;
  state.forces *= -fraction;
  state.strain_energy = 0;
  state.cell_energy.assign(step.specimen.grid.n_cells(), 0);
  right.reinit(n_unknowns());
  Eigen::VectorXd of_cell(n), moved(n);
  dealii::FullMatrix<double> tangent(n, n);
  std::vector<dealii::types::global_dof_index> at;
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    problem_.unknowns(cell, at);
    for (unsigned i = 0; i < n; ++i) {
      of_cell[i] = state.u[at[i]];
      moved[i] = move[at[i]];
    }
    const auto response = cell_.respond(matter_of(step, body.grid_cell(cell)), of_cell, state.fields[cell]);
    if (!response)
      return false;
    state.strain_energy += state.cell_energy[body.grid_cell(cell)] = response->strain_energy;
    const Eigen::VectorXd by_move = response->stiffness * moved;
    for (unsigned i = 0; i < n; ++i) {
      state.forces[at[i]] += response->force[i];
      right[at[i]] -= by_move[i];
    }
    if (!system_.matrix.empty()) {
      std::copy_n(response->stiffness.data(), response->stiffness.size(), &tangent(0, 0));
      system_.constraints.distribute_local_to_global(tangent, at, system_.matrix);
    }
  }
  problem_.for_each_spring([&](unsigned node, const Eigen::Matrix<double, dim, dim>& stiffness) {
    for (unsigned a = 0; a < dim; ++a)
      for (unsigned b = 0; b < dim; ++b) {
        state.forces[dim * node + a] += stiffness(a, b) * state.u[dim * node + b];
        right[dim * node + a] -= stiffness(a, b) * move[dim * node + b];
      }
  });
  if (!system_.matrix.empty())
    problem_.add_springs(system_);
  right -= state.forces;
  return true;
}

/// One Newton correction. @return reason of a failure; empty on success
template<int dim>
std::string FiniteProblem<dim>::correct(const Scene& step, double fraction, State<dim>& state,
                                        const Vector& move, Watch& watch) {
  if (system_.pattern.empty()) // not created yet, or freed
    problem_.outline(system_, problem_.prescription().is_prescribed, {});
  system_.matrix.reinit(system_.pattern);
  Vector right;
  if (!evaluate(step, fraction, state, move, right))
    return "a cell turns inside out";
  system_.constraints.set_zero(right);
  Preparation preparation = prepare(system_, options_, watch);
  bytes_ = std::max(bytes_, preparation.bytes);
  solver_ = preparation.algorithm.substr(std::min<std::size_t>(2, preparation.algorithm.size())); // no degree
  if (!preparation.solver)
    return preparation.status == Status::failed
               ? "the tangent is not positive definite, as where a body buckles"
               : preparation.message;
  Solution correction = preparation.solver->solve(right, watch);
  if (correction.status != Status::done)
    return correction.message;
  correction.u += move;
  state.u += correction.u;
  ++iterations_;
  change_ = correction.u.l2_norm() / std::max(state.u.l2_norm(), std::numeric_limits<double>::min());
  for (const auto& of_cell : state.fields) // they may change without a change of u
    change_ = std::max(change_, of_cell.gap.cwiseAbs().maxCoeff());
  return {};
}

/// Advances an equilibrium state to another fraction of moves and loads. The first correction includes the
/// prescribed change. Newton converges superlinearly, so the remaining error is less than the last correction
/// times its ratio to the previous one; for slender bodies corrections end at rounding level.
/// @return reason of a failure (`state` is then invalid); empty on success
template<int dim>
std::string FiniteProblem<dim>::advance(const Scene& step, double fraction, State<dim>& state, Watch& watch) {
  constexpr int most_corrections = 20;
  constexpr double settled = 1e-8, most_error = 1e-5; ///< of u; the discretisation error is far larger
  problem_.ask(step);
  const Prescription prescription = problem_.prescription();
  Vector move = prescription.values;
  for (unsigned i = 0; i < move.size(); ++i)
    move[i] = prescription.is_prescribed[i] ? move[i] - state.u[i] : 0;
  double before = 1;
  for (int i = 0; i < most_corrections; ++i) {
    if (watch.should_stop())
      return "stopped";
    if (std::string reason = correct(step, fraction, state, move, watch); !reason.empty())
      return reason;
    if (!(change_ < 2 * before))
      return "Newton's corrections grow";
    error_ = change_ * std::min(1.0, change_ / before);
    if (error_ <= settled || (change_ <= most_error && change_ > 0.5 * before)) {
      system_.matrix.clear();
      Vector right;
      return evaluate(step, fraction, state, move = 0, right) ? "" : "a cell turns inside out";
    }
    before = change_;
    move = 0;
  }
  return fmt::format("Newton's method does not settle in {} corrections", most_corrections);
}

/// Increments are halved without convergence, and doubled after two successes.
template<int dim>
Result FiniteProblem<dim>::solve(const Scene& scene, Watch& watch) {
  constexpr double least_increment = 1.0 / 1024; ///< fraction of moves and loads
  Result result;
  Answer& answer = result.answer;
  answer.method = method_name(options_);
  result.degrees_of_freedom = n_unknowns();
  answer.seconds.setup = watch.seconds();
  Control silent; // solvers would report progress within one increment
  silent.threads = watch.threads();
  silent.stop_requested = [&] { return watch.should_stop(); };
  Watch inner(silent);

  State<dim> state;
  state.u.reinit(n_unknowns());
  state.fields.resize(problem_.body().n_cells());
  const double most = 1.0 / std::max(1, scene.relaxation.increments);
  double reached = 0, increment = most;
  int n_increments = 0;
  bool was_balanced = false;
  while (reached < 1 && watch.status() == Status::done) {
    watch.report(0.1 + 0.9 * reached, "balancing an increment");
    const double next = reached + increment + least_increment / 2 < 1 ? reached + increment : 1;
    State<dim> trial = state;
    const std::string reason = advance(scaled(scene, next), next, trial, inner);
    if (reason.empty()) {
      state = std::move(trial);
      reached = next;
      ++n_increments;
      if (std::exchange(was_balanced, !was_balanced))
        increment = std::min(most, 2 * increment);
      continue;
    }
    was_balanced = false;
    increment *= 0.5;
    if (increment < least_increment && watch.status() == Status::done) {
      answer.status = Status::failed;
      answer.message =
          fmt::format("no balance beyond {:.3g} % of moves and loads: {}", 100 * reached, reason);
      break;
    }
  }
  if (reached < 1 && watch.status() != Status::done) {
    answer.status = watch.status();
    answer.message = fmt::format("stopped at {:.3g} % of moves and loads", 100 * reached);
  }
  const bool has_pressure = dim == 3 || scene.plane == PlaneAssumption::strain;
  answer.algorithm = fmt::format("total Lagrange, Q{}{}, {} increment{}{}", options_.degree,
                                 has_pressure ? fmt::format("-P{}", options_.degree - 1) : "", n_increments,
                                 n_increments == 1 ? "" : "s", solver_);
  answer.iterations = iterations_;
  answer.bytes = bytes_ + problem_.body().bytes();
  answer.seconds.solve = watch.seconds() - answer.seconds.setup;
  problem_.ask(scene);
  if (has_displacement(answer.status))
    answer.displacement = problem_.at_grid_nodes(state.u);
  if (is_converged(answer.status)) {
    answer.residual = error_;
    answer.strain_energy = state.strain_energy;
    answer.cell_energy = std::move(state.cell_energy);
    answer.cell_strain.resize(scene.specimen.grid.n_cells());
    for (int cell = 0; cell < problem_.body().n_cells(); ++cell)
      answer.cell_strain[problem_.body().grid_cell(cell)] = cell_.mean_strain(state.fields[cell]);
    answer.reaction = problem_.reactions(state.forces);
  }
  watch.report(1, "done");
  return result;
}

} // namespace

std::unique_ptr<Solver::Kept> keep_finite(const Scene& scene, const Options& options) {
  if (scene.dimension() == 2)
    return std::make_unique<FiniteProblem<2>>(scene, options);
  return std::make_unique<FiniteProblem<3>>(scene, options);
}

std::string why_no_finite_strain(const Scene& scene, const Options& options) {
  if (scene.strain != Strain::finite)
    return {};
  if (scene.dimension() < 2)
    return "finite strain is for bodies of two and three dimensions";
  if (std::ranges::any_of(scene.tractions, &FaceLoad::follows))
    return "a pressure follows its faces at finite strain, which these finite elements do not: a traction "
           "stays";
  if (!scene.sliding.empty() || !scene.tied.ties.empty())
    return "finite strain knows no sliding borders";
  if (ranks().size > 1)
    return "finite strain is solved on one rank";
  if (options.shape || options.body_force || options.exact || options.boundary_displacement)
    return "finite strain knows neither shapes nor manufactured solutions";
  return {};
}

} // namespace maille::fem_ref
