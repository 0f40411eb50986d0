#include "bench/relax/relax.hpp"
#include "compare/comparison.hpp"
#include "maille/deform/solve.hpp"

#include <algorithm>
#include <vector>

namespace maille::lab {

namespace {

/// The poke of scene/scenes/poke_given_limits.toml, an eighth of the side deep.
Scene deeply_poked(int cells, bool is_limited) {
  Scene scene = box_scene(isotropic_box(BoxLoad::poke, 0.3), cells);
  for (Prescribed& p : scene.prescribed)
    if (p.value != 0)
      p.value = -cells * scene.specimen.grid.spacing()[2] / 8;
  scene.relaxation.tolerance = 1e-2;
  if (is_limited) {
    scene.limits.from = LimitSource::given;
    scene.limits.given.stretch.fill(1.25);
    scene.limits.given.compress.fill(0.75);
    for (auto& row : scene.limits.given.shear)
      row.fill(0.125);
  }
  return scene;
}

/// Total seconds of `coupled` as `compare` answers, set-up included.
double coupled_seconds(const Scene& scene) {
  return compare_methods(scene, {"coupled"}, "", {}).rows.front().answer.seconds.total();
}

/// What a scene costs that says nothing of limits, over the same with limits that are known and far away: in
/// turn, so that both have the same machine.
double default_over_wide(int cells, bool is_quick) {
  Scene plain = box_scene(isotropic_box(BoxLoad::poke, 0.3), cells);
  plain.relaxation.tolerance = 1e-3;
  const Scene wide = with_wide_limits(plain);
  std::vector<double> of_plain, of_wide;
  coupled_seconds(plain); // pages and caches
  for (int run = 0; run < (is_quick ? 1 : 9); ++run) {
    of_plain.push_back(coupled_seconds(plain));
    of_wide.push_back(coupled_seconds(wide));
  }
  const auto median = [](std::vector<double>& seconds) {
    std::ranges::nth_element(seconds, seconds.begin() + std::ssize(seconds) / 2);
    return seconds[seconds.size() / 2];
  };
  return median(of_plain) / median(of_wide);
}

} // namespace

void bench_limits(const BenchOptions& options, BenchReport& report, RelaxFigures& figures) {
  const int cells = RelaxSizes::of(options).middle;
  const Scene limited = deeply_poked(cells, true), elastic = deeply_poked(cells, false);
  const auto run = [&](const Scene& scene) {
    return median_answer(options.quick, [&] { return deform::solve(scene, "coupled", report.one_thread()); })
        .first;
  };
  const Answer of_elastic = run(elastic), of_limited = run(limited);
  figures.default_over_wide = default_over_wide(cells, options.quick);
  report.add({{"limits", "none in the scene over given and wide"},
              {"nodes", nodes_in_words(limited)},
              {"default_over_wide", figures.default_over_wide}});
  const LinkLimits limits(limited);
  figures.limits_active_over_elastic = of_limited.seconds.total() / of_elastic.seconds.total();
  report.add({{"limits", "poke by an eighth, stretch 1.25, shear 0.125"},
              {"nodes", nodes_in_words(limited)},
              {"elastic_s", of_elastic.seconds.total()},
              {"limited_s", of_limited.seconds.total()},
              {"elastic_breaks_limits_by", largest_violation(elastic, limits, of_elastic.displacement)},
              {"limited_breaks_limits_by", largest_violation(limited, limits, of_limited.displacement)},
              {"message", of_limited.message}});
}

} // namespace maille::lab
