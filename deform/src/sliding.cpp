// Scenes whose labels slide, for every method.
#include "sliding.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/sliding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// The question of one component alone: nothing moves or pulls along the others.
Scene of_component(Scene scene, int component) {
  for (Prescribed& p : scene.prescribed)
    if (p.component != component)
      p.value = 0;
  for (std::size_t b = 0; b < 3; ++b) {
    if (static_cast<int>(b) == component)
      continue;
    scene.gravity[b] = 0;
    for (FaceLoad& load : scene.tractions)
      load.traction[b] = 0;
  }
  return scene;
}

std::string name_of(const SlidingBorder& pair) {
  return fmt::format("the border between labels {} and {}", pair.one, pair.other);
}

/// What stands for a component in the answer to all.
void take_component(const Scene& scene, const Answer& part, int component, Answer& all) {
  const auto source = part.displacement.component(component);
  std::ranges::copy(source, all.displacement.component(component).begin());
  for (std::size_t i = 0; i < all.reaction.size() && i < part.reaction.size(); ++i)
    if (scene.prescribed[i].component == component)
      all.reaction[i] = part.reaction[i];
  if (part.strain_energy)
    all.strain_energy = all.strain_energy.value_or(0) + *part.strain_energy;
  all.iterations += part.iterations;
  all.residual = std::max(all.residual, part.residual);
  all.seconds.setup += part.seconds.setup;
  all.seconds.solve += part.seconds.solve;
  all.bytes = std::max(all.bytes, part.bytes);
  all.n_cut += part.n_cut;
  if (is_converged(all.status) && part.status != Status::done)
    all.status = part.status;
  if (all.message.empty())
    all.message = part.message;
}

/// The scale of taut limits is that of the body, whatever slides.
Scene with_limits_of_whole(const Scene& scene, bool is_of_limits) {
  Scene whole = scene;
  whole.sliding.clear();
  Scene known = scene;
  known.limits = (is_of_limits ? with_limits(whole) : with_taut_scale(whole)).limits;
  return known;
}

} // namespace

Answer solve_sliding(const Scene& asked, bool is_of_limits,
                     const std::function<Answer(const Scene&)>& solve) {
  const Scene scene = with_limits_of_whole(asked, is_of_limits);
  const SplitScene split = split_borders(scene);
  Answer answer = solve(split.scene);
  answer.cell_energy = cell_energies(split.scene, answer);
  return joined(scene, split, std::move(answer));
}

std::string friction_that_asks_for_forces(const Scene& scene) {
  for (const SlidingBorder& pair : scene.sliding)
    if (pair.friction > 0)
      return fmt::format("{} has friction, which needs the force that presses it, and components that do "
                         "not feel each other have none: coupled and fem_q1 take it",
                         name_of(pair));
  return {};
}

std::optional<Answer> solve_sliding_by_components(const Scene& scene, bool is_of_limits,
                                                  const std::function<Answer(const Scene&)>& solve,
                                                  std::string& obstacle) {
  std::vector<int> across;
  for (const SlidingBorder& pair : scene.sliding) {
    const std::vector<int> axes = axes_of_border(scene.specimen, pair);
    if (axes.size() > 1) {
      obstacle = fmt::format("{} has faces across {} axes, and components that do not feel each other cannot "
                             "slide along it",
                             name_of(pair), axes.size());
      return std::nullopt;
    }
    across.push_back(axes.empty() ? 0 : axes.front());
  }
  const Scene known = with_limits_of_whole(scene, is_of_limits);
  Answer all;
  std::array<std::vector<SplitNode>, 3> copies;
  const std::size_t n_reactions = scene.prescribed.size();
  for (int component = 0; component < 3; ++component) {
    // Along its normal a border holds together; along the other axes nothing joins its sides.
    std::vector<SlidingBorder> open;
    for (std::size_t i = 0; i < across.size(); ++i)
      if (across[i] != component)
        open.push_back(scene.sliding[i]);
    SplitScene split = split_borders(of_component(known, component), open);
    if (std::ranges::any_of(split.scene.tied.ties, [](const NodeTie& tie) { return tie.normal == Vec3{}; })) {
      obstacle = "labels that slide are joined through a third one, which cannot be kept apart one component "
                 "at a time";
      return std::nullopt;
    }
    split.scene.tied.ties.clear();
    Answer of_split = solve(split.scene);
    of_split.cell_energy = cell_energies(split.scene, of_split);
    Answer part = joined(known, split, std::move(of_split));
    if (!has_displacement(part.status))
      return part;
    if (component == 0) {
      all.method = part.method;
      all.algorithm = part.algorithm + ", component by component on bodies that slide";
      all.displacement = Displacement(scene.specimen.grid);
      all.reaction.assign(part.reaction.empty() ? 0 : n_reactions, 0);
      all.cell_strain.assign(part.cell_strain.size(), {});
      all.cell_energy.assign(part.cell_energy.size(), 0);
    }
    take_component(scene, part, component, all);
    for (std::size_t cell = 0; cell < all.cell_strain.size(); ++cell) // of one component alone: they add up
      for (std::size_t k = 0; k < 6; ++k)
        all.cell_strain[cell][k] += part.cell_strain[cell][k];
    for (std::size_t cell = 0; cell < all.cell_energy.size() && cell < part.cell_energy.size(); ++cell)
      all.cell_energy[cell] += part.cell_energy[cell];
    copies[component] = std::move(part.split);
  }
  // A node that is there once for a component has one value of it.
  std::map<std::pair<std::int64_t, std::int32_t>, Vec3> of_copy;
  for (const auto& nodes : copies)
    for (const SplitNode& node : nodes)
      of_copy.try_emplace({node.node, node.label}, all.displacement.at(node.node));
  for (std::size_t b = 0; b < 3; ++b)
    for (const SplitNode& node : copies[b])
      of_copy.at({node.node, node.label})[b] = node.displacement[b];
  for (const auto& [place, displacement] : of_copy)
    all.split.push_back({place.first, place.second, displacement});
  return all;
}

} // namespace maille::deform
