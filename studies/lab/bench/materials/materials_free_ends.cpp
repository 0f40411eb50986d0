#include "bench/materials/materials.hpp"

#include "maille/materials/library.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::lab {

namespace {

/// A box pulled at both ends by a stress that strains it by about a percent, three points kept from moving as
/// a body: any uniform strain is free to come about.
Scene free_ended_box(const std::string& tissue, double degrees, double traction) {
  return parse_scene(
      fmt::format(
          "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [8, 4, 4]\nspacing = \"1 mm\"\nmaterial "
          "= \"{}\"\n"
          "fibre = {{ angle = \"{} deg\", plane = \"xz\" }}\n"
          "[[hold]]\nwhere = {{ box = [[0, 0, 0], [0, 0, 0]] }}\n"
          "[[hold]]\nwhere = {{ box = [[0, 0.004, 0], [0, 0.004, 0]] }}\naxes = \"xz\"\n"
          "[[hold]]\nwhere = {{ box = [[0, 0, 0.004], [0, 0, 0.004]] }}\naxes = \"x\"\n"
          "[[load]]\nwhere = \"x+\"\ntraction = [{}, 0, 0]\n[[load]]\nwhere = \"x-\"\ntraction = [{}, 0, 0]\n"
          "[limits]\nfrom = \"taut\"\n[relaxation]\ntolerance = 1e-6\n",
          tissue, degrees, traction, -traction),
      fmt::format("{} at {} deg.toml", tissue, degrees));
}

/// What the box did, from where the far end's lowest corner went: the near end's plane is kept in its place.
OffAxisPull measured(const Scene& scene, const Displacement& u, double traction) {
  const Grid& grid = scene.specimen.grid;
  const std::int64_t corner = grid.node({grid.cells()[0], 0, 0});
  return {traction * 0.008 / u(0, corner), u(2, corner) / u(0, corner)};
}

} // namespace

void bench_free_ends(MaterialsBench& bench, double start, double end) {
  double worst = 0;
  double done = 0;
  for (const LibraryEntry& entry : material_library()) {
    double worst_modulus = 0, worst_coupling = 0, coupled_worst = 0;
    bench.at(start + (end - start) * done++ / static_cast<double>(material_library().size()),
             entry.material.name);
    for (const double degrees : {0.0, 20.0, 45.0, 70.0, 90.0}) {
      const OffAxisPull exact = off_axis_pull(entry.material.elasticity, degrees * std::numbers::pi / 180);
      const double traction = 0.01 * exact.youngs_modulus;
      const Scene scene = free_ended_box(entry.material.name, degrees, traction);
      // The coupling is compared as strain over strain: it passes through 0.
      const auto errors = [&](std::string_view method) {
        const OffAxisPull found = measured(scene, bench.displacement(scene, method), traction);
        return std::pair{std::abs(found.youngs_modulus / exact.youngs_modulus - 1),
                         std::abs(found.shear_coupling - exact.shear_coupling) /
                             std::max(1.0, std::abs(exact.shear_coupling))};
      };
      const auto [modulus, coupling] = errors("fem_q1");
      worst_modulus = std::max(worst_modulus, modulus);
      worst_coupling = std::max(worst_coupling, coupling);
      const auto [ours, our_coupling] = errors("coupled");
      coupled_worst = std::max({coupled_worst, ours, our_coupling});
    }
    bench.report().rows.push_back({{"tissue_with_free_ends", entry.material.name},
                                   {"angles", "0 20 45 70 90"},
                                   {"fem_q1_modulus_error", worst_modulus},
                                   {"fem_q1_coupling_error", worst_coupling},
                                   {"coupled_worse_of_both", coupled_worst}});
    worst = std::max({worst, worst_modulus, worst_coupling});
  }
  bench.report().checks.push_back({"fem_offaxis_error_worst", worst});
}

} // namespace maille::lab
