#include "maille/scene/named_bodies.hpp"

#include <cmath>
#include <random>

namespace maille {

namespace {

constexpr int n_scales = 254; // materials; numbers are 8 bits and 255 is no matter

Material material_with_slack(double scale) {
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
std::uint8_t material_number(double scale) {
  return static_cast<std::uint8_t>(std::lround(scale * n_scales) - 1);
}

/// Fills a body's cells by a function of their position.
template<class Of>
void set_cells(Specimen& body, const Of& of) {
  body.material_id.resize(static_cast<std::size_t>(body.grid.n_cells()));
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.material_id[static_cast<std::size_t>(cell)] = of(body.grid.cell_at(cell));
}

void make_bore(Specimen& body) {
  const Index3& cells = body.grid.cells();
  const double radius = 0.2 * cells[0];
  set_cells(body, [&](const Index3& at) {
    const double x = at[0] - 0.5 * cells[0], y = at[1] - 0.5 * cells[1];
    const bool is_bore = std::hypot(x, y) < radius && at[2] < cells[2] * 3 / 4;
    const bool is_slot = y > 0 && std::abs(at[0] - cells[0] / 2) <= 1;
    return is_bore || is_slot ? no_material : std::uint8_t{0};
  });
}

} // namespace

const std::vector<std::string_view>& named_bodies() {
  static const std::vector<std::string_view> names{"random", "checker", "bore", "smooth"};
  return names;
}

Scene named_body(std::string_view name, int n) {
  Scene scene;
  scene.name = scene.title = std::string(name);
  scene.limits.from = LimitSource::material;
  Specimen& body = scene.specimen;
  body.shape = "box";
  body.grid = Grid(3, {n - 1, n - 1, n - 1}, {1, 1, 1});
  if (name == "bore") {
    scene.materials = {material_with_slack(1)};
    make_bore(body);
  } else {
    for (int i = 1; i <= n_scales; ++i)
      scene.materials.push_back(material_with_slack(static_cast<double>(i) / n_scales));
    std::mt19937 random(5);
    if (name == "random")
      set_cells(body, [&](const Index3&) {
        return material_number(0.05 +
                               0.95 * static_cast<double>(random()) / static_cast<double>(random.max()));
      });
    else if (name == "checker")
      set_cells(body, [](const Index3& at) {
        return material_number((at[0] / 8 + at[1] / 8 + at[2] / 8) % 2 == 1 ? 1 : 0.1);
      });
    else
      set_cells(body, [](const Index3& at) {
        return material_number(0.3 + 0.25 * std::sin(0.07 * at[0]) * std::cos(0.05 * at[1] + 0.06 * at[2]));
      });
  }
  const std::int64_t handle = body.grid.node({n / 5, n / 5, 0});
  const Vec3 by{0.6 * n, -0.8 * n, -0.8 * n};
  for (int b = 0; b < 3; ++b)
    scene.prescribed.push_back({handle, b, by[static_cast<std::size_t>(b)], false});
  return scene;
}

} // namespace maille
