#pragma once
/// Two stacked bodies with a sliding border, and their loads.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

namespace maille::test {

/// Labels 0, 1 and 2 by a function of the middle of a cell [cells]; cell edges `spacing` [m].
inline SceneBuilder labelled(const Index3& cells, double spacing,
                             const std::function<int(const Vec3&)>& label, const Material& one,
                             const Material& two) {
  std::vector<std::uint8_t> labels;
  for (const auto& [x, y, z] : all_below(cells))
    labels.push_back(static_cast<std::uint8_t>(label({x + 0.5, y + 0.5, z + 0.5})));
  SceneBuilder builder("labelled");
  builder
      .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest(cells),
              affine_of({spacing, spacing, spacing}))
      .material(1, one)
      .material(2, two);
  return builder;
}

/// Labels 1 below and 2 above, half of the cells each; held at the lower face.
inline SceneBuilder layers(const Index3& cells, double spacing, const ElasticConstants& below,
                           const ElasticConstants& above) {
  const auto label = [&](const Vec3& at) { return 2 * at[2] < cells[2] ? 1 : 2; };
  return labelled(cells, spacing, label, material_of(below), material_of(above)).hold("z-", "xyz");
}

/// Layers of one isotropic material.
inline SceneBuilder alike_layers(const Index3& cells, double spacing, double E, double nu) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, nu);
  return layers(cells, spacing, matter, matter);
}

/// A bar on a rough bed, pulled at one end. Friction is low, so that its moment at the bottom of the bar
/// hardly shifts the pressure; high shear stiffness keeps sections plane; no Poisson effect.
/// @return displacement of its end, q h^2 m (m + 1) / (2 E A), and T^2 / (2 E A q), for T = q h (m + 1/2)
inline std::array<double, 2> draw_on_rough_bed(double h, double E, Scene& scene) {
  constexpr int n = 16, m = 8;
  constexpr double little = 0.02, shift = -1e-5;
  const double p = -shift * E / h, q = little * p * h, pull = q * h * (m + 0.5);
  scene = layers({n, 1, 2}, h, ElasticConstants::isotropic(1e4 * E, 0),
                 {{E, E, E}, 0, 0, 0, 50 * E, 50 * E, 50 * E})
              .move("z+", {0, 0, shift}, "z")
              .build();
  scene.tractions.push_back({scene.specimen.grid.cell({n - 1, 0, 1}), 0, true, {pull / (h * h), 0, 0}});
  scene.sliding = {{1, 2, little}};
  return {q * m * (m + 1) / (2 * E), pull * pull / (2 * E * h * h * q)};
}

/// Sum of the forces of all moves [N] along one component, or along all if it is below 0.
inline double force_of_moves(const Scene& scene, const Answer& answer, int component = -1) {
  double sum = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i)
    if (!scene.prescribed[i].held && (component < 0 || scene.prescribed[i].component == component))
      sum += answer.reaction[i];
  return sum;
}

} // namespace maille::test
