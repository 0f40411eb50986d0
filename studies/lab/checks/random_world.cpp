#include "checks/random_world.hpp"

#include "maille/deform/world/trajectory_drives.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace maille::lab {

namespace {

constexpr double cell = 1e-3; ///< of the world [m]

double between(Choices& choices, double low, double high) {
  return low + choices.uniform() * (high - low);
}

Vec3 direction_in(Choices& choices, int dimension) {
  Vec3 v{};
  for (int a = 0; a < dimension; ++a)
    v[static_cast<std::size_t>(a)] = 1 - 2 * choices.uniform();
  return v;
}

void choose_laws(Choices& choices, WorldPlay& play) {
  WorldScene& world = play.scene;
  world.dimension = 1 + choices.below(3);
  world.spacing.fill(cell);
  for (std::size_t a = 0; a < 3; ++a)
    world.cells[a] = static_cast<int>(a) >= world.dimension
                         ? 1
                         : std::array{40, 20, 12}[static_cast<std::size_t>(world.dimension - 1)];
  if (choices.below(8) > 5 && world.dimension > 1)
    world.contact = ContactLaw::surfaces;
  world.friction = choices.one_of(std::array{0.0, 0.3, 1.0, 10.0});
  if (world.contact != ContactLaw::surfaces) {
    world.method = choices.one_of(std::array{"limits", "relaxed", "coupled", "coupled"});
    return;
  }
  if (!choices.is_one_in(2))
    return;
  play.frame_seconds = 0.005;
  world.friction = 0;
  WorldDynamics& dynamics = world.dynamics.emplace();
  dynamics.gravity[static_cast<std::size_t>(world.dimension - 1)] =
      choices.one_of(std::array{0.0, -9.81, -1000.0});
  dynamics.restitution = choices.one_of(std::array{0.0, 0.5, 1.0});
  dynamics.damping = choices.one_of(std::array{0.0, 1.0, 1000.0});
}

/// A box of about some cells of the world, of cells of its own.
void choose_lattice(Choices& choices, WorldObject& object, int dimension) {
  const auto d = static_cast<std::size_t>(dimension - 1);
  const double ratio = choices.one_of(std::array{1.0, 0.25, 0.5, 2.0, 4.0, 0.7});
  const bool is_uneven = choices.is_one_in(4);
  Index3 cells{1, 1, 1};
  Vec3 spacing{cell, cell, cell};
  for (std::size_t a = 0; a <= d; ++a) {
    spacing[a] *= ratio * (is_uneven ? between(choices, 1, 1.4) : 1);
    const double length = cell * between(choices, 1, std::array{8.0, 6.0, 4.0}[d]);
    cells[a] = std::clamp(static_cast<int>(std::lround(length / spacing[a])), 1, std::array{32, 24, 8}[d]);
  }
  Specimen& body = object.scene.specimen;
  body.shape = "box";
  body.grid = Grid(dimension, cells, spacing);
  if (!choices.is_one_in(4) || body.grid.n_cells() == 1)
    return;
  for (std::int64_t i = 0; i < body.grid.n_cells(); ++i)
    body.material_id.push_back(i > 0 && choices.is_one_in(4) ? no_material : std::uint8_t{0});
}

void choose_place(Choices& choices, WorldObject& object, const WorldScene& world) {
  const auto d = static_cast<std::size_t>(world.dimension);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (d > 1 && choices.is_one_in(2)) {
    object.turn_angle = 2 * std::numbers::pi * choices.uniform();
    if (d == 3) {
      Vec3 axis = direction_in(choices, 3);
      axis[2] += 2; // never 0
      const double length = std::hypot(axis[0], axis[1], axis[2]);
      object.turn_axis = {axis[0] / length, axis[1] / length, axis[2] / length};
    }
    rotation = Eigen::AngleAxisd(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()))
                   .toRotationMatrix();
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < d; ++a)
    middle[static_cast<Eigen::Index>(a)] = cell * between(choices, 2, world.cells[a] - 2);
  const Eigen::Vector3d corner = middle - rotation * deform::middle_of(object.scene.specimen);
  for (std::size_t a = 0; a < d; ++a)
    object.position[a] = corner[static_cast<Eigen::Index>(a)];
}

