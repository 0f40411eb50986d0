/// Worlds whose objects are turned, unlike in spacing, squeezed, or rub on one another.

#include "stability/world_questions.hpp"

#include "checks/random_scene.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace maille::lab {

namespace {

using deform::World;
using Eigen::Vector3d;

const std::vector<std::string> by_cells{"limits", "relaxed", "coupled"}, by_surfaces{"coupled"};

/// A closed room, its walls one of its cells thick, in the middle of a world; in it a tool and a soft box. A
/// hand drives the tool about, through everything if it could.
struct Room {
  int dimension;
  double spacing; ///< of the walls' cells [cells of the world]
  double of_tool; ///< likewise
  double of_body; ///< likewise
  double angle;   ///< of the room; the tool is turned the other way by half of it
  ContactLaw contact = ContactLaw::cells;
};

/// Within its walls [cells of the world]: tool and body fit in at any turn.
double room_length(int dimension) {
  return dimension == 3 ? 20 : 16;
}

Vec3 corner_at(int dimension, double x) {
  return dimension == 3 ? Vec3{x, x, x} : Vec3{x, x, 0};
}

WorldPlay room_with_a_tool(const Room& room, const std::string& method, int frames) {
  const int d = room.dimension, n = static_cast<int>(std::lround(room_length(d) / room.spacing)) + 2;
  const int cells = static_cast<int>(std::ceil(1.8 * n * room.spacing)) + 2;
  WorldPlay play;
  play.scene = empty_world(std::vector<int>(static_cast<std::size_t>(d), cells), method, room.contact);
  WorldScene& world = play.scene;
  const auto cube = [&](int edge) { return std::vector<int>(static_cast<std::size_t>(d), edge); };
  const double middle = 0.5 * cells;
  WorldObject walls = box_in(world, ObjectKind::fixed, cube(n), room.spacing,
                             corner_at(d, middle - 0.5 * n * room.spacing), room.angle);
  const Grid& grid = walls.scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    bool is_within = true;
    for (std::size_t a = 0; a < static_cast<std::size_t>(d); ++a)
      is_within = is_within && at[a] > 0 && at[a] < n - 1;
    walls.scene.specimen.material_id.push_back(is_within ? no_material : std::uint8_t{0});
  }
  world.objects.push_back(walls);
  const int edge_of_body = std::max(1, static_cast<int>(std::lround(3 / room.of_body))),
            edge_of_tool = std::max(1, static_cast<int>(std::lround(2 / room.of_tool)));
  world.objects.push_back(
      box_in(world, ObjectKind::deformable, cube(edge_of_body), room.of_body, corner_at(d, middle - 5), 0));
  world.objects.push_back(box_in(world, ObjectKind::rigid, cube(edge_of_tool), room.of_tool,
                                 corner_at(d, middle + 0.5), -0.5 * room.angle));
  Choices choices(17);
  for (int frame = 0; frame < frames; ++frame) {
    deform::Drive drive = shift_of(world, 2, {0, 0, 0});
    for (int a = 0; a < d; ++a)
      drive.motion.by[a] = world_cell * (frame % 3 == 0 ? 30 : 5) * (1 - 2 * choices.uniform());
    drive.motion.angle = frame % 4 == 1 ? 1 - 2 * choices.uniform() : 0;
    drive.slides = frame % 2 == 0;
    play.frames.push_back({.drives = {drive}, .released = {}, .rounds = 200});
  }
  return play;
}

