#include "bench/relax/relax_boxes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::studies {

namespace {

constexpr double side = 64e-3, move = 0.05e-3; // m

} // namespace

BoxQuestion isotropic_box(BoxLoad load, double poisson_ratio) {
  return {load, fmt::format("nu {:g}", poisson_ratio), ElasticConstants::isotropic(10e3, poisson_ratio)};
}

BoxQuestion fibrous_box(BoxLoad load) {
  return {load, "fibre 10", ElasticConstants::transversely_isotropic(100e3, 10e3, 4e3, 0.3, 0.3)};
}

Scene box_scene(const BoxQuestion& question, int cells) {
  Scene scene;
  scene.name = scene.title = question.load_name() + ", " + question.material;
  const double h = side / cells;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, {cells, cells, cells}, {h, h, h});
  const double angle = std::numbers::pi / 6;
  scene.specimen.fibre = {std::cos(angle), 0, std::sin(angle)};
  Material material;
  material.name = question.material;
  material.elasticity = question.elasticity;
  scene.materials = {material};
  const Grid& grid = scene.specimen.grid;
  const bool is_poke = question.load == BoxLoad::poke;
  const int first = is_poke ? 3 * cells / 8 : 0, last = is_poke ? 5 * cells / 8 : cells;
  for (int b = 0; b < 3; ++b) { // sorted by component, then node
    for (int y = 0; y <= cells; ++y)
      for (int x = 0; x <= cells; ++x)
        scene.prescribed.push_back({grid.node({x, y, 0}), b, 0, true});
    for (int y = first; y <= last; ++y)
      for (int x = first; x <= last; ++x)
        scene.prescribed.push_back(
            {grid.node({x, y, cells}), b, b < 2 ? 0 : (is_poke ? -move : move), false});
  }
  return scene;
}

Scene with_wide_limits(Scene scene) {
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch.fill(3);
  scene.limits.given.compress.fill(0.01);
  for (auto& row : scene.limits.given.shear)
    row.fill(3);
  return scene;
}

std::string nodes_in_words(const Scene& scene) {
  return fmt::format("{}^3", scene.specimen.grid.nodes()[0]);
}

} // namespace maille::studies