void choose_matter(Choices& choices, WorldObject& object, const WorldScene& world) {
  Scene& scene = object.scene;
  Material& material = scene.materials.emplace_back();
  material.name = "matter";
  material.elasticity = ElasticConstants::isotropic(10e3 * choices.one_of(std::array{1.0, 10.0, 0.1, 1e3}),
                                                    choices.one_of(std::array{0.3, 0.0, 0.45, 0.499}));
  const bool may_have_limits = world.contact != ContactLaw::surfaces;
  if (world.method == "limits" || (may_have_limits && choices.is_one_in(3))) {
    scene.limits.from = LimitSource::given;
    scene.limits.given.stretch.fill(1 + between(choices, 0, 0.6));
    scene.limits.given.compress.fill(1 - between(choices, 0, 0.6));
    const double shear = between(choices, 0, 0.6);
    for (auto& row : scene.limits.given.shear)
      row.fill(shear);
  }
  if (!choices.is_one_in(2))
    return;
  const Grid& grid = scene.specimen.grid;
  const auto axis = static_cast<std::size_t>(choices.below(world.dimension));
  const int side = choices.below(2) * grid.cells()[axis];
  for (int component = 0; component < world.dimension; ++component)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (grid.node_at(node)[axis] == side && scene.specimen.is_node(grid.node_at(node)))
        scene.prescribed.push_back({node, component, 0, true});
}

struct Ball {
  Eigen::Vector3d middle;
  double radius;
};

