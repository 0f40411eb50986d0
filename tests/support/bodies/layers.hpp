#pragma once
/// Two bodies on each other, whose border slides, and what draws them.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene_builder.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::tests {

inline Material of_constants(const ElasticConstants& constants) {
  Material material;
  material.name = "matter";
  material.elasticity = constants;
  return material;
}

/// Labels 1 below and 2 above, half of the cells each, of edges `spacing` [m]; held at the lower face.
inline SceneBuilder layers(const Index3& cells, double spacing, const ElasticConstants& below,
                           const ElasticConstants& above) {
  std::vector<std::uint8_t> labels(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]), 1);
  std::fill(labels.begin() + static_cast<std::ptrdiff_t>(labels.size() / 2), labels.end(), std::uint8_t{2});
  SceneBuilder builder("layers");
  builder
      .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest(cells),
              affine_of({spacing, spacing, spacing}))
      .material(1, of_constants(below))
      .material(2, of_constants(above))
      .hold("z-", "xyz");
  return builder;
}

/// Sum of the forces of all moves [N].
inline double force_of_moves(const Scene& scene, const Answer& answer, int component) {
  double sum = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i)
    if (!scene.prescribed[i].held && scene.prescribed[i].component == component)
      sum += answer.reaction[i];
  return sum;
}

} // namespace maille::tests
