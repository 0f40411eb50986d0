#pragma once
/// Dense worlds of soft bodies and tools, with random pushes: for tests and benchmarks of invariants of
/// frames.

#include "maille/deform/world/world.hpp"
#include "support/worlds/worlds.hpp"

#include <Eigen/Geometry>

#include <random>

namespace maille::test {

class RandomPushes {
public:
  RandomPushes(unsigned seed, int dimension, const std::string& method)
      : random_(seed), dimension_(dimension), world_(make_world(method)) {}

  deform::World& world() { return world_; }

  /// Pushes one object, or a few nodes of one.
  deform::FrameResult push(const deform::FrameBudget& budget = {}) {
    const deform::Drive drive = any_drive();
    if (below(4) == 0)
      world_.release(drive.object);
    return world_.advance({&drive, 1}, budget);
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

private:
  double unit() { return std::uniform_real_distribution(-1.0, 1.0)(random_); }
  Eigen::Vector3d direction() {
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
    for (int a = 0; a < dimension_; ++a)
      by[a] = unit();
    return by;
  }

  deform::World make_world(const std::string& method);
  WorldObject any_object(ObjectKind kind, const std::string& method);
  deform::Drive any_drive();

  std::mt19937 random_;
  int dimension_;
  deform::World world_;
};

inline WorldObject RandomPushes::any_object(ObjectKind kind, const std::string& method) {
  WorldObject object =
      box_object("object", kind, {1}, {}, even_limits(1.2 + 0.3 * std::abs(unit()), 0.7, 0.3));
  Index3 cells{1, 1, 1};
  Vec3 spacing{1, 1, 1};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a) {
    cells[a] = 2 + below(dimension_ == 3 ? 3 : 5);
    spacing[a] = 0.6 + 0.4 * std::abs(unit());
    object.position[a] = 2 + below(dimension_ == 1 ? 50 : dimension_ == 2 ? 18 : 8) + 0.5 * unit();
  }
  object.scene.specimen.grid = Grid(dimension_, cells, spacing);
  if (kind != ObjectKind::deformable) {
    if (dimension_ == 2)
      object.turn_angle = unit();
    return object;
  }
  if (method != "limits") {
    if (below(2) == 0)
      object.scene.limits = {}; // elasticity only
    if (below(3) == 0 && dimension_ == 2)
      object.turn_angle = unit();
    if (below(2) == 0)
      hold_face(object, below(dimension_), below(2) == 0);
  }
  return object;
}

inline deform::World RandomPushes::make_world(const std::string& method) {
  WorldScene scene = empty_world({1}, method);
  scene.dimension = dimension_;
  scene.friction = 0.3 * below(2);
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a)
    scene.cells[a] = dimension_ == 1 ? 60 : dimension_ == 2 ? 24 : 14;
  const ObjectKind kinds[] = {ObjectKind::deformable, ObjectKind::deformable, ObjectKind::deformable,
                              ObjectKind::rigid,      ObjectKind::rigid,      ObjectKind::fixed};
  for (const ObjectKind kind : kinds)
    for (int attempt = 0; attempt < 50; ++attempt) {
      WorldScene with = scene;
      with.objects.push_back(any_object(kind, method));
      try {
        deform::World world(with);
      } catch (const std::invalid_argument&) {
        continue; // overlaps another one
      }
      scene = std::move(with);
      break;
    }
  return deform::World(scene);
}

inline deform::Drive RandomPushes::any_drive() {
  deform::Drive drive;
  do
    drive.object = below(world_.n_objects());
  while (world_.kind(drive.object) == ObjectKind::fixed);
  drive.motion.by = (below(5) == 0 ? 6 : 1.2) * direction();
  if (world_.kind(drive.object) == ObjectKind::rigid) {
    drive.slides = below(2) == 0;
    drive.motion.about = world_.pose(drive.object).position;
    if (dimension_ == 2 && below(2) == 0)
      drive.motion.angle = 0.5 * unit();
    return drive;
  }
  const WorldObject& object = world_.scene().objects[static_cast<std::size_t>(drive.object)];
  if (below(2) == 0)
    drive.nodes = face_nodes(object, below(dimension_), below(2) == 0);
  else
    drive.nodes = {static_cast<std::int64_t>(below(static_cast<int>(object.scene.specimen.grid.n_nodes())))};
  return drive;
}

} // namespace maille::test
