#pragma once
/// Named bodies that are difficult for propagation, shared by tests and the laboratory.

#include "maille/scene/scene.hpp"

#include <cmath>
#include <random>
#include <string_view>
#include <vector>

namespace maille {

namespace named_bodies_parts {

inline constexpr int n_scales = 254; // materials; numbers have 8 bits, and 255 marks empty cells

inline Material material_with_slack(double scale) {
  Material material;
  material.name = "slack scaled by " + std::to_string(scale);
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  NeighbourLimits limits;
  limits.stretch.fill(1 + 0.4 * scale);
  limits.compress.fill(1 - 0.25 * scale);
  for (auto& row : limits.shear)
    row.fill(0.15 * scale);
  material.limits = limits;
  return material;
}

/// The material with about that scale; @param scale from 0 to 1
inline std::uint8_t material_number(double scale) {
  return static_cast<std::uint8_t>(std::lround(scale * n_scales) - 1);
}

/// Sets a body's cells by a function of their position.
template<class Of>
void set_cells(Specimen& body, const Of& of) {
  body.material_id.resize(static_cast<std::size_t>(body.grid.n_cells()));
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.material_id[static_cast<std::size_t>(cell)] = of(body.grid.cell_at(cell));
}

inline void make_bore(Specimen& body) {
  const Index3& cells = body.grid.cells();
  const double radius = 0.2 * cells[0];
  set_cells(body, [&](const Index3& at) {
    const double x = at[0] - 0.5 * cells[0], y = at[1] - 0.5 * cells[1];
    const bool is_bore = std::hypot(x, y) < radius && at[2] < cells[2] * 3 / 4;
    const bool is_slot = y > 0 && std::abs(at[0] - cells[0] / 2) <= 1;
    return is_bore || is_slot ? no_material : std::uint8_t{0};
  });
}

} // namespace named_bodies_parts

/// random   every cell's slack is scaled by its own random number from 0.05 to 1
/// checker  blocks of 8 cells a side, slack scaled by 1 and by 0.1 in turn
/// bore     one material; a bore through three quarters of the height, joined to a slot from one side
/// smooth   slack scaled by a smooth function of the position, 0.05 to 0.55
inline const std::vector<std::string_view>& named_bodies() {
  static const std::vector<std::string_view> names{"random", "checker", "bore", "smooth"};
  return names;
}

/// A cube of n x n x n nodes, 1 m apart, with limits of the materials: unscaled stretch 1.4, compress 0.75,
/// shear 0.15, so paths differ between components. The node at (n / 5, n / 5, 0) is moved by (0.6, -0.8,
/// -0.8) n m, far enough to move every node.
///
/// @param name one of named_bodies(); @param n >= 8
/// Repeatable: same arguments, same bits
inline Scene named_body(std::string_view name, int n) {
  Scene scene;
  scene.name = scene.title = std::string(name);
  scene.limits.from = LimitSource::material;
  Specimen& body = scene.specimen;
  body.shape = "box";
  body.grid = Grid(3, {n - 1, n - 1, n - 1}, {1, 1, 1});
  if (name == "bore") {
    scene.materials = {named_bodies_parts::material_with_slack(1)};
    named_bodies_parts::make_bore(body);
  } else {
    for (int i = 1; i <= named_bodies_parts::n_scales; ++i)
      scene.materials.push_back(
          named_bodies_parts::material_with_slack(static_cast<double>(i) / named_bodies_parts::n_scales));
    std::mt19937 random(5);
    if (name == "random")
      named_bodies_parts::set_cells(body, [&](const Index3&) {
        return named_bodies_parts::material_number(0.05 + 0.95 * static_cast<double>(random()) /
                                                              static_cast<double>(random.max()));
      });
    else if (name == "checker")
      named_bodies_parts::set_cells(body, [](const Index3& at) {
        return named_bodies_parts::material_number((at[0] / 8 + at[1] / 8 + at[2] / 8) % 2 == 1 ? 1 : 0.1);
      });
    else
      named_bodies_parts::set_cells(body, [](const Index3& at) {
        return named_bodies_parts::material_number(0.3 + 0.25 * std::sin(0.07 * at[0]) *
                                                             std::cos(0.05 * at[1] + 0.06 * at[2]));
      });
  }
  const std::int64_t handle = body.grid.node({n / 5, n / 5, 0});
  const Vec3 by{0.6 * n, -0.8 * n, -0.8 * n};
  for (int b = 0; b < 3; ++b)
    scene.prescribed.push_back({handle, b, by[static_cast<std::size_t>(b)], false});
  return scene;
}

} // namespace maille