/// Nothing leaves a closed room: middles of tool and body are within its walls.
LookAtFrame nothing_gets_out(const WorldPlay& play) {
  const WorldObject& walls = play.scene.objects[0];
  const Grid& grid = walls.scene.specimen.grid;
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(walls.turn_angle, Vector3d::Map(walls.turn_axis.data())).toRotationMatrix();
  const Vector3d corner = Vector3d::Map(walls.position.data());
  const double thickness = grid.spacing()[0], length = thickness * grid.cells()[0];
  return [=, d = play.scene.dimension](const World& world, const deform::FrameResult&) -> std::string {
    const auto is_in = [&](const Vector3d& x) {
      const Vector3d at = rotation.transpose() * (x - corner);
      return at.head(d).minCoeff() > thickness && at.head(d).maxCoeff() < length - thickness;
    };
    const Grid& body = world.scene().objects[1].scene.specimen.grid;
    Vector3d mean = Vector3d::Zero();
    for (std::int64_t node = 0; node < body.n_nodes(); ++node)
      mean += world.position(1, node) / static_cast<double>(body.n_nodes());
    const Grid& tool = world.scene().objects[2].scene.specimen.grid;
    Vector3d half = Vector3d::Zero();
    for (int a = 0; a < d; ++a)
      half[a] = 0.5 * tool.spacing()[0] * tool.cells()[0];
    if (!is_in(world.pose(2).position + world.pose(2).rotation * half))
      return "the tool has left a closed room";
    return is_in(mean) ? "" : "the soft box has left a closed room";
  };
}

void add_rooms(std::vector<Extreme>& list, int frames) {
  const auto add_room = [&](const char* extreme, const std::string& setting, const Room& room,
                            bool is_normal) {
    add({.extreme = extreme,
         .setting = setting,
         .methods = room.contact == ContactLaw::cells ? by_cells : by_surfaces,
         .play = [=](const std::string& method) { return room_with_a_tool(room, method, frames); },
         .look = nothing_gets_out,
         .is_normal = is_normal},
        list);
  };
  const char* const turned = "worlds: a tool in a turned room";
  for (const int dimension : {2, 3})
    for (const int angle : {0, 10, 30, 45, 90, 133})
      add_room(turned,
               fmt::format("{}D, {} deg{}", dimension, angle, dimension == 2 && angle == 0 ? ", normal" : ""),
               {dimension, 1, 1, 1, angle * std::numbers::pi / 180}, dimension == 2 && angle == 0);
  for (const int angle : {0, 30, 45})
    add_room(turned, fmt::format("2D, {} deg, surfaces", angle),
             {2, 1, 1, 1, angle * std::numbers::pi / 180, ContactLaw::surfaces}, false);
  const char* const spacings = "worlds: spacings over the world's";
  for (const double of_room : {1.0, 0.25, 0.5, 2.0, 4.0})
    for (const double of_others : {1.0, 0.25, 4.0})
      for (const double angle : {0.0, 0.6})
        add_room(spacings,
                 fmt::format("room {:g}, tool and body {:g}{}{}", of_room, of_others,
                             angle > 0 ? ", turned" : "",
                             of_room == 1 && of_others == 1 && angle == 0 ? ", normal" : ""),
                 {2, of_room, of_others, of_others, angle}, of_room == 1 && of_others == 1 && angle == 0);
  for (const double of_others : {0.25, 4.0})
    add_room(spacings, fmt::format("room 1, tool and body {:g}, turned, 3D", of_others),
             {3, 1, of_others, of_others, 0.6}, false);
}

/// A block, held below, under a plate that comes down by a part of its height.
WorldPlay squeezed(int dimension, double part, const std::string& method, ContactLaw contact, int frames) {
  const int edge = dimension == 2 ? 8 : 4;
  const auto d = static_cast<std::size_t>(dimension);
  WorldPlay play;
  play.scene = empty_world(std::vector<int>(d, 3 * edge), method, contact);
  WorldScene& world = play.scene;
  world.objects.push_back(
      box_in(world, ObjectKind::deformable, std::vector<int>(d, edge), 1, corner_at(dimension, edge)));
  hold_face(world.objects[0], dimension - 1, false);
  std::vector<int> plate(d, 3 * edge - 2);
  plate.back() = 1;
  Vec3 corner = corner_at(dimension, 1);
  corner[d - 1] = 2 * edge + 1;
  world.objects.push_back(box_in(world, ObjectKind::rigid, plate, 1, corner));
  Vec3 by{};
  by[d - 1] = -(part * edge + 1) / frames;
  repeat(play, shift_of(world, 1, by), frames);
  by[d - 1] = -by[d - 1]; // and up again
  repeat(play, shift_of(world, 1, by), frames);
  return play;
}

