#include "elastic/componentwise/componentwise_preconditioner.hpp"

#include "elastic/krylov/flexible_gradients.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace maille::deform {

List<FixedNode> fixed_nodes(const std::vector<Prescribed>& prescribed, int component) {
  List<FixedNode> fixed;
  for (const Prescribed& p : prescribed)
    if (p.component == component)
      fixed.push_back({p.node, p.value});
  std::ranges::sort(fixed, {}, &FixedNode::node);
  return fixed;
}

ComponentwisePreconditioner::ComponentwisePreconditioner(const Scene& scene, const CellModuli& moduli,
                                                         const std::vector<int>& components,
                                                         const std::vector<Prescribed>& prescribed,
                                                         ThreadTeam& team,
                                                         std::optional<List<NodalSpring>> springs)
    : scene_(scene), moduli_(moduli), prescribed_(prescribed), team_(team),
      has_own_springs_(springs.has_value()), springs_(springs ? *std::move(springs) : nodal_springs(scene)) {
  for (const int component : components)
    parts_.emplace_back().component = component;
}

void ComponentwisePreconditioner::set_up(Part& part) const {
  part.solver.reset(); // frees its memory first
  if (part.penalties.empty() && !has_own_springs_) {
    part.solver = std::make_unique<ComponentwiseSolver>(scene_, moduli_, part.component,
                                                        fixed_nodes(prescribed_, part.component), team_);
    return;
  }
  if (part.unit == 0) {
    part.unit = largest_weight(scene_, moduli_, part.component);
    part.weights = weights_per_link(scene_, moduli_, part.component, part.unit);
    part.fixed = fixed_nodes(prescribed_, part.component);
    part.is_loose = loose_nodes(scene_, part.fixed, springs_along(springs_, part.component, 1));
  }
  const Grid& grid = scene_.specimen.grid;
  const std::int64_t row_stride = padded_row(grid.nodes()[0]);
  LinkWeights weights;
  for (std::size_t axis = 0; axis < weights.link.size(); ++axis)
    weights.link[axis] = part.weights.link[axis].copy();
  for (const PenaltyLink& link : part.penalties) {
    const Index3 at = grid.node_at(link.node); // rows follow each other, in 2D too
    float* const of_axis = weights.link[level_axis(grid, link.axis)].data();
    of_axis[at[0] + row_stride * (at[1] + std::int64_t{1} * grid.nodes()[1] * at[2])] +=
        static_cast<float>(link.stiffness / part.unit);
  }
  part.solver =
      std::make_unique<ComponentwiseSolver>(scene_, std::move(weights), part.unit, part.fixed, part.is_loose,
                                            springs_along(springs_, part.component, part.unit), team_);
}

ComponentwiseSolver& ComponentwisePreconditioner::solver_of(Part& part) const {
  if (part.solver == nullptr)
    set_up(part);
  return *part.solver;
}

ComponentwiseSolver& ComponentwisePreconditioner::solver(int component) {
  return solver_of(*std::ranges::find(parts_, component, &Part::component));
}

void ComponentwisePreconditioner::set_penalties(const List<PenaltyLink>& links) {
  for (Part& part : parts_) {
    List<PenaltyLink> penalties;
    std::ranges::copy_if(links, std::back_inserter(penalties),
                         [&](const PenaltyLink& link) { return link.component == part.component; });
    if (part.solver != nullptr && penalties == part.penalties)
      continue;
    part.penalties = std::move(penalties);
    set_up(part);
  }
}

void ComponentwisePreconditioner::precondition(const Displacement& residual, Displacement& correction) {
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    ComponentwiseSolver& solver = solver_of(parts_[k]);
    solver.precondition(residual.component(k), correction.component(k));
    if (!solver.has_loose_nodes())
      continue;
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(correction.n_nodes()); ++i)
      if (solver.is_loose(i))
        correction(k, i) = residual(k, i) / solver.stiffness_at(i);
  }
}

std::vector<int> all_components(const Scene& scene) {
  std::vector<int> components(scene.dimension());
  std::iota(components.begin(), components.end(), 0);
  return components;
}

BodySystem::BodySystem(const CoupledTask& task)
    : ComponentwisePreconditioned(task, CellModuli(task.scene), all_components(task.scene)),
      elasticity_(task.scene) {}

void BodySystem::prescribe(Displacement& u) {
  for (const int component : all_components(task().scene)) {
    const List<FixedNode> fixed = fixed_nodes(task().prescribed, component);
    const bool is_at_rest = std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
    const std::span<double> values = u.component(component);
    if (task().start != nullptr)
      for (const FixedNode& f : fixed)
        values[f.node] = f.value;
    else if (!is_at_rest)
      preconditioner().solver(component).solve(values, {}, std::numeric_limits<double>::infinity(), false,
                                               task().must_stop);
  }
}

bool solve_coupled_body(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around componentwise multigrid";
  answer.displacement = task.start != nullptr ? *task.start : Displacement(task.scene.specimen.grid);
  BodySystem system(task);
  system.prescribe(answer.displacement);
  FlexibleGradients gradients(task);
  answer.seconds.setup = task.clock.seconds();
  return gradients.finish(system, answer);
}

} // namespace maille::deform
