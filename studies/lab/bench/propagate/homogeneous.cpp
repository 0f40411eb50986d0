#include "bench/subjects.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "median.hpp"
#include "rivals/gibson_box.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

namespace maille::lab {

namespace {

using deform::Drag;

constexpr double slack = 0.25; // of every link, along and across: dyadic, so that sums are exact

/// A cube of n^3 nodes, 1 m apart, of one material with that slack; nothing held, nothing moved.
Scene homogeneous_cube(int n) {
  Scene scene;
  scene.name = scene.title = "homogeneous";
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch.fill(1 + slack);
  scene.limits.given.compress.fill(1 - slack);
  for (auto& row : scene.limits.given.shear)
    row.fill(slack);
  Material material;
  material.name = "slack";
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  scene.materials = {material};
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, {n - 1, n - 1, n - 1}, {1, 1, 1});
  return scene;
}

/// Medians of the wall-clock seconds of several works that take turns, so that a neighbour's load hits all of
/// them; each is done `in_a_row` times at its turn, as by a hand that drags on, and its mean counts.
std::vector<double> interleaved_medians(int repeats, int in_a_row,
                                        const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> seconds(works.size());
  for (int run = 0; run <= repeats; ++run)
    for (std::size_t w = 0; w < works.size(); ++w) {
      const auto start = std::chrono::steady_clock::now();
      for (int time = 0; time < in_a_row; ++time)
        works[w]();
      const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
      if (run > 0) // the first allocates and warms up
        seconds[w].push_back(wall.count() / in_a_row);
    }
  std::vector<double> medians;
  for (const auto& of_work : seconds)
    medians.push_back(upper_median(of_work));
  return medians;
}

/// One handle dragged to and fro, by `by` about home: a drag from one end moves every node that the other end
/// moved.
template<class Body>
std::function<void()> to_and_fro(Body& body, std::int64_t handle, Vec3 by) {
  return [&body, handle, by]() mutable {
    body.move_to(handle, by);
    for (double& component : by)
      component = -component;
  };
}

/// Several handles the same way, at values that their links permit.
std::function<void()> to_and_fro(Drag& drag, const Grid& grid, int handles, double by) {
  std::mt19937 random(11);
  std::vector<std::int64_t> nodes;
  while (static_cast<int>(nodes.size()) < handles)
    if (const auto node = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(grid.n_nodes()));
        std::ranges::find(nodes, node) == nodes.end())
      nodes.push_back(node);
  std::vector<Drag::Move> there, back;
  for (const std::int64_t node : nodes) {
    const Index3 at = grid.node_at(node);
    const double tilt = slack / 8 * (at[0] - at[1] + at[2]);
    there.push_back({node, {by + tilt, -by + tilt, by - tilt}});
    back.push_back({node, {-by + tilt, by + tilt, -by - tilt}});
  }
  return [&drag, there = std::move(there), back = std::move(back), is_there = false]() mutable {
    drag.move_to(is_there ? back : there);
    is_there = !is_there;
  };
}

int all_threads() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

double gb_per_s(double coordinates, double seconds) {
  return 2 * 4 * coordinates / seconds / 1e9; // float32, read and written once
}

struct WholeBody {
  double literal = 0, packed = 0; ///< seconds: Gibson's chain mail, as published and in its best form
  double one = 0, all = 0;        ///< seconds: limits, on one thread and on all
  double copy = 0;                ///< [GB/s]
};

/// Whole-body drags of a cube, with the copy bandwidth of arrays of its size between them.
WholeBody time_whole_body(int n, int repeats, bool is_largest, BenchReport& report, bool& bits_are_equal) {
  const bool with_literal = n <= 128;
  const Scene scene = homogeneous_cube(n);
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  const std::int64_t handle = grid.node({n / 2, n / 2, 0});
  const Vec3 by{1.0 * n, -0.5 * n, -1.0 * n};
  Drag one(scene, limits, 1), all(scene, limits, all_threads());
  std::optional<GibsonElements> literal;
  std::optional<GibsonBox> packed;
  if (with_literal) {
    literal.emplace(scene, limits);
    packed.emplace(scene, limits);
  }
  const auto bytes = static_cast<std::size_t>(3 * 4 * grid.n_nodes());
  std::vector<double> copies;
  std::vector<std::function<void()>> works{to_and_fro(one, handle, by), to_and_fro(all, handle, by),
                                           [&] { copies.push_back(copy_bandwidth(bytes, 1, 1)); }};
  if (literal) {
    works.push_back(to_and_fro(*literal, handle, by));
    works.push_back(to_and_fro(*packed, handle, by));
  }
  const int in_a_row = n <= 64 ? 64 : n <= 128 ? 24 : 2;
  const std::vector<double> seconds = interleaved_medians(repeats, in_a_row, works);
  const WholeBody result{literal ? seconds[3] : 0, literal ? seconds[4] : 0, seconds[0], seconds[1],
                         upper_median(copies)};

  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int b = 0; b < 3; ++b) {
      const double u = one.displacement(b, node);
      bits_are_equal &= u == all.displacement(b, node);
      if (literal)
        bits_are_equal &= u == literal->displacement(b, node) && u == packed->displacement(b, node);
    }
  const double coordinates = 3.0 * static_cast<double>(grid.n_nodes());
  nlohmann::ordered_json row{
      {"drag", "whole body, one handle"},
      {"nodes", std::to_string(n) + "^3"},
      {"literal_ms", nullptr},
      {"limits_ms", 1e3 * result.one},
      {"all_threads_ms", 1e3 * result.all},
      {"literal_over_limits", nullptr},
      {"gb_per_s", gb_per_s(coordinates, result.one)},
      {"copy_gb_per_s", result.copy},
      {"copy_fraction", gb_per_s(coordinates, result.one) / result.copy},
      {"bytes_per_node", static_cast<double>(one.bytes()) / static_cast<double>(grid.n_nodes())}};
  if (literal) {
    row["literal_ms"] = 1e3 * result.literal;
    row["packed_literal_ms"] = 1e3 * result.packed;
    row["literal_over_limits"] = result.literal / result.one;
    row["packed_over_limits"] = result.packed / result.one;
  }
  report.add(std::move(row));
  if (is_largest)
    report.checks.push_back({"bytes_per_node_homogeneous",
                             static_cast<double>(one.bytes()) / static_cast<double>(grid.n_nodes())});
  return result;
}

