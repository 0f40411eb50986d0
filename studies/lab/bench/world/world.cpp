#include "bench/subjects.hpp"

#include "maille/deform/world/rigid_world.hpp"
#include "median.hpp"
#include "rivals/bullet_voxels.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace maille::lab {

namespace {

using deform::Pose;
using deform::RigidMotion;
using deform::RigidShape;
using deform::RigidWorld;

struct Sizes {
  int world, pointshell, moving, repeats, paths;
  static Sizes of(const BenchOptions& options) {
    return options.quick ? Sizes{96, 20, 16, 3, 200} : Sizes{512, 100, 64, 15, 10'000};
  }
};

RigidShape solid(const Index3& size) {
  return {
      size,
      {1, 1, 1},
      std::vector<std::uint8_t>(static_cast<std::size_t>(std::int64_t{1} * size[0] * size[1] * size[2]), 1)};
}

/// The 380 voxels of a ball's shell: as many points as the tool of McNeely and others (1999) had.
RigidShape tool_of_380() {
  constexpr int n = 13;
  struct Place {
    double off;
    std::size_t at;
  };
  std::vector<Place> places;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        places.push_back(
            {std::abs(std::hypot(x - 6, y - 6, z - 6) - 5.6), static_cast<std::size_t>(x + n * (y + n * z))});
  std::ranges::stable_sort(places, {}, &Place::off);
  std::vector<std::uint8_t> matter(static_cast<std::size_t>(n * n * n), 0);
  for (std::size_t i = 0; i < 380; ++i)
    matter[places[i].at] = 1;
  return {{n, n, n}, {1, 1, 1}, matter};
}

/// A world whose every other brick of 8^3 cells is matter, as on a board for chess.
RigidWorld half_full_world(int n) {
  RigidWorld world({n, n, n}, {1, 1, 1});
  std::vector<std::uint8_t> layer(static_cast<std::size_t>(n * n));
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        layer[static_cast<std::size_t>(x + n * y)] = ((x / 8 + y / 8 + z / 8) & 1) != 0;
    world.add(RigidShape({n, n, 1}, {1, 1, 1}, layer), Pose{.position = {0, 0, static_cast<double>(z)}});
  }
  return world;
}

Pose turned_pose(double angle, const Eigen::Vector3d& position) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.position = position;
  return pose;
}

constexpr int looks_a_path = 16;

class WorldBench {
public:
  WorldBench(const BenchOptions& options, BenchReport& report)
      : options_(options), sizes_(Sizes::of(options)), report_(report) {}

  void test_poses();
  void update_map();
  void follow_paths();
  void face_bullet();

private:
  void row(const std::string& what, std::int64_t voxels, double seconds, const std::string& note = "") {
    report_.add({{"what", what},
                 {"voxels", voxels},
                 {"microseconds", 1e6 * seconds},
                 {"ns_per_voxel", 1e9 * seconds / static_cast<double>(voxels)},
                 {"note", note}});
  }

  BenchOptions options_;
  Sizes sizes_;
  BenchReport& report_;
};

void WorldBench::test_poses() {
  const RigidWorld world = half_full_world(sizes_.world);
  const double middle = 0.5 * sizes_.world;
  const auto time = [&](const RigidShape& shape, int n_poses, double reach) {
    std::int64_t sum = 0;
    int turn = 0;
    std::vector<Pose> poses(static_cast<std::size_t>(n_poses));
    const double seconds = median_seconds(
        sizes_.repeats,
        [&] { // making a pose out of an angle is not what is timed
          for (Pose& pose : poses) {
            pose = turned_pose(0.1 * turn, {middle - reach * std::sin(turn), middle, middle});
            ++turn;
          }
        },
        [&] {
          for (const Pose& pose : poses)
            sum += world.n_blocked(shape, pose);
        });
    return std::pair(seconds / n_poses, sum);
  };
  const RigidShape pointshell = solid({sizes_.pointshell, sizes_.pointshell, sizes_.pointshell});
  const auto [shell_s, shell_sum] = time(pointshell, 1, 0.2 * sizes_.world);
  row(fmt::format("a pose of {}^3 voxels in a world of {}^3", sizes_.pointshell, sizes_.world),
      pointshell.n_voxels(), shell_s, "half full, turned, another pose each time");
  const auto [tool_s, tool_sum] = time(tool_of_380(), 200, 0.3 * sizes_.world);
  row("a pose of a tool of 380 voxels", 380, tool_s, "the same world");
  report_.checks.push_back({"million_lookups_512_ms", 1e3 * shell_s * 1e6 / pointshell.n_voxels(),
                            "2: 0.5 ns for the cell, 1.5 for its brick and its bit, gathered",
                            "1.6 if the world's bits were one plain array in the cache"});
  report_.checks.push_back(
      {"tool_380_us", 1e6 * tool_s, "0.8", "0.6: a plain array of bits; poses are made beforehand"});
}

