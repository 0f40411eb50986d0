#include "maille/scene/nodal_forces.hpp"
#include "relax/coupled_limits.hpp"
#include "relax/field_sums.hpp"
#include "relax/lattice_elasticity.hpp"
#include "relax/separable_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

class BodySolver : public CoupledSystem {
public:
  /// @param u taken to the answer
  BodySolver(const CoupledTask& task, Displacement& u);
  void prescribe();
  /// @return false if stopped, or given up
  bool iterate(Answer& answer);
  void find_energy_and_reactions(Answer& answer);
  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }
  std::int64_t bytes() const;

private:
  void find_residual();
  void precondition();
  static bool has_ended(double left, double energy, const CoupledError& error, Answer& answer);
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }

  const CoupledTask& task_;
  const Scene& scene_;
  ThreadTeam& team_;
  LatticeElasticity elasticity_;
  std::vector<std::unique_ptr<SeparableSolver>> separable_;
  Displacement& u_;
  Displacement residual_, correction_, direction_, image_, diagonal_;
  std::vector<std::vector<double>> forces_; ///< empty: none along that component
  std::vector<std::vector<bool>> is_fixed_; ///< [component][node], nodes without matter too
  FieldSums sums_;                          ///< plane by plane across the last axis
};

BodySolver::BodySolver(const CoupledTask& task, Displacement& u)
    : task_(task), scene_(task.scene), team_(task.team), elasticity_(scene_), u_(u),
      residual_(scene_.specimen.grid), correction_(residual_), direction_(residual_), image_(residual_),
      sums_(scene_.specimen.grid, team_,
            scene_.specimen.grid.n_nodes() / scene_.specimen.grid.nodes()[d() - 1]) {}

/// Prescribed values, and where no start is given one from the separable model, which knows no more than each component by itself.
void BodySolver::prescribe() {
  const Grid& grid = scene_.specimen.grid;
  const auto n = static_cast<std::size_t>(grid.n_nodes());
  is_fixed_.assign(d(), std::vector<bool>(n, false));
  for (std::size_t node = 0; node < n; ++node)
    if (!scene_.specimen.is_node(grid.node_at(static_cast<std::int64_t>(node))))
      for (std::size_t b = 0; b < d(); ++b)
        is_fixed_[b][node] = true;
  const CellModuli moduli(scene_);
  diagonal_ = elasticity_.diagonal();
  for (std::size_t b = 0; b < d(); ++b) {
    const int component = static_cast<int>(b);
    std::vector<FixedNode> fixed;
    for (const Prescribed& p : task_.prescribed)
      if (p.component == component) {
        fixed.push_back({p.node, p.value});
        is_fixed_[b][static_cast<std::size_t>(p.node)] = true;
      }
    std::ranges::sort(fixed, {}, &FixedNode::node);
    forces_.push_back(nodal_forces(scene_, component));
    const bool is_at_rest = std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
    separable_.push_back(std::make_unique<SeparableSolver>(scene_, moduli, component, fixed, team_));
    if (task_.start != nullptr)
      for (const FixedNode& f : fixed)
        u_(component, f.node) = f.value;
    else if (!is_at_rest)
      separable_[b]->solve(u_.component[b], {}, std::numeric_limits<double>::infinity(), false,
                           task_.must_stop);
    for (std::size_t node = 0; node < n; ++node)
      if (task_.start == nullptr && separable_[b]->has_loose_nodes() &&
          separable_[b]->is_loose(static_cast<std::int64_t>(node)))
        u_.component[b][node] = 0;
  }
}

/// residual = f - K u where nodes are free, 0 elsewhere.
void BodySolver::find_residual() {
  elasticity_.apply(u_, residual_, team_);
  for (std::size_t b = 0; b < d(); ++b)
    for (std::size_t i = 0; i < residual_.component[b].size(); ++i)
      residual_.component[b][i] =
          is_fixed_[b][i] ? 0 : (forces_[b].empty() ? 0 : forces_[b][i]) - residual_.component[b][i];
}

