#pragma once
/// A bar of proportions 4 x 1 x 1, held at one end and bent to an arc or twisted at the other.

#include "support/bodies/scenes.hpp"

#include <cmath>
#include <numbers>

namespace maille::test {

constexpr double bar_length = 32e-3, bar_height = 8e-3; ///< [m]

/// Prescribes all components of the nodes of a face along x, as given by `turn`.
inline void turn_face(Scene& scene, bool upper, Turn turn) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[0] == (upper ? grid.nodes()[0] - 1 : 0))
      turn.nodes.push_back(node);
  for (const std::int64_t node : turn.nodes)
    for (int b = 0; b < scene.dimension(); ++b)
      scene.prescribed.push_back(
          {node, b, turn.displacement(scene.specimen.position(grid.node_at(node)))[std::size_t(b)], false});
  test::sort_prescribed(scene);
  scene.turns.push_back(std::move(turn));
}

/// Solved in blocks, Poisson's ratio 0, unless changed. @param cells across
inline Scene straight_bar(int dimension, int cells) {
  const double h = bar_height / cells;
  Scene scene = box_scene(dimension, {4 * cells, cells, dimension == 3 ? cells : 1}, {h, h, h});
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0);
  scene.strain = Strain::finite;
  return scene;
}

/// Position of the rest point x on an arc of that angle, without strain along the axis y = height / 2.
inline Vec3 on_arc(const Vec3& x, double angle) {
  const double radius = bar_length / angle, s = x[0] / radius, r = radius - (x[1] - bar_height / 2);
  return {std::sin(s) * r, radius - std::cos(s) * r + bar_height / 2, x[2]};
}

/// A bar with its far end moved on an arc tangent to the held end; the end rotates about the only point that
/// gives this motion.
inline Scene bent_bar(int dimension, int cells, double angle) {
  Scene scene = straight_bar(dimension, cells);
  hold_face(scene, 0, false);
  const Vec3 rest{bar_length, bar_height / 2, 0}, end = on_arc(rest, angle);
  const double cot = 1 / std::tan(angle / 2);
  Turn turn;
  turn.angle = angle;
  turn.about = {0.5 * (rest[0] + end[0] - cot * (end[1] - rest[1])),
                0.5 * (rest[1] + end[1] + cot * (end[0] - rest[0])), 0};
  turn_face(scene, true, turn);
  return scene;
}

/// A bar with its far end rotated about the bar's axis.
inline Scene twisted_bar(int cells, double angle) {
  Scene scene = straight_bar(3, cells);
  hold_face(scene, 0, false);
  Turn turn;
  turn.axis = {1, 0, 0};
  turn.angle = angle;
  turn.about = {bar_length, bar_height / 2, bar_height / 2};
  turn_face(scene, true, turn);
  return scene;
}

/// E I angle^2 / (2 L) of a bar with square section (2D: per metre) [J].
inline double beam_energy(const Scene& scene, double angle) {
  const double inertia = std::pow(bar_height, scene.dimension() + 1) / 12;
  return 10e3 * inertia * angle * angle / (2 * bar_length);
}

/// Largest distance of a node from its position on the arc [m].
inline double distance_from_arc(const Scene& scene, const Displacement& u, double angle) {
  double largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node)), there = on_arc(x, angle);
    double square = 0;
    for (int b = 0; b < scene.dimension(); ++b) {
      const auto i = std::size_t(b);
      square += std::pow(x[i] + u(b, node) - there[i], 2);
    }
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

} // namespace maille::test
