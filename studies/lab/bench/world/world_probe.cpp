#include "bench/subjects.hpp"
#include "probe/probe_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::lab {

namespace {

constexpr double spacing = 1e-3; // [m]

/// An elastic cube that stands on the floor of its own coordinates, held there.
Scene cube(int cells) {
  Scene scene;
  scene.name = scene.title = "cube";
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, {cells, cells, cells}, {spacing, spacing, spacing});
  Material material;
  material.name = "soft";
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  scene.materials = {material};
  scene.relaxation.tolerance = 1e-2;
  const Grid& grid = scene.specimen.grid;
  for (int component = 0; component < 3; ++component)
    for (int y = 0; y < grid.nodes()[1]; ++y)
      for (int x = 0; x < grid.nodes()[0]; ++x)
        scene.prescribed.push_back({grid.node({x, y, 0}), component, 0, true});
  return scene;
}

/// Down from above, in circles that widen over the top, and up again.
deform::RecordedMotion circles(int cells, double seconds) {
  const double size = cells * spacing, above = size + 2 * spacing, below = size - 2 * spacing;
  std::vector<deform::RecordedMotion::Sample> samples;
  const int n = static_cast<int>(50 * seconds);
  for (int i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / n, angle = 2 * std::numbers::pi * seconds * t;
    const double radius = 0.4 * size * t, z = t < 0.05 || t > 0.95 ? above : below;
    samples.push_back({seconds * t, deform::Pose{.position = {0.5 * size + radius * std::cos(angle),
                                                              0.5 * size + radius * std::sin(angle), z}}});
  }
  return deform::RecordedMotion(std::move(samples));
}

} // namespace

std::int64_t report_probe(bool quick, BenchReport& report) {
  const int cells = quick ? 15 : 99;
  const deform::ProbedWorld world(cube(cells), 2 * spacing);
  ProbeRunSettings settings;
  settings.hand.damping = 0.5;
  const ProbeRun run = run_probe(world, circles(cells, quick ? 1 : 10), settings);
  const auto microseconds = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
  const auto& latency = run.servo.latency;
  report.add(
      {{"probe", fmt::format("a point on an elastic cube of {}^3 nodes, coupled beside it", cells + 1)},
       {"ticks", run.servo.ticks},
       {"median_us", microseconds(latency.quantile(0.5))},
       {"p99_us", microseconds(latency.quantile(0.99))},
       {"p999_us", microseconds(latency.quantile(0.999))},
       {"largest_us", microseconds(latency.largest())},
       {"work_p999_us", microseconds(run.servo.work.quantile(0.999))},
       {"missed_deadlines", run.servo.missed},
       {"real_time_priority", run.servo.had_priority ? "yes" : "no"},
       {"answers", run.answers},
       {"slowest_answer_s", run.slowest_answer}});
  report.checks.push_back(
      {"probe_p999_ms", 1e-6 * static_cast<double>(latency.quantile(0.999)),
       "0.1: the arithmetic takes 5 us, the rest is waking up",
       "from when a tick was due until its force was written, so the system's waking up is in it"});
  return run.inside;
}

} // namespace maille::lab