/// Rounds of copies and of moves, so that both see the same machine; the first move after a copy finds
/// nothing in the cache.
void WorldBench::update_map() {
  const int n = sizes_.world, edge = sizes_.moving, moves = 16;
  const std::int64_t voxels = std::int64_t{1} * edge * edge * edge;
  RigidWorld world({n, n, n}, {1, 1, 1});
  const int object = *world.add(solid({edge, edge, edge}), Pose{.position = {3, 5, 7}}).object;
  int turn = 0;
  RigidMotion motion;
  const auto move = [&] {
    motion.by.setConstant(++turn % 2 == 0 ? -1 : 1);
    world.move(object, motion);
  };
  // Both of memory, as the machine's figure is, and of arrays as large as the object's numbers, which stay in
  // the cache.
  std::vector<double> memory, cached, first, update;
  for (int round = 0; round < sizes_.repeats; ++round) {
    memory.push_back(copy_bandwidth(std::size_t{1} << (edge < 64 ? 24 : 28), 1, 1));
    const auto start = std::chrono::steady_clock::now();
    move();
    first.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    update.push_back(median_seconds(
        moves, [] {}, move));
    cached.push_back(copy_bandwidth(4 * static_cast<std::size_t>(voxels), moves, 1));
  }
  // The fastest copies against the median move: what else the machine does takes more from copies of memory
  // than from the cache.
  const double memory_copy = std::ranges::max(memory), cached_copy = std::ranges::max(cached);
  // A copy of the object's numbers from its old cells to its new ones would read 4 bytes a voxel and write 4.
  // The map writes a number a voxel, and clears and sets a bit of it: 4.25 bytes written.
  const double seconds = upper_median(update), gb_per_s = 8e-9 * static_cast<double>(voxels) / seconds;
  row(fmt::format("an object of {}^3 voxels moved by a cell along each axis", edge), voxels, seconds,
      fmt::format("first contact looked for, map updated; {:.3g} us just after a copy of memory",
                  1e6 * upper_median(first)));
  report_.checks.push_back(
      {"map_update_copy_fraction", gb_per_s / memory_copy,
       "0.4: rows of 16 numbers are masked stores; finding the 3 parts of a block in bricks takes as long",
       fmt::format(
           "8 bytes a voxel, as a copy of its numbers reads and writes; the fastest copies in turn with it: "
           "{:.3g} GB/s of memory, {:.3g} of as many numbers in the cache, of which it is {:.2g}",
           memory_copy, cached_copy, gb_per_s / cached_copy)});
}

void WorldBench::follow_paths() {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1, 1);
  const int n = 64;
  RigidWorld world({n, n, n}, {1, 1, 1});
  for (int i = 0; i < 40; ++i) // walls one cell thick, with holes between them
    world.add(solid({i % 3 == 0 ? 1 : 12, i % 3 == 1 ? 1 : 12, i % 3 == 2 ? 1 : 12}),
              Pose{.position = {26 + 25 * unit(random), 26 + 25 * unit(random), 26 + 25 * unit(random)}});
  const RigidShape tool = tool_of_380();
  std::optional<int> object;
  while (!object)
    object = world
                 .add(tool, turned_pose(unit(random), {25 + 20 * unit(random), 25 + 20 * unit(random),
                                                       25 + 20 * unit(random)}))
                 .object;
  std::int64_t tunnelled = 0, penetrations = 0, contacts = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int path = 0; path < sizes_.paths; ++path) {
    const Pose before = world.pose(*object);
    RigidMotion motion;
    motion.by =
        40 * std::pow(std::abs(unit(random)), 3) * Eigen::Vector3d(unit(random), unit(random), unit(random));
    motion.axis = Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
    motion.angle = path % 2 == 0 ? 0 : unit(random);
    motion.about = before.position;
    const auto result = world.move(*object, motion);
    contacts += static_cast<std::int64_t>(result.contacts.size());
    // Looked at from time to time, voxel by voxel, without the walks that found the contact.
    for (int look = 1; look < looks_a_path; ++look)
      tunnelled += world.n_blocked(*object, motion.moved(before, result.fraction * look / looks_a_path));
    penetrations += world.n_blocked(*object, world.pose(*object));
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  row(fmt::format("{} random paths of the tool among walls one cell thick, with checks", sizes_.paths),
      sizes_.paths, seconds.count(), fmt::format("{} contacts; a path in place of a voxel", contacts));
  penetrations += report_probe(options_.quick, report_);
  report_.checks.push_back({"penetrations", static_cast<double>(penetrations), "0", ""});
  report_.checks.push_back({"tunnelled", static_cast<double>(tunnelled), "0", ""});
}

