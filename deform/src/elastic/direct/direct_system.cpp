#include "elastic/direct/direct_system.hpp"

#include "elastic/krylov/flexible_gradients.hpp"
#include "maille/plugins/sparse_cholesky.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::deform {

namespace {

/// Largest numbers of unknowns: ordering more takes long.
constexpr std::int64_t most_components = 60'000, most_components_of_slender = 200'000;
/// Operations of the factorisation that take as long as one iteration per component, on small bodies and one
/// thread.
constexpr double operations_per_iteration = 100;
/// Bytes per non-zero (value and row index).
constexpr std::int64_t per_number = sizeof(double) + sizeof(int);
/// Largest factor with its fields [bytes].
constexpr std::int64_t most_bytes = std::int64_t{512} << 20;

/// A column of k cells across has (k + 1)^2 / k^2 nodes a cell.
double cells_across(const Specimen& body) {
  const double nodes_per_cell =
      static_cast<double>(body.n_matter_nodes()) / static_cast<double>(body.n_matter_cells());
  return 1 / (std::sqrt(nodes_per_cell) - 1);
}

} // namespace

DirectSystem::DirectSystem(const CoupledTask& task) : BodySystem(task) {
  const Specimen& body = task.scene.specimen;
  nodes_ = nodes_of_matter(body);
  fixed_ = FixedMask(body.grid, task.prescribed).of_nodes(nodes_);
  for (std::size_t place = 0; place < nodes_.size(); ++place)
    for (int component = 0; component < 3; ++component)
      if (!fixed_(component, place))
        unknowns_.push_back({component, nodes_[place]});
  lower_ = StiffnessBlocks(body, elasticity(), nodes_).lower(fixed_);
  of_matrix_ = Charge(static_cast<std::size_t>(lower_.nonZeros() * per_number));
  factor_ = simplicial_cholesky(lower_);
}

DirectSystem::~DirectSystem() = default;

bool DirectSystem::factor() {
  of_factor_ = {};
  of_factor_ = Charge(static_cast<std::size_t>(factor_->bytes()));
  return factor_->factor(lower_) > 0;
}

void DirectSystem::precondition(const Displacement& residual, Displacement& correction) {
  Eigen::VectorXd values(n_components());
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = residual(unknowns_[i].component, unknowns_[i].node);
  values = factor_->solve(values);
  std::ranges::fill(correction.values(), 0.0);
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    correction(unknowns_[i].component, unknowns_[i].node) = values[static_cast<Eigen::Index>(i)];
}

/// Links join nodes of one cell, so the factor has the same numbers.
void DirectSystem::set_penalties(const List<PenaltyLink>& links) {
  StiffnessBlocks blocks(task().scene.specimen, elasticity(), nodes_);
  for (const PenaltyLink& link : links)
    blocks.add_spring(link.node, link.axis, link.component, link.stiffness);
  lower_ = blocks.lower(fixed_);
  if (factor())
    return;
  // The penalties exceed float64. The factor of K alone still preconditions.
  lower_ = StiffnessBlocks(task().scene.specimen, elasticity(), nodes_).lower(fixed_);
  factor();
}

std::int64_t DirectSystem::iterations_worth_it() const {
  return static_cast<std::int64_t>(
      std::ceil(factor_->n_operations() / (operations_per_iteration * static_cast<double>(n_components()))));
}

std::int64_t DirectSystem::bytes() const {
  return lower_.nonZeros() * per_number + factor_->bytes() +
         task().scene.specimen.grid.n_nodes() * FlexibleGradients::bytes_per_grid_node;
}

bool is_very_slender(const Specimen& body) {
  constexpr double least_slenderness = 100, most_cells_over_square = 3;
  const double longest = *std::ranges::max_element(body.grid.cells());
  if (body.grid.n_nodes() * FlexibleGradients::bytes_per_grid_node > most_bytes ||
      static_cast<double>(body.n_matter_cells()) > most_cells_over_square * longest * longest)
    return false;
  const double across = cells_across(body);
  return across > 0 && longest >= least_slenderness * across;
}

std::int64_t bytes_for_factor(const Specimen& body) {
  constexpr double most_cells_across = 3.1, per_component = 480, per_square = 95; // measured up to 5
  if (3 * body.n_matter_cells() > most_components_of_slender) // there are more nodes than cells
    return 0;
  const std::int64_t n_components = 3 * body.n_matter_nodes();
  const double across = cells_across(body);
  const bool may_have_one =
      is_very_slender(body) ? n_components <= most_components_of_slender
                            : n_components <= most_components && across > 0 && across <= most_cells_across;
  if (!may_have_one)
    return 0;
  const std::int64_t bytes =
      n_components * static_cast<std::int64_t>(per_component + per_square * across * across) +
      body.grid.n_nodes() * FlexibleGradients::bytes_per_grid_node;
  return bytes <= most_bytes ? bytes : 0;
}

std::unique_ptr<DirectSystem> make_direct_system(const CoupledTask& task) {
  const std::int64_t forecast = bytes_for_factor(task.scene.specimen);
  if (forecast == 0)
    return nullptr;
  auto system = std::make_unique<DirectSystem>(task);
  return system->n_components() > 0 && system->bytes() <= forecast ? std::move(system) : nullptr;
}

std::optional<bool> solve_coupled_by_factor(const CoupledTask& task, std::unique_ptr<DirectSystem> system,
                                            Answer& answer) {
  if (system == nullptr || !system->factor())
    return std::nullopt;
  answer.algorithm = "lattice elasticity, conjugate gradients around a Cholesky factor";
  if (answer.iterations == 0)
    answer.seconds.setup = task.clock.seconds();
  answer.displacement = task.initial_state();
  return FlexibleGradients(task).finish(*system, answer);
}

} // namespace maille::deform