Ball ball_about(const WorldObject& object) {
  const Eigen::Vector3d half = deform::middle_of(object.scene.specimen),
                        corner = Eigen::Vector3d::Map(object.position.data());
  const Eigen::AngleAxisd turn(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  return {corner + turn.toRotationMatrix() * half, half.norm()};
}

/// Where cells keep objects apart World refuses what overlaps; where surfaces do, not all of it.
bool fits(const WorldScene& world) {
  const Ball last = ball_about(world.objects.back());
  for (std::size_t i = 0; world.contact == ContactLaw::surfaces && i + 1 < world.objects.size(); ++i) {
    const Ball other = ball_about(world.objects[i]);
    if ((other.middle - last.middle).norm() < other.radius + last.radius)
      return false;
  }
  try {
    return deform::World(world).n_penetrations() == 0;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

void choose_objects(Choices& choices, WorldScene& world) {
  const int n = 1 + choices.below(6);
  for (int i = 0; i < n; ++i) {
    WorldObject object;
    object.name = object.scene.name = fmt::format("object{}", i);
    object.kind = choices.one_of(
        std::array{ObjectKind::rigid, ObjectKind::deformable, ObjectKind::fixed, ObjectKind::deformable});
    choose_lattice(choices, object, world.dimension);
    choose_place(choices, object, world);
    if (object.kind == ObjectKind::deformable)
      choose_matter(choices, object, world);
    else
      object.is_smooth = world.contact == ContactLaw::surfaces && choices.is_one_in(4);
    if (world.dynamics && object.kind != ObjectKind::fixed) {
      object.density = choices.one_of(std::array{1000.0, 10.0, 20000.0});
      const Vec3 velocity = direction_in(choices, world.dimension);
      for (std::size_t a = 0; a < 3; ++a)
        object.velocity[a] = 0.5 * velocity[a];
    }
    if (object.kind == ObjectKind::deformable && world.dynamics)
      world.dynamics->restitution = 0; // bodies rebound by their elasticity
    world.objects.push_back(std::move(object));
    if (!fits(world))
      world.objects.pop_back();
  }
}

std::vector<std::int64_t> nodes_to_drive(Choices& choices, const Specimen& body) {
  const Grid& grid = body.grid;
  std::vector<std::int64_t> nodes;
  const bool is_face = choices.is_one_in(2);
  const auto axis = static_cast<std::size_t>(choices.below(grid.dimension()));
  const int side = choices.below(2) * grid.cells()[axis];
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (body.is_node(grid.node_at(node)) && (!is_face || grid.node_at(node)[axis] == side))
      nodes.push_back(node);
  if (is_face || nodes.empty())
    return nodes;
  return {nodes[static_cast<std::size_t>(choices.below(static_cast<int>(nodes.size())))]};
}

/// @pre the object can move
deform::Drive choose_drive(Choices& choices, const WorldScene& world, int number) {
  deform::Drive drive;
  drive.object = number;
  const WorldObject& object = world.objects[static_cast<std::size_t>(number)];
  const Vec3 any = direction_in(choices, world.dimension);
  drive.motion.by = cell * choices.one_of(std::array{1.2, 6.0, 0.01}) * Eigen::Vector3d::Map(any.data());
  if (choices.is_one_in(2)) {
    const auto towards = static_cast<std::size_t>(choices.below(static_cast<int>(world.objects.size())));
    drive.motion.by =
        between(choices, 0.3, 2) * (ball_about(world.objects[towards]).middle - ball_about(object).middle);
  }
  if (object.kind == ObjectKind::deformable) {
    drive.nodes = nodes_to_drive(choices, object.scene.specimen);
    return drive;
  }
  drive.slides = choices.is_one_in(2);
  if (world.dimension > 1 && choices.is_one_in(3)) {
    drive.motion.angle = between(choices, -1.5, 1.5);
    if (world.dimension == 3)
      drive.motion.axis = Eigen::Vector3d::Unit(choices.below(3));
  }
  if (!world.dynamics && choices.is_one_in(5))
    drive.lead.emplace().stiffness = choices.one_of(std::array{300.0, 1.0, 1e5});
  return drive;
}

void choose_frames(Choices& choices, WorldPlay& play) {
  const WorldScene& world = play.scene;
  std::vector<int> movable;
  for (std::size_t i = 0; i < world.objects.size(); ++i)
    if (world.objects[i].kind != ObjectKind::fixed)
      movable.push_back(static_cast<int>(i));
  const int n = 1 + choices.below(4);
  for (int i = 0; i < n; ++i) {
    PlayFrame frame;
    frame.rounds = choices.is_one_in(3) ? 1 + choices.below(10) : 100;
    std::vector<int> left = movable;
    for (int drives = choices.is_one_in(4)   ? 2
                      : choices.is_one_in(6) ? 0
                                             : 1;
         drives > 0 && !left.empty(); --drives) {
      const auto chosen = left.begin() + choices.below(static_cast<int>(left.size()));
      frame.drives.push_back(choose_drive(choices, world, *chosen));
      left.erase(chosen);
    }
    if (!movable.empty() && choices.is_one_in(4))
      frame.released.push_back(
          movable[static_cast<std::size_t>(choices.below(static_cast<int>(movable.size())))]);
    play.frames.push_back(std::move(frame));
  }
}

std::string in_words(const WorldObject& object, const WorldScene& world) {
  const Specimen& body = object.scene.specimen;
  std::string text =
      fmt::format("  {}: {}, cells {}, {} of them matter, spacing {}, at {}", object.name,
                  object.kind == ObjectKind::fixed   ? "fixed"
                  : object.kind == ObjectKind::rigid ? "rigid"
                                                     : "deformable",
                  body.grid.cells(), body.n_matter_cells(), body.grid.spacing(), object.position);
  if (object.turn_angle != 0)
    text += fmt::format(", turned by {} about {}", object.turn_angle, object.turn_axis);
  if (object.is_smooth)
    text += ", smooth";
  if (world.dynamics)
    text += fmt::format(", {} kg/m^3, {} m/s", object.density, object.velocity);
  if (object.kind == ObjectKind::deformable) {
    const ElasticConstants& elasticity = object.scene.materials[0].elasticity;
    text += fmt::format(", E {} Pa, nu {}, {} components held", elasticity.youngs_modulus[0], elasticity.nu12,
                        object.scene.prescribed.size());
    if (object.scene.limits.from == LimitSource::given)
      text += fmt::format(", stretch {}, compress {}, shear {}", object.scene.limits.given.stretch[0],
                          object.scene.limits.given.compress[0], object.scene.limits.given.shear[0][1]);
  }
  return text + "\n";
}

std::string in_words(const deform::Drive& drive) {
  const Eigen::Vector3d& by = drive.motion.by;
  std::string text = fmt::format("    object{} by ({}, {}, {}) m", drive.object, by[0], by[1], by[2]);
  if (drive.motion.angle != 0)
    text += fmt::format(", turned by {} about ({}, {}, {})", drive.motion.angle, drive.motion.axis[0],
                        drive.motion.axis[1], drive.motion.axis[2]);
  if (!drive.nodes.empty())
    text += fmt::format(", nodes {}", drive.nodes);
  if (drive.slides)
    text += ", slides";
  if (drive.lead)
    text += fmt::format(", led by {} N/m", drive.lead->stiffness);
  return text + "\n";
}

} // namespace

WorldPlay random_world(Choices& choices) {
  WorldPlay play;
  play.scene.name = play.scene.title = "random";
  choose_laws(choices, play);
  choose_objects(choices, play.scene);
  choose_frames(choices, play);
  return play;
}

std::string in_words(const WorldPlay& play) {
  const WorldScene& world = play.scene;
  std::string text = fmt::format("a world of {} cells of {} m, method {}, contact {}, friction {}\n",
                                 world.cells, world.spacing[0], world.method,
                                 world.contact == ContactLaw::cells ? "cells" : "surfaces", world.friction);
  if (world.dynamics)
    text += fmt::format("  gravity {}, restitution {}, damping {}, frames of {} s\n", world.dynamics->gravity,
                        world.dynamics->restitution, world.dynamics->damping, play.frame_seconds);
  for (const WorldObject& object : world.objects)
    text += in_words(object, world);
  for (const PlayFrame& frame : play.frames) {
    text += frame.rounds ? fmt::format("  a frame of {} rounds at most\n", *frame.rounds) : "  a frame\n";
    for (const int object : frame.released)
      text += fmt::format("    object{} is released\n", object);
    for (const deform::Drive& drive : frame.drives)
      text += in_words(drive);
  }
  return text;
}

} // namespace maille::lab
