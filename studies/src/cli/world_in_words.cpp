#include "world_in_words.hpp"

#include "cli/commands.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/materials/fault.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace maille::studies {

namespace {

const char* name_of(ObjectKind kind) {
  return kind == ObjectKind::fixed ? "fixed" : kind == ObjectKind::rigid ? "rigid" : "deformable";
}

std::int64_t count(const WorldScene& scene, ObjectKind kind) {
  return std::ranges::count(scene.objects, kind, &WorldObject::kind);
}

std::string cells_in_words(const WorldScene& scene) {
  std::string text = fmt::format("{}", scene.cells[0]);
  for (std::size_t a = 1; a < static_cast<std::size_t>(scene.dimension); ++a)
    text += fmt::format(" x {}", scene.cells[a]);
  return text;
}

struct Part {
  bool is_on;
  std::string name, why;
};

/// What a world has and pays for.
std::vector<Part> parts_of(const WorldScene& scene) {
  const std::int64_t deformable = count(scene, ObjectKind::deformable);
  return {
      {count(scene, ObjectKind::rigid) > 0, "rigid objects", "exact first contacts, no limits, no method"},
      {deformable > 0, "deformable objects",
       deformable > 0 ? "their nodes are followed from cell to cell; " + scene.method + " relaxes them"
                      : "no links, no limits, no method"},
      {scene.friction > 0, "friction",
       scene.friction > 0 ? fmt::format("coefficient {}", scene.friction) : "contacts slide freely"},
      {scene.frame_budget.has_value(), "frame_budget",
       scene.frame_budget ? fmt::format("a frame ends after {} s, settled or not", *scene.frame_budget)
                          : "frames end when they have settled"}};
}

} // namespace

std::string in_words(const WorldScene& scene) {
  return fmt::format("{}D world of {} cells, {} fixed, {} rigid, {} deformable object{}", scene.dimension,
                     cells_in_words(scene), count(scene, ObjectKind::fixed), count(scene, ObjectKind::rigid),
                     count(scene, ObjectKind::deformable), scene.objects.size() == 1 ? "" : "s");
}

deform::World world_of(const WorldScene& scene, const std::filesystem::path& file) {
  try {
    return deform::World(scene);
  } catch (const std::invalid_argument& error) {
    throw InputError(
        {{file.string(), 0, "object", "objects that fit into the world and keep apart", error.what()}});
  }
}

std::string explanation(const WorldScene& scene, const deform::World& world) {
  std::string text = fmt::format("{}\n{}\n\n", scene.title, in_words(scene));
  for (const Part& part : parts_of(scene))
    text += fmt::format("{:<4}{:<20}{}\n", part.is_on ? "on" : "off", part.name, part.why);
  text += fmt::format("\n{:<20}{:<12}{:<14}{:>10}\n", "object", "kind", "shape", "voxels");
  for (const WorldObject& object : scene.objects) {
    const Specimen& body = object.scene.specimen;
    text +=
        fmt::format("{:<20}{:<12}{:<14}{:>10}\n", object.name, name_of(object.kind), body.shape,
                    object.kind == ObjectKind::deformable ? body.n_matter_nodes() : body.n_matter_cells());
  }
  const std::int64_t map = world.map().bytes();
  return text + fmt::format("\noccupancy map {} bytes, objects {} bytes\n", map, world.bytes() - map);
}

nlohmann::ordered_json explanation_in_json(const WorldScene& scene, const deform::World& world) {
  nlohmann::ordered_json out{{"scene", scene.name},
                             {"dimension", scene.dimension},
                             {"cells", scene.cells},
                             {"method", scene.method}};
  for (const Part& part : parts_of(scene))
    out["parts"].push_back({{"name", part.name}, {"on", part.is_on}, {"why", part.why}});
  for (const WorldObject& object : scene.objects)
    out["objects"].push_back({{"name", object.name},
                              {"kind", name_of(object.kind)},
                              {"shape", object.scene.specimen.shape},
                              {"cells", object.scene.specimen.n_matter_cells()},
                              {"nodes", object.scene.specimen.n_matter_nodes()}});
  out["memory"] = {{"map", world.map().bytes()}, {"objects", world.bytes() - world.map().bytes()}};
  return out;
}

} // namespace maille::studies