/// A node of a large body pulled so far that about a thousand others follow. @return seconds
double time_local_drag(int n, int repeats, BenchReport& report) {
  const Scene scene = homogeneous_cube(n);
  const LinkLimits limits(scene);
  const std::int64_t handle = scene.specimen.grid.node({n / 2, n / 2, n / 2});
  Drag drag(scene, limits, 1);
  GibsonBox literal(scene, limits);
  const double by = 10 * slack; // moves what is fewer than ten links away: 1,159 nodes
  const std::vector<double> seconds = interleaved_medians(
      5 * repeats, 20, {to_and_fro(drag, handle, {by, by, -by}), to_and_fro(literal, handle, {by, by, -by})});
  std::int64_t moved = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    moved += drag.displacement(0, node) != 0 ? 1 : 0;
  report.add({{"drag", "local"},
              {"nodes", std::to_string(n) + "^3"},
              {"moved_nodes", moved},
              {"literal_us", 1e6 * seconds[1]},
              {"limits_us", 1e6 * seconds[0]}});
  return seconds[0];
}

/// @return seconds with 1000 handles over seconds with 2
double time_many_handles(int n, int repeats, BenchReport& report) {
  const Scene scene = homogeneous_cube(n);
  const LinkLimits limits(scene);
  Drag two(scene, limits, 1), many(scene, limits, 1);
  const double by = 1.0 * n;
  const std::vector<double> seconds = interleaved_medians(
      repeats, 2,
      {to_and_fro(two, scene.specimen.grid, 2, by), to_and_fro(many, scene.specimen.grid, 1000, by)});
  report.add({{"drag", "whole body, several handles"},
              {"nodes", std::to_string(n) + "^3"},
              {"ms_2_handles", 1e3 * seconds[0]},
              {"way_2_handles", two.algorithm()},
              {"ms_1000_handles", 1e3 * seconds[1]},
              {"way_1000_handles", many.algorithm()}});
  return seconds[1] / seconds[0];
}

/// The worst violation after thirty drags of random nodes to random places, with limits that are no dyadic
/// numbers, in units in the last place of float32 of the largest displacement.
double worst_violation_of_drags(int n) {
  Scene scene = homogeneous_cube(n);
  scene.limits.given.stretch = {1.3, 1.17, 1.21};
  scene.limits.given.compress = {0.7, 0.83, 0.91};
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  Drag drag(scene, limits, 1);
  std::mt19937 random(3);
  double worst = 0;
  for (int k = 0; k < 30; ++k) {
    const auto node = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(grid.n_nodes()));
    Vec3 to{};
    for (double& component : to)
      component = n * (static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5);
    drag.move_to(node, to);
    drag.release(node);
    const Displacement state = drag.displacement();
    double largest = 0;
    for (const double u : state.values())
      largest = std::max(largest, std::abs(u));
    worst =
        std::max(worst, largest_violation(scene, limits, state) / std::ldexp(1.0, std::ilogb(largest) - 23));
  }
  return worst;
}

double bench_homogeneous(const BenchOptions& options, BenchReport& report) {
  const int repeats = options.quick ? 1 : 9;
  bool bits_are_equal = true;
  const std::vector<int> sizes =
      options.quick ? std::vector<int>{16, 24} : std::vector<int>{32, 64, 128, 256};
  std::vector<WholeBody> whole;
  for (const int n : sizes)
    whole.push_back(time_whole_body(n, repeats, n == sizes.back(), report, bits_are_equal));
  const int n_large = options.quick ? 24 : 128;
  const double local = time_local_drag(n_large, repeats, report);
  const double many_over_two = time_many_handles(options.quick ? 24 : 128, repeats, report);

  const WholeBody& at_128 = whole[whole.size() > 2 ? 2 : 1];
  const WholeBody& at_256 = whole.back();
  const double largest = 3.0 * std::pow(sizes.back(), 3);
  report.checks.push_back({"limits_over_literal_128", at_128.literal / at_128.one});
  report.checks.push_back({"copy_fraction_256", gb_per_s(largest, at_256.one) / at_256.copy});
  report.checks.push_back({"two_threads_speedup", at_128.one / at_128.all});
  report.checks.push_back({"local_drag_us", 1e6 * local});
  report.checks.push_back({"handles_1000_over_2", many_over_two});
  const double violation = worst_violation_of_drags(options.quick ? 12 : 40);
  report.add({{"drag", "thirty at random, no dyadic limits"}, {"worst_violation_ulp", violation}});
  report.checks.push_back({"bits_equal", bits_are_equal ? 1.0 : 0.0});
  return violation;
}

} // namespace

void bench_propagate(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  const std::size_t bytes =
      options.quick ? 1 << 20 : 192 << 20; // the largest body's coordinates, out of cache
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  const double of_boxes = bench_homogeneous(options, report);
  const double of_hard_bodies = bench_inhomogeneous(options, report);
  // Each link compares two sums of two rounded numbers, so two ulps are rounding.
  report.checks.push_back({"worst_violation_ulp", std::max(of_boxes, of_hard_bodies)});
}

} // namespace maille::lab
