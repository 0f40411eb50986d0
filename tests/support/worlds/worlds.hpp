#pragma once
/// Worlds built without a file.

#include "maille/deform/world/world.hpp"
#include "support/bodies/lattice_scenes.hpp"

#include <string>

namespace maille::test {

/// An empty world of unit cells.
inline WorldScene empty_world(std::initializer_list<int> cells, const std::string& method) {
  WorldScene world;
  world.dimension = static_cast<int>(cells.size());
  world.method = method;
  std::ranges::copy(cells, world.cells.begin());
  return world;
}

/// A box of unit cells (E = 10 kPa, nu = 0.3) with given limits.
inline WorldObject box_object(const std::string& name, ObjectKind kind, std::initializer_list<int> cells,
                              const Vec3& position, const NeighbourLimits& limits = even_limits(1, 1, 0)) {
  WorldObject object;
  object.name = name;
  object.kind = kind;
  object.scene = lattice_box(cells, limits);
  object.position = position;
  return object;
}

/// The same without binding limits: elasticity only.
inline WorldObject elastic_object(const std::string& name, std::initializer_list<int> cells,
                                  const Vec3& position) {
  WorldObject object = box_object(name, ObjectKind::deformable, cells, position);
  object.scene.limits = {};
  return object;
}

/// A muscle of 20 x 9 x 9 mm between tendons, held at both ends; `others` is the text of the other objects in
/// its world.
inline WorldScene belly_and(const std::string& others) {
  return parse_world_scene(R"([world]
cells   = [24, 15, 20]
spacing = "1 mm"
method  = "coupled"
contact = "surfaces"
[[object]]
name     = "muscle"
kind     = "deformable"
shape    = "muscle"
cells    = [20, 9, 9]
material = { youngs_modulus = "20 kPa", poisson_ratio = 0.4 }
tendon   = { material = { youngs_modulus = "500 kPa", poisson_ratio = 0.4 }, fraction = 0.15 }
hold     = [{ where = "x-" }, { where = "x+" }]
position = ["2 mm", "3 mm", "1 mm"]
)" + others);
}

inline deform::Drive drive_of(int object, const Eigen::Vector3d& by, std::vector<std::int64_t> nodes = {}) {
  deform::Drive drive;
  drive.object = object;
  drive.motion.by = by;
  drive.nodes = std::move(nodes);
  return drive;
}

inline void hold_face(WorldObject& object, int axis, bool upper) {
  for (const Index3& at : face(object.scene, axis, upper))
    hold(object.scene, at);
}

inline std::vector<std::int64_t> face_nodes(const WorldObject& object, int axis, bool upper) {
  std::vector<std::int64_t> nodes;
  for (const Index3& at : face(object.scene, axis, upper))
    nodes.push_back(object.scene.specimen.grid.node(at));
  return nodes;
}

} // namespace maille::test
