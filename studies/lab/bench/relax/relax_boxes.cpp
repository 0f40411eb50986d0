#include "bench/relax/relax.hpp"
#include "bench/relax/relax_case.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace maille::lab {

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

namespace {

/// Iterations of `coupled` on a scene of the repository without limits: what is asked is the elastic solve.
std::int64_t iterations_on(const std::string& file, const BenchOptions& options, BenchReport& report) {
  Scene scene = read_scene(std::filesystem::path(MAILLE_SCENES) / file);
  scene.limits.from = LimitSource::none;
  scene.relaxation.tolerance = options.quick ? 1e-1 : 1e-3;
  const auto [answer, runs] =
      median_answer(options.quick, [&] { return deform::solve(scene, "coupled", report.one_thread()); });
  report.add({{"body", file},
              {"cells", scene.specimen.n_matter_cells()},
              {"tolerance", scene.relaxation.tolerance},
              {"setup_s", answer.seconds.setup},
              {"solve_s", answer.seconds.solve},
              {"iterations", answer.iterations},
              {"bytes_per_grid_point",
               static_cast<double>(answer.bytes) / static_cast<double>(scene.specimen.grid.n_nodes())},
              {"way", answer.algorithm}});
  return answer.iterations;
}

} // namespace

void bench_muscles(const BenchOptions& options, BenchReport& report, RelaxFigures& figures) {
  const bool has_image = has_data("calf_mri/labels.nii.gz");
  figures.muscle = has_image ? "calf_soleus.toml" : "muscle_belly.toml";
  figures.muscle_iterations = iterations_on(figures.muscle, options, report);
  if (has_image)
    figures.leg_iterations = iterations_on("calf_both_legs.toml", options, report);
  else
    report.notes.emplace_back("iterations_leg_over_box omitted: MAILLE_DATA names no folder with "
                              "calf_mri/labels.nii.gz; iterations_muscle_over_box is of muscle_belly.toml.");
}

} // namespace maille::lab
