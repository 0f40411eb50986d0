#include "bench/materials.hpp"

#include "maille/materials/library.hpp"
#include "maille/scene/compare.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace maille::studies {

namespace {

constexpr double goal = 0.02;

/// A strip clamped at one end and pulled at the other by a small part of its length.
Scene pulled_strip(const std::string& tissue, double degrees, int across) {
  return parse_scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{0}, {1}, {1}]\nspacing = {2}\nmaterial = \"{3}\"\n"
                  "fibre = {{ angle = \"{4} deg\", plane = \"xz\" }}\n[[hold]]\nwhere = "
                  "\"x-\"\n[[move]]\nwhere = \"x+\"\n"
                  "by = [\"1 mm\", 0, 0]\n[limits]\nfrom = \"taut\"\n[relaxation]\ntolerance = 1e-5\n",
                  2 * across, across, 0.016 / across, tissue, degrees),
      fmt::format("{} at {} deg.toml", tissue, degrees));
}

struct Pull {
  double degrees = 0, coupled_against_q1 = 0;
};

Pull measured_pull(MaterialsBench& bench, const std::string& tissue, double degrees, int across) {
  const Scene scene = pulled_strip(tissue, degrees, across);
  return {
      degrees,
      compare(scene, bench.displacement(scene, "coupled"), bench.displacement(scene, "fem_q1")).relative_l2};
}

/// Both methods against quadratic elements on the same mesh; and, where `is_fine`, against those on a mesh of half the spacing, whose own
/// linear elements are compared, too: does the difference go as the mesh is refined?
void add_witness(MaterialsBench& bench, const std::string& tissue, double degrees, int across, bool is_fine) {
  const Scene scene = pulled_strip(tissue, degrees, across);
  const Displacement coupled = bench.displacement(scene, "coupled"), q1 = bench.displacement(scene, "fem_q1");
  const auto row = [&](const char* reference, const Displacement& truth, std::optional<double> q2,
                       std::optional<double> finer) {
    nlohmann::ordered_json r{{"tissue_and_witness", tissue},
                             {"fibre_deg", degrees},
                             {"witness", reference},
                             {"coupled_error", compare(scene, coupled, truth).relative_l2},
                             {"fem_q1_error", compare(scene, q1, truth).relative_l2}};
    r["fem_q2_error"] = q2 ? nlohmann::ordered_json(*q2) : nlohmann::ordered_json("-");
    r["coupled_against_q1_half_spacing"] =
        finer ? nlohmann::ordered_json(*finer) : nlohmann::ordered_json("-");
    bench.report().rows.push_back(std::move(r));
  };
  const Displacement q2 = bench.displacement(scene, "fem_q2");
  row("fem_q2", q2, std::nullopt, std::nullopt);
  if (!is_fine)
    return;
  const Scene fine = refined(scene);
  const Displacement truth = at_coarse_nodes(scene, fine, bench.displacement(fine, "fem_q2"));
  const double finer =
      compare(fine, bench.displacement(fine, "coupled"), bench.displacement(fine, "fem_q1")).relative_l2;
  row("fem_q2, half the spacing", truth, compare(scene, q2, truth).relative_l2, finer);
}

} // namespace

void bench_off_axis_pulls(MaterialsBench& bench, double start, double end) {
  const int across = bench.is_quick() ? 4 : 16;
  const double n = static_cast<double>(material_library().size());
  double worst = 0, done = 0;
  std::vector<std::pair<std::string, Pull>> worst_of;
  for (const LibraryEntry& entry : material_library()) {
    const std::string& tissue = entry.material.name;
    bench.at(start + 0.5 * (end - start) * done++ / n, tissue);
    nlohmann::ordered_json row{{"tissue_pulled", tissue}, {"cells_across", across}};
    Pull worst_pull;
    std::optional<Pull> same_at_all_angles;
    for (const double degrees : {0.0, 20.0, 45.0, 90.0}) {
      const Pull pull =
          same_at_all_angles ? *same_at_all_angles : measured_pull(bench, tissue, degrees, across);
      if (entry.material.elasticity.is_isotropic())
        same_at_all_angles = pull;
      row[fmt::format("coupled_against_q1_{:.0f}_deg", degrees)] = pull.coupled_against_q1;
      if (pull.coupled_against_q1 > worst_pull.coupled_against_q1)
        worst_pull = pull;
    }
    bench.report().rows.push_back(std::move(row));
    worst_of.emplace_back(tissue, worst_pull);
    worst = std::max(worst, worst_pull.coupled_against_q1);
  }
  done = 0;
  for (const auto& [tissue, pull] : worst_of) {
    bench.at(start + (end - start) * (0.5 + 0.5 * done++ / n), "quadratic elements of " + tissue);
    add_witness(bench, tissue, pull.degrees, across, pull.coupled_against_q1 > goal && !bench.is_quick());
  }
  bench.report().checks.push_back({"coupled_error_worst_tissue", worst, goal, false});
}

} // namespace maille::studies