void WorldBench::face_bullet() {
  const int edge = sizes_.moving / 2;
  std::vector<std::uint8_t> shell;
  std::vector<Vec3> still, tool;
  for (int z = 0; z < edge; ++z)
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x) {
        const double r = std::hypot(x - 0.5 * edge, y - 0.5 * edge, z - 0.5 * edge) / edge;
        shell.push_back(r > 0.4 && r < 0.47);
        if (shell.back() != 0)
          still.push_back({x + 0.5, y + 0.5, z + 0.5});
      }
  RigidWorld world({2 * edge, 2 * edge, 2 * edge}, {1, 1, 1});
  world.add(RigidShape({edge, edge, edge}, {1, 1, 1}, shell), {});
  const RigidShape shape = tool_of_380();
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel) {
    const Index3 i = shape.index_of(voxel);
    tool.push_back({i[0] + 0.5, i[1] + 0.5, i[2] + 0.5});
  }
  const auto bullet = bullet_voxels(still, tool);
  if (!bullet) {
    report_.notes.emplace_back("fcl_or_bullet_over_maille omitted: built without libbullet.");
    return;
  }
  std::mt19937 random(5);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < (sizes_.repeats < 5 ? 10 : 100); ++i)
    places.emplace_back(random() % static_cast<unsigned>(edge), random() % static_cast<unsigned>(edge),
                        random() % static_cast<unsigned>(edge));
  int differing = 0, touching = 0;
  for (const auto& at : places) {
    const bool ours = world.n_blocked(shape, Pose{.position = at}) > 0;
    touching += ours;
    differing += ours != bullet->touches(at[0], at[1], at[2]);
  }
  std::int64_t sum = 0;
  const double theirs_s = median_seconds(
      sizes_.repeats, [] {},
      [&] {
        for (const auto& at : places)
          sum += bullet->touches(at[0], at[1], at[2]);
      });
  const double ours_s = median_seconds(
      sizes_.repeats, [] {},
      [&] {
        for (const auto& at : places)
          sum += world.n_blocked(shape, Pose{.position = at});
      });
  const auto n = static_cast<double>(places.size());
  row("a pose of the tool against a shell", 380, ours_s / n,
      fmt::format("{} of {} poses touch", touching, places.size()));
  row("the same by Bullet, a box a voxel", 380, theirs_s / n, fmt::format("{} answers differ", differing));
  report_.checks.push_back({"fcl_or_bullet_over_maille", theirs_s / ours_s,
                            "100: Bullet goes down two trees of boxes for every pair that is near", ""});
}

} // namespace

namespace {

struct Part {
  const char* name;
  void (*run)(WorldBench& bench, const BenchOptions& options, BenchReport& report);
};

constexpr std::array parts{
    Part{"poses", [](WorldBench& bench, const BenchOptions&, BenchReport&) { bench.test_poses(); }},
    Part{"map", [](WorldBench& bench, const BenchOptions&, BenchReport&) { bench.update_map(); }},
    Part{"paths", [](WorldBench& bench, const BenchOptions&, BenchReport&) { bench.follow_paths(); }},
    Part{"bullet", [](WorldBench& bench, const BenchOptions&, BenchReport&) { bench.face_bullet(); }},
    Part{"nut", [](WorldBench&, const BenchOptions& o, BenchReport& r) { report_nut(o.quick, r); }},
    Part{"reference",
         [](WorldBench&, const BenchOptions& o, BenchReport& r) { report_reference(o.quick, r); }},
};

} // namespace

void add_row_per(BenchReport& report, const std::string& what, std::int64_t n, double seconds,
                 const std::string& note) {
  report.add({{"what", what},
              {"voxels", n},
              {"microseconds", 1e6 * seconds / static_cast<double>(n)},
              {"ns_per_voxel", 1e9 * seconds / static_cast<double>(n)},
              {"note", note}});
}

std::vector<std::string> world_bench_parts() {
  std::vector<std::string> names;
  for (const Part& part : parts)
    names.emplace_back(part.name);
  return names;
}

void bench_world(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  WorldBench bench(options, report);
  for (const Part& part : parts)
    if (options.only.empty() || options.only == part.name)
      part.run(bench, options, report);
  report.machine["copy_gb_per_s"] = copy_bandwidth(std::size_t{1} << 28, options.quick ? 3 : 9, 1);
}

} // namespace maille::lab
