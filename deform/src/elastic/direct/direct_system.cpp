#include "elastic/direct/direct_system.hpp"

#include "maille/scene/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace maille::deform {

namespace {

/// A factor of more numbers is large [16 bytes], and so is the time to order more components.
constexpr double most_numbers = 1e7;
constexpr std::size_t most_components = 60'000;
/// Of a factor in the time that an iteration takes for a component: small bodies, one thread.
constexpr double operations_per_iteration = 100;

bool is_small(const DirectSystem& system) {
  return system.n_components() > 0 && system.factor_numbers() <= most_numbers;
}

bool has_few_components(const Specimen& body) {
  std::size_t n = 0;
  for (std::int64_t node = 0; node < body.grid.n_nodes() && n <= most_components; ++node)
    n += body.is_node(body.grid.node_at(node)) ? 3 : 0;
  return n <= most_components;
}

} // namespace

DirectSystem::DirectSystem(const CoupledTask& task) : BodySystem(task) {
  const Specimen& body = task.scene.specimen;
  nodes_ = nodes_of_matter(body);
  place_.assign(static_cast<std::size_t>(body.grid.n_nodes()), -1);
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    place_[static_cast<std::size_t>(nodes_[i])] = static_cast<std::int32_t>(i);
  is_fixed_.assign(3 * nodes_.size(), 0);
  for (const Prescribed& p : task.prescribed)
    is_fixed_[3 * static_cast<std::size_t>(place_[static_cast<std::size_t>(p.node)]) +
              static_cast<std::size_t>(p.component)] = 1;
  for (std::size_t i = 0; i < is_fixed_.size(); ++i)
    if (is_fixed_[i] == 0)
      unknowns_.push_back({static_cast<int>(i % 3), nodes_[i / 3]});
  lower_ = StiffnessBlocks(body, elasticity(), nodes_).lower(is_fixed_);
  constexpr std::size_t per_number = sizeof(double) + sizeof(int);
  of_matrix_ = Charge(static_cast<std::size_t>(lower_.nonZeros()) * per_number);
  factor_.analyzePattern(lower_);
  for (const int below : factor_.numbers_below()) {
    numbers_ += 1.0 + below;
    operations_ += (1.0 + below) * (1.0 + below);
  }
}

bool DirectSystem::factor() {
  constexpr double per_number = sizeof(double) + sizeof(int);
  of_factor_ = {};
  of_factor_ = Charge(static_cast<std::size_t>(numbers_ * per_number));
  factor_.factorize(lower_);
  return factor_.info() == Eigen::Success;
}

void DirectSystem::precondition(const Displacement& residual, Displacement& correction) {
  Eigen::VectorXd values(n_components());
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = residual(unknowns_[i].component, unknowns_[i].node);
  values = factor_.solve(values).eval();
  std::ranges::fill(correction.values(), 0.0);
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    correction(unknowns_[i].component, unknowns_[i].node) = values[static_cast<Eigen::Index>(i)];
}

/// Links join nodes of one cell, so the factor has the same numbers.
void DirectSystem::set_penalties(const List<PenaltyLink>& links) {
  const Specimen& body = task().scene.specimen;
  StiffnessBlocks blocks(body, elasticity(), nodes_);
  for (const PenaltyLink& link : links) {
    const auto place = [&](std::int64_t node) {
      return static_cast<std::size_t>(place_[static_cast<std::size_t>(node)]);
    };
    constexpr std::array<std::size_t, 3> after{1, 3, 9};
    blocks.add_spring(place(link.node), place(link.node + body.grid.stride(link.axis)),
                      after[static_cast<std::size_t>(link.axis)], link.component, link.stiffness);
  }
  lower_ = blocks.lower(is_fixed_);
  factor();
}

int DirectSystem::find_direction(const Displacement& residual, int, double, const std::function<bool()>&,
                                 Displacement& direction) {
  precondition(residual, direction);
  return 1;
}

std::int64_t iterations_worth_a_factor(const CoupledTask& task) {
  constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
  if (!has_few_components(task.scene.specimen))
    return never;
  const DirectSystem system(task);
  if (!is_small(system))
    return never;
  return static_cast<std::int64_t>(std::ceil(
      system.factor_operations() / (operations_per_iteration * static_cast<double>(system.n_components()))));
}

bool solve_coupled_otherwise(const CoupledTask& task, Answer& answer) {
  if (has_few_components(task.scene.specimen)) {
    DirectSystem system(task);
    if (is_small(system) && system.factor()) {
      answer.algorithm = "lattice elasticity, conjugate gradients around a Cholesky factor";
      answer.displacement = task.initial_state();
      FlexibleGradients gradients = system.gradients();
      return gradients.finish(system, system, answer);
    }
  }
  return solve_coupled_body(task, answer);
}

} // namespace maille::deform
