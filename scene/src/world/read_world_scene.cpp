#include "maille/scene/world/world_scene.hpp"

#include "maille/base/arena.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "read/read_look.hpp"
#include "read/reader.hpp"
#include "world/object_shapes.hpp"
#include "world/trajectory_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace maille {

namespace {

constexpr int most_cells = std::numeric_limits<std::int16_t>::max() + 1; // of an occupancy map, along an axis

/// Minimum memory of the map of an empty world: a number per brick of 16^3 cells.
double map_bytes(const Index3& cells) {
  double bytes = sizeof(std::int32_t);
  for (const int n : cells)
    bytes *= std::ceil(n / 16.0);
  return bytes;
}

/// @return false if the world has no valid dimension, so that objects cannot be placed
bool read_cells_of_world(TableReader& table, WorldScene& world) {
  const auto cells = reader::read_cells(table);
  const auto spacing = reader::read_spacing(table, cells ? static_cast<int>(cells->size()) : 3, {});
  if (spacing)
    world.spacing = *spacing;
  if (!cells)
    return false;
  world.dimension = static_cast<int>(cells->size());
  std::ranges::copy(*cells, world.cells.begin());
  if (std::ranges::max(world.cells) > most_cells)
    table.fault("cells", fmt::format("at most {} cells along an axis", most_cells));
  else if (const double bytes = map_bytes(world.cells), free = static_cast<double>(available_memory());
           bytes > free)
    table.fault("cells",
                fmt::format("a world whose map fits into the {} of free memory", bytes_in_words(free)),
                bytes_in_words(bytes));
  return true;
}

/// `dynamics = { gravity = [0, "-9.81 m/s^2"], restitution = 0.5, damping = 0 }`.
void read_dynamics(TableReader& world_table, WorldScene& world) {
  auto table = world_table.open("dynamics");
  if (!table)
    return;
  WorldDynamics& dynamics = world.dynamics.emplace();
  if (world.contact != ContactLaw::surfaces)
    world_table.fault("dynamics", "contact = \"surfaces\", which knows impulses", "contact = \"cells\"");
  if (table->has("gravity"))
    dynamics.gravity = reader::read_vector(*table, "gravity", world.dimension).value_or(Vec3{});
  table->read("restitution", dynamics.restitution);
  table->read("damping", dynamics.damping);
  table->finish();
}

/// Density and velocity, if the world has dynamics.
void read_moving(TableReader& table, const WorldScene& world, WorldObject& object) {
  for (const char* key : {"density", "velocity"})
    if (table.has(key) && (!world.dynamics || object.kind == ObjectKind::fixed)) {
      const std::string found = reader::in_words(*table.find(key));
      table.fault(key, "no such key but of what moves in a world with `dynamics`", found);
    } else if (std::string_view(key) == "density") {
      table.read("density", object.density);
    } else if (table.has("velocity")) {
      object.velocity = reader::read_vector(table, "velocity", world.dimension).value_or(Vec3{});
    }
}

/// `surface = "smooth"`.
void read_surface(TableReader& table, const WorldScene& world, WorldObject& object) {
  object.is_smooth = table.choice("surface") == "smooth";
  if (object.is_smooth && (object.kind == ObjectKind::deformable || world.contact != ContactLaw::surfaces))
    table.fault("surface", "smooth: a fixed or rigid object of a world with contact = \"surfaces\"",
                object.kind == ObjectKind::deformable ? "kind = \"deformable\"" : "contact to a cell");
}

bool read_world(TableReader& root, WorldScene& world) {
  root.require("world");
  auto section = root.open("world");
  if (!section)
    return false;
  TableReader& table = *section;
  const bool has_cells = read_cells_of_world(table, world);
  table.read("friction", world.friction);
  world.frame_budget = table.number("frame_budget");
  world.method = table.choice("method").value_or(world.method);
  if (!table.read("contact", world.contact) && table.has("dynamics")) // the only law with impulses
    world.contact = ContactLaw::surfaces;
  read_dynamics(table, world);
  table.finish();
  return has_cells;
}

void read_name(TableReader& table, const WorldScene& world, WorldObject& object) {
  table.read("name", object.name);
  if (table.has("name") && object.name.empty() && table.find("name")->is_string())
    table.fault("name", "a name that is not empty");
  if (!object.name.empty() && reader::object_named(object.name, world))
    table.fault("name", "a name that no other object has", "\"" + object.name + "\" again");
}

void read_place(TableReader& table, int dimension, WorldObject& object) {
  if (table.has("position"))
    object.position = reader::read_vector(table, "position", dimension).value_or(Vec3{});
  bool has_no_point = true;
  if (dimension == 0) {
    table.find("turn"); // its keys depend on the dimension
  } else if (const auto turn = reader::read_turn(table, dimension, has_no_point)) {
    object.turn_axis = turn->axis;
    object.turn_angle = turn->angle;
    if (!has_no_point)
      table.fault("turn", "no `about`: the object's frame turns about its origin",
                  reader::in_words(*table.find("turn")));
  }
}

/// Keys of deformable objects beside the body; a fault for another kind.
void read_deformable(TableReader& table, const std::string& kind, bool has_body, Scene& scene) {
  if (kind == "deformable") {
    reader::read_limits(table, scene);
    reader::read_relaxation(table, scene);
    reader::read_holds(table, scene, has_body);
    return;
  }
  for (const char* key : {"limits", "relaxation", "hold"})
    if (table.has(key)) {
      table.find(key);
      if (!kind.empty())
        table.fault(key, "no such key unless kind = \"deformable\"", "kind = \"" + kind + "\"");
    }
}

void read_object(TableReader& table, bool has_cells, WorldScene& world) {
  WorldObject object;
  read_name(table, world, object);
  const std::string kind = table.choice("kind").value_or("");
  object.kind = kind == "deformable" ? ObjectKind::deformable
                : kind == "rigid"    ? ObjectKind::rigid
                                     : ObjectKind::fixed;
  object.scene.name = object.scene.title = object.name;
  reader::BodyDefaults defaults;
  defaults.has_material = object.kind == ObjectKind::deformable;
  defaults.spacing = world.spacing;
  const bool has_body = reader::read_object_body(table, defaults, object.scene);
  object.scene.specimen.placement = {}; // ignores the image: the scene defines the position
  if (has_body && has_cells && object.scene.dimension() != world.dimension)
    table.fault("shape", fmt::format("an object of dimension {}, as the world", world.dimension),
                fmt::format("one of dimension {}", object.scene.dimension()));
  read_place(table, has_cells ? world.dimension : 0, object);
  read_surface(table, world, object);
  if (has_cells)
    read_moving(table, world, object);
  read_deformable(table, kind, has_body, object.scene);
  reader::read_look(table); // only for its faults
  world.objects.push_back(std::move(object));
}

} // namespace

WorldScene parse_world_scene(std::string_view text, const std::filesystem::path& file) {
  FaultList faults(file.string());
  const toml::table document = parse_toml(text, file.string());
  WorldScene world;
  world.name = file.stem().string();
  TableReader root(document, "", faults, "scene");
  read_units(root);
  world.title = root.text("title").value_or(world.name);
  const bool has_cells = read_world(root, world);
  root.require("object");
  reader::for_each_table(root, "object", [&](TableReader& table) { read_object(table, has_cells, world); });
  for (const char* key : {"specimen", "hold", "move", "load", "limits", "relaxation"})
    if (root.has(key)) {
      root.find(key);
      root.fault(key, "no such key in a scene with a [world]: it belongs to an [[object]]", "one");
    }
  root.finish();
  faults.throw_if_any();
  return world;
}

WorldScene read_world_scene(const std::filesystem::path& file) {
  return parse_world_scene(read_text_file(file, "a scene file"), file);
}

bool is_world_scene(const std::filesystem::path& file) {
  return reader::is_set(file, "world");
}

} // namespace maille
