#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "json_parts.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <map>
#include <optional>

namespace maille::studies {

namespace {

/// What a body holds of one label, or of one material where it has no labels.
struct Part {
  std::optional<std::int32_t> label;
  std::uint8_t material = 0;
  std::int64_t cells = 0;
  double size = 0; ///< m^3; m^2 in 2D, m in 1D
};

std::vector<Part> parts_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  std::map<std::pair<std::int32_t, std::uint8_t>, std::int64_t> cells;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      ++cells[{body.label.empty() ? 0 : body.label[static_cast<std::size_t>(cell)], body.material(cell)}];
  double of_cell = 1;
  for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimension()); ++a)
    of_cell *= body.grid.spacing()[a];
  std::vector<Part> parts;
  for (const auto& [key, count] : cells)
    parts.push_back({body.label.empty() ? std::nullopt : std::optional(key.first), key.second, count,
                     static_cast<double>(count) * of_cell});
  return parts;
}

std::string size_of(const Part& part, int dimension) {
  constexpr std::array<const char*, 3> units{"mm", "mm^2", "mm^3"};
  return fmt::format("{:.5g} {}", part.size * std::pow(1e3, dimension),
                     units[static_cast<std::size_t>(dimension) - 1]);
}

std::string table_of(const Scene& scene) {
  std::string text = fmt::format("{:<8}{:>10}  {:>16}  {}\n", "label", "voxels",
                                 scene.dimension() == 3 ? "volume" : "size", "material");
  for (const Part& part : parts_of(scene))
    text += fmt::format("{:<8}{:>10}  {:>16}  {}\n", part.label ? fmt::format("{}", *part.label) : "-",
                        part.cells, size_of(part, scene.dimension()), scene.materials[part.material].name);
  return text;
}

/// Each body of a world for itself.
std::string proportions_of(const WorldScene& world) {
  std::string text;
  for (const WorldObject& object : world.objects) {
    const Plausibility found = plausibility(object.scene);
    text += fmt::format("{}: size {}\n", object.name, size_in_words(object.scene, found.size));
    for (const std::string& warning : found.warnings)
      text += fmt::format("warning: {}: {}\n", object.name, warning);
  }
  return text;
}

/// @throws InputError also where every method would refuse the numbers
SceneAndMeasures checked_scene(const std::filesystem::path& file) {
  SceneAndMeasures read = read_scene_and_measures(file);
  if (const std::string reason = unusable_number(read.scene); !reason.empty())
    throw InputError({{file.string(), 0, "", "numbers that methods can reckon with", reason}});
  return read;
}

nlohmann::ordered_json in_json(const CommonOptions& options) {
  nlohmann::ordered_json out{{"scene", options.scene.string()}, {"faults", nlohmann::ordered_json::array()}};
  try {
    if (is_world_scene(options.scene)) {
      world_of(read_world_scene(options.scene), options.scene);
      return out;
    }
    const auto [scene, measures] = checked_scene(options.scene);
    out.update(studies::in_json(plausibility(scene)));
    for (const Part& part : parts_of(scene)) {
      out["parts"].push_back({{"label", nullptr},
                              {"voxels", part.cells},
                              {"volume_m3", part.size},
                              {"material", scene.materials[part.material].name}});
      if (part.label)
        out["parts"].back()["label"] = *part.label;
    }
    for (const Measure& measure : measures)
      out["measures"].push_back({{"name", measure.name},
                                 {"unit", unit_of(measure, scene.dimension())},
                                 {"meaning", in_words(measure)}});
  } catch (const InputError& error) {
    out["faults"] = faults_json(error.faults());
  }
  return out;
}

} // namespace

int check_command(const CommonOptions& options) {
  if (options.json) {
    const auto out = in_json(options);
    deliver(json_text(out), options.json);
    return out["faults"].empty() ? exit_done : exit_faulty_input;
  }
  if (is_world_scene(options.scene)) { // faults are reported by main
    const WorldScene world = read_world_scene(options.scene);
    const deform::World made = world_of(world, options.scene);
    std::string text =
        fmt::format("{}: no faults; {}\n{}", options.scene.string(), in_words(world), proportions_of(world));
    for (int object = 0; object < made.n_objects(); ++object)
      if (made.kind(object) == ObjectKind::deformable && !made.is_closed(object))
        text += fmt::format("not kept apart for certain: where `{}` is stretched, things as small as a "
                            "cell come between its nodes (docs/contact.md)\n",
                            world.objects[static_cast<std::size_t>(object)].name);
    deliver(text, std::nullopt);
    return exit_done;
  }
  const auto [scene, measures] = checked_scene(options.scene);
  const Plausibility proportions = plausibility(scene);
  std::string text = fmt::format(
      "{}: no faults; {}D, {} cells, {} nodes, {} material{}, {} prescribed components\n{}\n",
      options.scene.string(), scene.dimension(), scene.specimen.n_matter_cells(),
      scene.specimen.n_matter_nodes(), scene.materials.size(), scene.materials.size() == 1 ? "" : "s",
      scene.prescribed.size(), maille::in_words(scene, proportions));
  for (const std::string& warning : proportions.warnings)
    text += fmt::format("warning: {}\n", warning);
  text += table_of(scene);
  if (scene.specimen.fibre_report.source == "tensor_image")
    text += fmt::format("fibres: {}\n", in_words(scene.specimen.fibre_report));
  for (const Measure& measure : measures)
    text += fmt::format("measure {}: {}\n", measure.name, in_words(measure));
  for (const LeftOutPiece& piece : scene.left_out)
    text += fmt::format("left out: {}\n", piece.name);
  deliver(text, std::nullopt);
  return exit_done;
}

} // namespace maille::studies
