#include "bench/subjects.hpp"

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "rivals/lattice_rivals.hpp"

#include <fmt/format.h>

#include <limits>

namespace maille::lab {

void bench_springs(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  const int n = options.quick ? 16 : 64;
  Scene scene = parse_scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{0}, {0}, {0}]\nspacing = \"{1} mm\"\n"
                  "material = {{ youngs_modulus = 10000, poisson_ratio = 0.25 }}\n[[hold]]\nwhere = \"z-\"\n"
                  "[[move]]\nwhere = {{ box = [[\"24 mm\", \"24 mm\", \"64 mm\"], [\"40 mm\", \"40 mm\", "
                  "\"64 mm\"]] }}\nby = [0, 0, \"-0.05 mm\"]\n[relaxation]\ntolerance = 1e-3\n",
                  n, 64.0 / n),
      "poke.toml");
  fem_ref::Options quadratic;
  quadratic.degree = 2;
  quadratic.tolerance = 1e-6;
  const Displacement truth = fem_ref::solve(scene, quadratic, report.one_thread()).answer.displacement;
  Answer coupled = deform::solve(scene, "coupled", report.one_thread()); // the first warms up
  coupled = deform::solve(scene, "coupled", report.one_thread());
  if (report.control.should_stop())
    throw BenchStopped();
  const double seconds = coupled.seconds.total(),
               goal = compare(scene, coupled.displacement, truth).relative_l2;
  report.add(
      {{"springs", "coupled"}, {"budget_s", seconds}, {"time_steps", coupled.iterations}, {"error", goal}});
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 3;
       ++run) { // the best of three: Bullet's steps are few, and the machine has other work
    const std::optional<RivalResult> result = relax_by_bullet(scene, seconds);
    if (!result) {
      report.notes.emplace_back("bullet_error_at_equal_time omitted: built without libbullet.");
      return;
    }
    const double error = result->displacement.empty()
                             ? std::numeric_limits<double>::infinity()
                             : compare(scene, result->displacement, truth).relative_l2;
    least = std::min(least, error);
    report.add(
        {{"springs", "Bullet"}, {"budget_s", seconds}, {"time_steps", result->iterations}, {"error", error}});
  }
  report.checks.push_back({"bullet_error_at_equal_time", least, "",
                           fmt::format("error of coupled: {:.3g}; Bullet's is to be larger", goal), goal});
}

} // namespace maille::lab