void BodySolver::precondition() {
  for (std::size_t b = 0; b < d(); ++b) {
    SeparableSolver& solver = *separable_[b];
    solver.precondition(residual_.component[b], correction_.component[b]);
    for (std::size_t i = 0; i < correction_.component[b].size(); ++i) {
      if (is_fixed_[b][i])
        correction_.component[b][i] = 0;
      else if (solver.has_loose_nodes() && solver.is_loose(static_cast<std::int64_t>(i)))
        correction_.component[b][i] = residual_.component[b][i] / diagonal_.component[b][i];
    }
  }
}

/// No direction goes on: because nothing is left that can be told from rounding, or not.
bool BodySolver::has_ended(double left, double energy, const CoupledError& error, Answer& answer) {
  if (!is_left_by_rounding(left, energy)) {
    answer.message = "conjugate gradients came to no end: the moduli differ by more than the "
                     "preconditioner's float32 can tell";
    return false;
  }
  answer.residual = error.is_empty() ? 0 : answer.residual;
  return true;
}

bool BodySolver::iterate(Answer& answer) {
  find_residual();
  CoupledError error;
  double last = 0, last_mixed = 0, energy = 0;
  answer.residual = 1;
  while (answer.iterations < most_coupled_iterations && !task_.must_stop()) {
    if (task_.control.progress)
      task_.control.progress(std::min(0.99, static_cast<double>(answer.iterations) / 30), "solving");
    precondition();
    const double now = sums_.dot(residual_, correction_);
    energy = std::max(energy, now); // of the first error, about
    if (!(now > 0))
      return has_ended(now, energy, error, answer);
    // Float32 inside makes the preconditioner a little different every time: Polak and Ribiere's beta.
    const double beta = last > 0 ? std::max(0.0, (now - last_mixed) / last) : 0;
    sums_.add(1, correction_, beta, direction_);
    elasticity_.apply(direction_, image_, team_);
    const double curvature = sums_.dot(direction_, image_);
    if (!(curvature > 0))
      return has_ended(now, energy, error, answer);
    const double step = sums_.dot(residual_, direction_) / curvature;
    last_mixed = sums_.sum([&](std::size_t first, std::size_t end) {
      double mixed = 0;
      for (std::size_t b = 0; b < d(); ++b)
        for (std::size_t i = first; i < end; ++i) {
          u_.component[b][i] += step * direction_.component[b][i];
          if (!is_fixed_[b][i])
            residual_.component[b][i] -= step * image_.component[b][i];
          mixed += residual_.component[b][i] * correction_.component[b][i];
        }
      return mixed;
    });
    last = now;
    ++answer.iterations;
    error.add(step * step * curvature);
    elasticity_.apply(u_, image_, team_);
    const double of_state = sums_.dot(u_, image_);
    energy = std::max(energy, of_state);
    answer.residual = error.relative_to(of_state);
    if (answer.residual <= scene_.relaxation.tolerance)
      return true;
  }
  return false;
}

/// Energy, and what holds every prescribed component there.
void BodySolver::find_energy_and_reactions(Answer& answer) {
  elasticity_.apply(u_, image_, team_);
  answer.strain_energy = 0.5 * sums_.dot(u_, image_);
  for (const Prescribed& p : scene_.prescribed) {
    const auto b = static_cast<std::size_t>(p.component), i = static_cast<std::size_t>(p.node);
    answer.reaction.push_back(image_.component[b][i] - (forces_[b].empty() ? 0 : forces_[b][i]));
  }
}

std::int64_t BodySolver::bytes() const {
  std::int64_t sum = 6 * bytes_of(u_) + elasticity_.bytes();
  for (std::size_t b = 0; b < d(); ++b)
    sum += separable_[b]->bytes() +
           static_cast<std::int64_t>(forces_[b].size() * sizeof(double) + is_fixed_[b].size() / 8);
  return sum;
}

} // namespace

bool solve_coupled_body(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around separable multigrid";
  answer.displacement = task.start != nullptr ? *task.start : Displacement(task.scene.specimen.grid);
  BodySolver solver(task, answer.displacement);
  solver.prescribe();
  answer.seconds.setup = task.clock.seconds();
  const bool came_to_the_end = solver.iterate(answer);
  solver.find_energy_and_reactions(answer);
  if (!came_to_the_end)
    answer.reaction.clear();
  answer.bytes = solver.bytes();
  return obey_limits(task, solver, came_to_the_end, answer.displacement, answer);
}

} // namespace maille::deform
