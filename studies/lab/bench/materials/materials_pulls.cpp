#include "bench/materials/materials.hpp"

#include "maille/materials/library.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::lab {

namespace {

constexpr double goal = 0.02;
constexpr std::array<double, 4> angles{0, 20, 45, 90};

/// Where a pull is asked: in 3D the strip has 16 cells along y, which the fibres are across, whatever it has
/// along z; in 2D it is the same strip in plane strain.
struct Mesh {
  int dimension = 3, across = 16;
};
constexpr int cells_along_y = 16;

/// From coarse to fine. Where 16 cells across are too few for linear elements, for whatever reason, both
/// methods are asked on finer ones, until they agree or cannot be afforded.
constexpr std::array<Mesh, 6> ladder{{{3, 16}, {3, 32}, {3, 64}, {2, 128}, {2, 256}, {2, 384}}};
constexpr std::array<Mesh, 2> quick_ladder{{{3, 4}, {2, 8}}};

/// A strip clamped at one end and pulled at the other by a small part of its length.
Scene pulled_strip(const std::string& tissue, double degrees, const Mesh& mesh) {
  const bool is_flat = mesh.dimension == 2;
  const int along_y = std::min(cells_along_y, mesh.across);
  const double width = 0.016, h = width / mesh.across;
  const std::string grid =
      is_flat ? fmt::format("cells = [{}, {}]\nspacing = {}", 2 * mesh.across, mesh.across, h)
              : fmt::format("cells = [{}, {}, {}]\nspacing = [{}, {}, {}]", 2 * mesh.across, along_y,
                            mesh.across, h, width / along_y, h);
  return parse_scene(
      fmt::format("units = \"m, rad\"\n[specimen]\nshape = \"box\"\n{}\nmaterial = \"{}\"\n"
                  "fibre = {{ angle = \"{} deg\", plane = \"{}\" }}\n[[hold]]\nwhere = "
                  "\"x-\"\n[[move]]\nwhere = \"x+\"\n"
                  "by = [\"1 mm\", 0{}]\n[limits]\nfrom = \"taut\"\n[relaxation]\ntolerance = 1e-5\n",
                  grid, tissue, degrees, is_flat ? "xy" : "xz", is_flat ? "" : ", 0"),
      fmt::format("{} at {} deg.toml", tissue, degrees));
}

/// What a tissue comes to at one angle.
struct Pull {
  double degrees = 0, coupled_against_q1 = 0;
  Mesh mesh; ///< the coarsest on which it is within the goal, else the finest
};

double difference_on(MaterialsBench& bench, const std::string& tissue, double degrees, const Mesh& mesh) {
  const Scene scene = pulled_strip(tissue, degrees, mesh);
  return compare(scene, bench.displacement(scene, "coupled"), bench.displacement(scene, "fem_q1"))
      .relative_l2;
}

/// A row for every mesh; each angle only until it is within the goal.
std::vector<Pull> measured_pulls(MaterialsBench& bench, const LibraryEntry& entry) {
  const std::string& tissue = entry.material.name;
  const bool is_isotropic = entry.material.elasticity.is_isotropic();
  std::vector<Pull> pulls;
  for (const double degrees : angles)
    pulls.push_back({degrees, std::numeric_limits<double>::infinity(), {}});
  const std::span<const Mesh> meshes = bench.is_quick() ? std::span<const Mesh>(quick_ladder) : ladder;
  for (const Mesh& mesh : meshes) {
    nlohmann::ordered_json row{
        {"tissue_pulled", tissue}, {"dimension", mesh.dimension}, {"cells_across", mesh.across}};
    bool is_asked = false;
    for (Pull& pull : pulls) {
      const std::string key = fmt::format("coupled_against_q1_{:.0f}_deg", pull.degrees);
      row[key] = "-";
      if (pull.coupled_against_q1 <= goal)
        continue;
      if (is_isotropic && is_asked)
        pull.coupled_against_q1 = pulls.front().coupled_against_q1;
      else
        pull.coupled_against_q1 = difference_on(bench, tissue, pull.degrees, mesh);
      pull.mesh = mesh;
      row[key] = pull.coupled_against_q1;
      is_asked = true;
    }
    if (is_asked)
      bench.report().rows.push_back(std::move(row));
  }
  return pulls;
}

/// Both methods against quadratic elements on the same mesh, and what those are off quadratic elements on
/// half the spacing where that can be afforded: who is right, and is the judge?
void add_witness(MaterialsBench& bench, const std::string& tissue, double degrees, const Mesh& mesh,
                 bool is_fine) {
  const Scene scene = pulled_strip(tissue, degrees, mesh);
  const Displacement coupled = bench.displacement(scene, "coupled"), q1 = bench.displacement(scene, "fem_q1"),
                     q2 = bench.displacement(scene, "fem_q2");
  const auto row = [&](const char* witness, const Displacement& truth) {
    nlohmann::ordered_json r{{"tissue_and_witness", tissue},
                             {"fibre_deg", degrees},
                             {"dimension", mesh.dimension},
                             {"cells_across", mesh.across},
                             {"witness", witness},
                             {"coupled_error", compare(scene, coupled, truth).relative_l2},
                             {"fem_q1_error", compare(scene, q1, truth).relative_l2}};
    r["fem_q2_error"] = &truth == &q2 ? nlohmann::ordered_json("-")
                                      : nlohmann::ordered_json(compare(scene, q2, truth).relative_l2);
    bench.report().rows.push_back(std::move(r));
  };
  row("fem_q2", q2);
  if (!is_fine)
    return;
  const Scene fine = refined(scene);
  row("fem_q2, half the spacing", at_coarse_nodes(scene, fine, bench.displacement(fine, "fem_q2")));
}

/// At the worst angle: on the first mesh, and where that was too coarse on some of those that followed, as
/// far as quadratic elements can be afforded there.
void add_witnesses(MaterialsBench& bench, const std::string& tissue, const Pull& worst) {
  if (bench.is_quick()) {
    add_witness(bench, tissue, worst.degrees, quick_ladder.front(), false);
    return;
  }
  const Mesh first = ladder.front();
  const bool is_refined = worst.mesh.across > first.across;
  add_witness(bench, tissue, worst.degrees, first, is_refined);
  if (!is_refined)
    return;
  for (const int across : {16, 32, 64, 128})
    add_witness(bench, tissue, worst.degrees, {2, across}, across <= 64);
}

} // namespace

