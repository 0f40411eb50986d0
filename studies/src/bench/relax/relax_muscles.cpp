#include "bench/relax/relax.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <cstdlib>
#include <filesystem>

namespace maille::studies {

namespace {

/// Iterations of `coupled` on a scene of the repository without limits: what is asked is the elastic solve.
std::int64_t iterations_on(const std::string& file, const BenchOptions& options, BenchReport& report) {
  Scene scene = read_scene(std::filesystem::path(MAILLE_SCENES) / file);
  scene.limits.from = LimitSource::none;
  scene.relaxation.tolerance = options.quick ? 1e-1 : 1e-3;
  const auto [answer, runs] = median_answer(options.quick, [&] { return deform::solve(scene, "coupled"); });
  report.rows.push_back({{"body", file},
                         {"cells", scene.specimen.n_matter_cells()},
                         {"tolerance", scene.relaxation.tolerance},
                         {"setup_s", answer.seconds.setup},
                         {"solve_s", answer.seconds.solve},
                         {"iterations", answer.iterations},
                         {"bytes_per_grid_point", static_cast<double>(answer.bytes) /
                                                      static_cast<double>(scene.specimen.grid.n_nodes())},
                         {"way", answer.algorithm}});
  return answer.iterations;
}

} // namespace

void bench_muscles(const BenchOptions& options, BenchReport& report, RelaxFigures& figures) {
  const char* const data = std::getenv("MAILLE_DATA");
  const bool has_image =
      data != nullptr && std::filesystem::exists(std::filesystem::path(data) / "calf_mri/labels.nii.gz");
  figures.muscle = has_image ? "calf_soleus.toml" : "muscle_belly.toml";
  figures.muscle_iterations = iterations_on(figures.muscle, options, report);
  if (has_image)
    figures.leg_iterations = iterations_on("calf_both_legs.toml", options, report);
  else
    report.notes.emplace_back("iterations_leg_over_box omitted: MAILLE_DATA names no folder with "
                              "calf_mri/labels.nii.gz; iterations_muscle_over_box is of muscle_belly.toml.");
}

} // namespace maille::studies
