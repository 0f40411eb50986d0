#include "bench/materials/materials.hpp"

#include "maille/materials/library.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::lab {

namespace {

constexpr int cells_per_tissue = 4;
constexpr double spacing = 1e-3, angle = std::numbers::pi / 6;

/// A bar of all tissues one after the other, their fibres turned, one end held, the other moved by a percent.
Scene bar() {
  Scene scene;
  scene.name = scene.title = "bar of all tissues";
  for (const LibraryEntry& entry : material_library())
    scene.materials.push_back(entry.material);
  const int cells = cells_per_tissue * static_cast<int>(scene.materials.size());
  Specimen& body = scene.specimen;
  body.shape = "box";
  body.grid = Grid(1, {cells, 1, 1}, {spacing, spacing, spacing});
  body.fibre = {std::cos(angle), 0, std::sin(angle)};
  for (int cell = 0; cell < cells; ++cell)
    body.material_id.push_back(static_cast<std::uint8_t>(cell / cells_per_tissue));
  scene.prescribed = {{0, 0, 0, true}, {cells, 0, 0.01 * cells * spacing, false}};
  scene.limits.from = LimitSource::taut;
  return scene;
}

/// Largest difference from the elastic bar, whose cells stretch by what they give way, over the move.
double error_of(const Scene& scene, const Displacement& u) {
  std::vector<double> reach{0};
  for (const std::uint8_t id : scene.specimen.material_id)
    reach.push_back(reach.back() + 1 / off_axis_pull(scene.materials[id].elasticity, angle).youngs_modulus);
  double worst = 0;
  for (std::size_t node = 0; node < reach.size(); ++node)
    worst = std::max(worst, std::abs(u(0, static_cast<std::int64_t>(node)) / scene.largest_prescribed() -
                                     reach[node] / reach.back()));
  return worst;
}

} // namespace

void bench_taut_bar(MaterialsBench& bench) {
  const Scene scene = bar();
  for (const char* method : {"limits", "relaxed", "coupled", "fem_q1"}) {
    bench.at(0, method);
    const double error = error_of(scene, bench.displacement(scene, method));
    bench.report().rows.push_back({{"bar", "all tissues in series, fibres at 30 deg"},
                                   {"cells", scene.specimen.grid.n_cells()},
                                   {"method", method},
                                   {"error_over_move", error}});
    if (method == std::string_view("limits"))
      bench.report().checks.push_back({"taut_bar_error", error}); // rounding of float64
  }
}

} // namespace maille::lab
