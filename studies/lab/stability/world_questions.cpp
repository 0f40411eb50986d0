#include "stability/world_questions.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace maille::lab {

namespace {

StabilityCell cell_of(const PlayOutcome& outcome) {
  StabilityCell cell;
  cell.outcome = outcome.cut_short > 0 ? "budget reached" : outcome.clamped > 0 ? "clamped" : "settled";
  cell.note = fmt::format("{} frames, {} of them clamped, {} cut short; {} contacts",
                          outcome.done + outcome.clamped + outcome.cut_short, outcome.clamped,
                          outcome.cut_short, outcome.contacts);
  cell.violation = outcome.violation;
  cell.iterations = outcome.rounds;
  cell.broken = outcome.broken;
  return cell;
}

} // namespace

WorldScene empty_world(const std::vector<int>& cells, const std::string& method, ContactLaw contact) {
  WorldScene world;
  world.dimension = static_cast<int>(cells.size());
  std::ranges::copy(cells, world.cells.begin());
  world.spacing = {world_cell, world_cell, world_cell};
  world.method = method;
  world.contact = contact;
  return world;
}

WorldObject box_in(const WorldScene& world, ObjectKind kind, const std::vector<int>& cells, double spacing,
                   const Vec3& corner, double angle) {
  WorldObject object;
  object.name = fmt::format("object{}", world.objects.size());
  object.kind = kind;
  Index3 n{1, 1, 1};
  std::ranges::copy(cells, n.begin());
  const double length = spacing * world_cell;
  Scene& scene = object.scene;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(world.dimension, n, {length, length, length});
  Material& material = scene.materials.emplace_back();
  material.name = "soft";
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  if (world.method == "limits") {
    scene.limits.from = LimitSource::given;
    scene.limits.given.stretch.fill(1.5);
    scene.limits.given.compress.fill(0.3);
    for (auto& row : scene.limits.given.shear)
      row.fill(0.5);
  }
  object.turn_angle = angle;
  if (world.dimension == 3) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
    object.turn_axis = {axis[0], axis[1], axis[2]};
  }
  const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < cells.size(); ++a)
    half[static_cast<Eigen::Index>(a)] = 0.5 * n[a] * length;
  const Eigen::Vector3d place = world_cell * Eigen::Vector3d::Map(corner.data()) + half - turn * half;
  for (std::size_t a = 0; a < cells.size(); ++a)
    object.position[a] = place[static_cast<Eigen::Index>(a)];
  return object;
}

std::vector<std::int64_t> face_nodes(const WorldObject& object, int axis, bool upper) {
  const Grid& grid = object.scene.specimen.grid;
  const auto a = static_cast<std::size_t>(axis);
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[a] == (upper ? grid.cells()[a] : 0))
      nodes.push_back(node);
  return nodes;
}

void hold_face(WorldObject& object, int axis, bool upper) {
  for (int component = 0; component < object.scene.dimension(); ++component)
    for (const std::int64_t node : face_nodes(object, axis, upper))
      object.scene.prescribed.push_back({node, component, 0, true});
}

deform::Drive shift_of(const WorldScene& world, std::size_t object, const Vec3& by,
                       std::vector<std::int64_t> nodes) {
  deform::Drive drive;
  drive.object = static_cast<int>(object);
  for (int a = 0; a < world.dimension; ++a)
    drive.motion.by[a] = world_cell * by[static_cast<std::size_t>(a)];
  drive.nodes = std::move(nodes);
  return drive;
}

void repeat(WorldPlay& play, const deform::Drive& drive, int frames) {
  for (int i = 0; i < frames; ++i)
    play.frames.push_back({.drives = {drive}, .released = {}, .rounds = {}});
}

void add(const WorldQuestion& question, std::vector<Extreme>& list) {
  list.push_back({.extreme = question.extreme,
                  .setting = question.setting,
                  .scene = {},
                  .is_normal = question.is_normal,
                  .methods = question.methods,
                  .protocol = [question](Methods&, const std::string& method, const Control& control) {
                    const WorldPlay play = question.play(method);
                    return cell_of(played(play, question.look ? question.look(play) : LookAtFrame(),
                                          control.stop_requested));
                  }});
}

} // namespace maille::lab
