#include "elastic/componentwise/coupled_body.hpp"

#include "maille/scene/nodal_forces.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace maille::deform {

std::vector<int> all_components(const Scene& scene) {
  std::vector<int> components(static_cast<std::size_t>(scene.dimension()));
  std::iota(components.begin(), components.end(), 0);
  return components;
}

BodySystem::BodySystem(const CoupledTask& task)
    : task_(task), elasticity_(task.scene), moduli_(task.scene),
      preconditioner_(task.scene, moduli_, all_components(task.scene), task.prescribed, task.team) {}

void BodySystem::prescribe(Displacement& u) {
  for (const int component : all_components(task_.scene)) {
    const std::vector<FixedNode> fixed = fixed_nodes(task_.prescribed, component);
    const bool is_at_rest = std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
    const std::span<double> values = u.component(component);
    if (task_.start != nullptr)
      for (const FixedNode& f : fixed)
        values[static_cast<std::size_t>(f.node)] = f.value;
    else if (!is_at_rest)
      preconditioner_.solver(component).solve(values, {}, std::numeric_limits<double>::infinity(), false,
                                              task_.must_stop);
  }
}

FlexibleGradients BodySystem::gradients() const {
  const Specimen& body = task_.scene.specimen;
  std::vector<std::vector<double>> forces;
  std::vector<std::vector<bool>> is_fixed(static_cast<std::size_t>(task_.scene.dimension()));
  for (std::size_t b = 0; b < is_fixed.size(); ++b) {
    forces.push_back(nodal_forces(task_.scene, static_cast<int>(b)));
    is_fixed[b].resize(static_cast<std::size_t>(body.grid.n_nodes()));
    for (std::size_t node = 0; node < is_fixed[b].size(); ++node)
      is_fixed[b][node] = !body.is_node(body.grid.node_at(static_cast<std::int64_t>(node)));
  }
  for (const Prescribed& p : task_.prescribed)
    is_fixed[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  return FlexibleGradients(task_, std::move(forces), std::move(is_fixed));
}

bool solve_coupled_body(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around componentwise multigrid";
  answer.displacement = task.start != nullptr ? *task.start : Displacement(task.scene.specimen.grid);
  BodySystem system(task);
  system.prescribe(answer.displacement);
  FlexibleGradients gradients = system.gradients();
  answer.seconds.setup = task.clock.seconds();
  answer.bytes = system.held_bytes();
  return gradients.finish(system, system, answer);
}

} // namespace maille::deform
