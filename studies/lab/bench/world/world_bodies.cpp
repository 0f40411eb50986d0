#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::World;

WorldObject box(ObjectKind kind, int dimension, int edge, const Vec3& position, bool has_limits) {
  WorldObject object;
  object.name = kind == ObjectKind::deformable ? "body" : "tool";
  object.kind = kind;
  Scene& scene = object.scene;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(dimension, {edge, edge, dimension == 3 ? edge : 1}, {1, 1, 1});
  Material material;
  material.name = "soft";
  material.elasticity = ElasticConstants::isotropic(1e4, 0.3);
  scene.materials = {material};
  if (has_limits) {
    scene.limits.from = LimitSource::given;
    scene.limits.given.stretch.fill(1.3);
    scene.limits.given.compress.fill(0.7);
    for (auto& row : scene.limits.given.shear)
      row.fill(0.3);
  }
  object.position = position;
  return object;
}

void hold_lower_face(WorldObject& object, int axis) {
  Scene& scene = object.scene;
  const Grid& grid = scene.specimen.grid;
  for (int component = 0; component < grid.dimension(); ++component)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (grid.node_at(node)[static_cast<std::size_t>(axis)] == 0)
        scene.prescribed.push_back({node, component, 0, true});
}

/// Three rows of soft bodies and tools in turn, walls between some; every other body is held by its lower
/// face.
World crowded_world(int dimension, const std::string& method) {
  WorldScene scene;
  scene.dimension = dimension;
  scene.method = method;
  const int edge = dimension == 3 ? 4 : 6, places = 3;
  scene.cells = {places * (edge + 4), places * (edge + 4), dimension == 3 ? edge + 6 : 1};
  for (int i = 0; i < places * places; ++i) {
    const ObjectKind kind = i % 4 == 3   ? ObjectKind::fixed
                            : i % 2 == 1 ? ObjectKind::rigid
                                         : ObjectKind::deformable;
    const Vec3 at{1.5 + (edge + 4) * (i % places), 1.5 + (edge + 4) * (i / places), dimension == 3 ? 2.5 : 0};
    scene.objects.push_back(box(kind, dimension, edge - (kind == ObjectKind::fixed ? 2 : 0), at, true));
    if (kind == ObjectKind::deformable && i % 4 == 0)
      hold_lower_face(scene.objects.back(), 1);
  }
  return World(scene);
}

class RandomDrives {
public:
  explicit RandomDrives(unsigned seed) : random_(seed) {}
  Drive of(const World& world) {
    Drive drive;
    do
      drive.object = below(world.n_objects());
    while (world.kind(drive.object) == ObjectKind::fixed);
    for (int a = 0; a < world.scene().dimension; ++a)
      drive.motion.by[a] = 3 * unit() * std::abs(unit());
    if (world.kind(drive.object) == ObjectKind::rigid) {
      drive.slides = below(2) == 0;
      return drive;
    }
    const Grid& grid = world.scene().objects[static_cast<std::size_t>(drive.object)].scene.specimen.grid;
    const auto axis = static_cast<std::size_t>(below(grid.dimension()));
    const int side = below(2) == 0 ? 0 : grid.cells()[axis];
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (grid.node_at(node)[axis] == side)
        drive.nodes.push_back(node);
    return drive;
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

private:
  double unit() { return std::uniform_real_distribution(-1.0, 1.0)(random_); }
  std::mt19937 random_;
};

constexpr int most_answers = 100; ///< of a push

struct Tally {
  std::int64_t penetrations = 0, rounds = 0, unsettled = 0;
  std::size_t contacts = 0, handed_on = 0;
  double seconds = 0, violation = 0;
};

Tally push_at_random(World& world, int pushes) {
  RandomDrives drives(23);
  deform::FrameBudget budget;
  budget.rounds = most_answers;
  Tally tally;
  for (int push = 0; push < pushes; ++push) {
    const Drive drive = drives.of(world);
    const deform::FrameResult result = world.advance({&drive, 1}, budget);
    world.release(drive.object);
    tally.penetrations += world.n_penetrations();
    tally.violation = std::max(tally.violation, world.largest_violation());
    tally.rounds += result.rounds;
    tally.unsettled += result.status == Status::budget_reached;
    tally.contacts += result.contacts.size();
    tally.handed_on += result.handed_on.size();
    tally.seconds += result.seconds;
  }
  return tally;
}

std::int64_t crowd(int dimension, const char* method, int pushes, BenchReport& report) {
  World world = crowded_world(dimension, method);
  const Tally tally = push_at_random(world, pushes);
  report.add(
      {{"what",
        fmt::format("{} random pushes of soft bodies and tools in {}D by {}", pushes, dimension, method)},
       {"voxels", pushes},
       {"microseconds", 1e6 * tally.seconds},
       {"ns_per_voxel", 1e9 * tally.seconds / pushes},
       {"note", fmt::format("a push in place of a voxel; {} contacts, {} movements handed on, {} answers; "
                            "{} ended at their budget of {} answers; limits broken by {:.1g}",
                            tally.contacts, tally.handed_on, tally.rounds, tally.unsettled, most_answers,
                            tally.violation)}});
  return tally.penetrations;
}

/// A block pressed by a plane, a cell a frame, by `coupled`.
std::int64_t press(int edge, BenchReport& report) {
  WorldScene scene;
  scene.cells = {edge + 8, edge + 8, edge + 12};
  scene.objects = {box(ObjectKind::deformable, 3, edge, {4.1, 4.1, 2.1}, false),
                   box(ObjectKind::rigid, 3, edge + 4, {2, 2, 0}, false)};
  scene.objects[1].scene.specimen.grid = Grid(3, {edge + 4, edge + 4, 2}, {1, 1, 1});
  scene.objects[1].position[2] = edge + 3;
  hold_lower_face(scene.objects[0], 2);
  World world(scene);
  Drive down;
  down.object = 1;
  down.motion.by = {0, 0, -1};
  std::vector<double> seconds;
  std::int64_t penetrations = 0, rounds = 0;
  for (int frame = 0; frame < 4; ++frame) {
    const auto result = world.advance({&down, 1});
    seconds.push_back(result.seconds);
    rounds += result.rounds;
    penetrations += world.n_penetrations();
  }
  const std::int64_t nodes = scene.objects[0].scene.specimen.grid.n_nodes();
  std::ranges::sort(seconds);
  report.add({{"what", fmt::format("a frame of a plane that presses {}^3 cells by one, by coupled", edge)},
              {"voxels", nodes},
              {"microseconds", 1e6 * seconds[2]},
              {"ns_per_voxel", 1e9 * seconds[2] / static_cast<double>(nodes)},
              {"note", fmt::format("{} answers in four frames", rounds)}});
  return penetrations;
}

} // namespace

std::int64_t push_bodies(bool quick, BenchReport& report) {
  const int many = quick ? 40 : 2000, few = quick ? 10 : 200;
  return crowd(2, "limits", many, report) + crowd(3, "limits", many / 4, report) +
         crowd(2, "coupled", few, report) + press(quick ? 8 : 32, report);
}

} // namespace maille::lab