void bench_off_axis_pulls(MaterialsBench& bench, double start, double end) {
  const double n = static_cast<double>(material_library().size());
  double worst = 0, done = 0;
  std::string where;
  std::vector<std::pair<std::string, Pull>> worst_of;
  for (const LibraryEntry& entry : material_library()) {
    const std::string& tissue = entry.material.name;
    bench.at(start + 0.5 * (end - start) * done++ / n, tissue);
    Pull worst_pull; // the finest mesh, then the largest difference
    for (const Pull& pull : measured_pulls(bench, entry)) {
      if (std::tuple(pull.mesh.dimension == 2, pull.mesh.across, pull.coupled_against_q1) >=
          std::tuple(worst_pull.mesh.dimension == 2, worst_pull.mesh.across, worst_pull.coupled_against_q1))
        worst_pull = pull;
      if (pull.coupled_against_q1 > worst) {
        worst = pull.coupled_against_q1;
        where = fmt::format("{} at {} deg on {} cells across in {}D", tissue, pull.degrees, pull.mesh.across,
                            pull.mesh.dimension);
      }
    }
    worst_of.emplace_back(tissue, worst_pull);
  }
  done = 0;
  for (const auto& [tissue, pull] : worst_of) {
    bench.at(start + (end - start) * (0.5 + 0.5 * done++ / n), "quadratic elements of " + tissue);
    add_witnesses(bench, tissue, pull);
  }
  bench.report().notes.push_back(
      "coupled_error_worst_tissue is of " + where +
      "; every tissue and angle counts on the coarsest mesh of its rows that brings it "
      "within the goal, else on the finest");
  bench.report().checks.push_back({"coupled_error_worst_tissue", worst});
}

} // namespace maille::lab