void add_squeezed(std::vector<Extreme>& list, int frames) {
  for (const int dimension : {2, 3})
    for (const ContactLaw contact : {ContactLaw::cells, ContactLaw::surfaces})
      for (const double part : {0.1, 0.5, 0.9, 0.99}) {
        const bool is_normal = dimension == 2 && contact == ContactLaw::cells && part == 0.1;
        add({.extreme = "worlds: a block squeezed by a plate",
             .setting = fmt::format("{}D, by {:g} of its height{}{}", dimension, part,
                                    contact == ContactLaw::surfaces ? ", surfaces" : "",
                                    is_normal ? ", normal" : ""),
             .methods = contact == ContactLaw::cells ? by_cells : by_surfaces,
             .play =
                 [=](const std::string& method) {
                   return squeezed(dimension, part, method, contact, frames);
                 },
             .is_normal = is_normal},
            list);
      }
}

/// A plate presses a block and goes aside.
WorldPlay rubbed(double friction, const std::string& method, ContactLaw contact, int frames) {
  WorldPlay play = squeezed(2, 0.2, method, contact, 1);
  play.scene.friction = friction;
  play.scene.objects[1].scene.specimen.grid = Grid(2, {18, 1, 1}, {world_cell, world_cell, world_cell});
  play.scene.objects[1].position[0] = 3 * world_cell;
  play.frames.pop_back(); // stays down
  repeat(play, shift_of(play.scene, 1, {0.5, 0, 0}), frames);
  repeat(play, shift_of(play.scene, 1, {-0.5, 0, 0}), 2 * frames);
  return play;
}

/// Coulomb's law for all places together at which the plate meets the block along one axis, in frames that
/// have settled: what holds them is at most friction times what presses them.
LookAtFrame no_more_than_friction(const WorldPlay& play) {
  return [friction = play.scene.friction](const World&, const deform::FrameResult& result) -> std::string {
    constexpr double slip = 0.02, lean = 0.01; // twice what Settling grants; of faces that are dented
    if (!is_converged(result.status))
      return {};
    for (int axis = 0; axis < 2; ++axis) {
      Vector3d sum = Vector3d::Zero();
      for (const deform::WorldContact& contact : result.contacts)
        if (contact.object == 0 && contact.other == 1 && contact.axis == axis)
          sum += contact.force;
      const double presses = std::abs(sum[axis]), holds = std::abs(sum[1 - axis]);
      if (holds > friction * presses * (1 + slip) + lean * presses)
        return fmt::format("the plate holds with {:.3g} N and presses with {:.3g} N", holds, presses);
    }
    return {};
  };
}

void add_rubbed(std::vector<Extreme>& list, int frames) {
  for (const ContactLaw contact : {ContactLaw::cells, ContactLaw::surfaces})
    for (const double friction : {0.0, 0.3, 1.0, 3.0, 10.0}) {
      const bool is_normal = contact == ContactLaw::cells && friction == 0;
      add({.extreme = "worlds: friction",
           .setting = fmt::format("{:g}{}{}", friction, contact == ContactLaw::surfaces ? ", surfaces" : "",
                                  is_normal ? ", normal" : ""),
           .methods =
               contact == ContactLaw::cells ? std::vector<std::string>{"relaxed", "coupled"} : by_surfaces,
           .play = [=](const std::string& method) { return rubbed(friction, method, contact, frames); },
           .look = no_more_than_friction,
           .is_normal = is_normal},
          list);
    }
}

} // namespace

void add_extremes_of_worlds(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  add_rooms(list, sizes.world_frames);
  add_squeezed(list, sizes.world_frames);
  add_rubbed(list, std::max(2, sizes.world_frames / 3));
}

} // namespace maille::lab
