#pragma once
/// Two bodies on each other, whose border slides, and what draws them.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/scenes.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::test {

/// Labels 1 below and 2 above, half of the cells each, of edges `spacing` [m]; held at the lower face.
inline SceneBuilder layers(const Index3& cells, double spacing, const ElasticConstants& below,
                           const ElasticConstants& above) {
  std::vector<std::uint8_t> labels(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]), 1);
  std::fill(labels.begin() + static_cast<std::ptrdiff_t>(labels.size() / 2), labels.end(), std::uint8_t{2});
  SceneBuilder builder("layers");
  builder
      .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest(cells),
              affine_of({spacing, spacing, spacing}))
      .material(1, material_of(below))
      .material(2, material_of(above))
      .hold("z-", "xyz");
  return builder;
}

/// Sum of the forces of all moves [N], along one component or, below 0, along all.
inline double force_of_moves(const Scene& scene, const Answer& answer, int component = -1) {
  double sum = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i)
    if (!scene.prescribed[i].held && (component < 0 || scene.prescribed[i].component == component))
      sum += answer.reaction[i];
  return sum;
}

} // namespace maille::test
