#include "maille/scene/read_scene.hpp"

#include "maille/materials/library.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/fibre/fibre_field.hpp"
#include "read/measures.hpp"
#include "read/reader.hpp"

#include <utility>
#include <vector>

namespace maille {

namespace {

void read_given_limits(TableReader& table, LimitSettings& limits) {
  for (const char* key : {"stretch", "compress", "shear"})
    table.require(key);
  if (const auto given = read_neighbour_limits(table))
    limits.given = *given;
}

/// Tissues with measured failure data, for messages.
std::string known_to_fail() {
  std::string names;
  for (const LibraryEntry& entry : material_library())
    if (entry.material.damage)
      names += (names.empty() ? "" : ", ") + entry.material.name;
  return names;
}

} // namespace

void reader::check_limit_source(const Scene& scene, const std::string& path, int line, FaultList& faults) {
  for (const Material& material : scene.materials)
    if (scene.limits.from == LimitSource::material && !material.limits)
      faults.add(line, path, "a material that has limits of its own (or from = \"taut\")", material.name);
    else if (scene.limits.from == LimitSource::failure && !material.damage)
      faults.add(line, path,
                 "a material of which the stretch at failure is known: damage = { stretch = ... } in its "
                 "table, or one of " +
                     known_to_fail(),
                 material.name);
}

void reader::read_limits(TableReader& root, Scene& scene) {
  auto section = root.open("limits");
  if (!section)
    return;
  TableReader& table = *section;
  const bool has_source = table.read("from", scene.limits.from);
  if (scene.limits.from == LimitSource::given)
    read_given_limits(table, scene.limits);
  else
    for (const char* key : {"stretch", "compress", "shear"})
      table.refuse(key, "no such key unless from = \"given\"");
  if (has_source)
    check_limit_source(scene, table.path_of("from"), table.line_of_key("from"), table.faults());
  scene.limits.cut_is_allowed = table.choice("cut") == "allowed";
  table.finish();
}

void reader::read_relaxation(TableReader& root, Scene& scene) {
  auto section = root.open("relaxation");
  if (!section)
    return;
  TableReader& table = *section;
  RelaxationSettings& relaxation = scene.relaxation;
  table.read("mode", relaxation.mode);
  table.read("tolerance", relaxation.tolerance);
  table.read("extrapolation", relaxation.extrapolation);
  table.read("sweeps", relaxation.sweeps);
  if (const auto frame = table.choice("frame")) { // old key, from the time of linear laws only
    const Strain meant = *frame == "blocks" ? Strain::finite : scene.strain;
    if (root.has("strain") && (meant != scene.strain || (*frame == "object" && meant == Strain::finite)))
      table.fault("frame", "no other word than `strain`, or no such key");
    scene.strain = meant;
  }
  table.read("increments", relaxation.increments);
  if (table.has("increments") && scene.strain != Strain::finite)
    scene.left_out.push_back({0, table.path_of("increments") + " has no effect without strain = \"finite\""});
  table.finish();
}

namespace {

/// `lattice = "fibre"`: converts the scene after reading, so that faults refer to the original axes.
void turn_lattice(int line, FaultList& faults, Scene& scene) {
  auto turned = on_fibre_lattice(scene);
  if (const auto* refusal = std::get_if<LatticeRefusal>(&turned))
    faults.add(line, "specimen.lattice", refusal->expected + " for \"fibre\"", refusal->found);
  else
    scene = std::move(std::get<Scene>(turned));
}

/// @param given image of the body, instead of a file; null: none
SceneAndMeasures read_root(const toml::table& document, const std::filesystem::path& file, FaultList& faults,
                           const Image* given) {
  SceneAndMeasures read;
  Scene& scene = read.scene;
  scene.name = file.stem().string();
  TableReader root(document, "", faults, "scene");
  if (root.has("world")) {
    root.fault("world", "a scene with a [specimen]: worlds of objects are for `maille play`", "a [world]");
    return read;
  }
  read_units(root);
  scene.title = root.text("title").value_or(scene.name);
  root.read("strain", scene.strain);
  bool body = false;
  int turned_lattice_line = 0;
  std::vector<float> labels; // of cells, if loads name labels
  if (root.require("specimen"))
    if (auto specimen = root.open("specimen")) {
      if (specimen->choice("lattice") == "fibre")
        turned_lattice_line = line_of(*specimen->find("lattice"));
      body = reader::read_specimen(*specimen, scene, reader::asks_for_labels(document) ? &labels : nullptr,
                                   given);
    }
  reader::read_limits(root, scene);
  reader::read_relaxation(root, scene);
  reader::read_conditions(root, document, scene, labels, body);
  read.measures = reader::read_measures(root, scene, body);
  root.finish();
  if (turned_lattice_line > 0 && !read.measures.empty())
    faults.add(turned_lattice_line, "specimen.lattice",
               "\"grid\" with a [[measure]], whose places are along its axes", "\"fibre\"");
  if (turned_lattice_line > 0 && scene.test)
    faults.add(turned_lattice_line, "specimen.lattice", "\"grid\" with a [test], which is along its axes",
               "\"fibre\"");
  if (turned_lattice_line > 0 && faults.empty())
    turn_lattice(turned_lattice_line, faults, scene);
  return read;
}

} // namespace

SceneAndMeasures parse_scene_and_measures(std::string_view text, const std::filesystem::path& file) {
  return reader::scene_of(parse_toml(text, file.string()), file);
}

SceneAndMeasures reader::scene_of(const toml::table& document, const std::filesystem::path& file,
                                  const Image* given) {
  FaultList faults(file.string());
  SceneAndMeasures read = read_root(document, file, faults, given);
  faults.throw_if_any();
  return read;
}

SceneAndMeasures read_scene_and_measures(const std::filesystem::path& file) {
  return parse_scene_and_measures(read_text_file(file, "a scene file"), file);
}

Scene parse_scene(std::string_view text, const std::filesystem::path& file) {
  return parse_scene_and_measures(text, file).scene;
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_text_file(file, "a scene file"), file);
}

bool reader::is_set(const std::filesystem::path& file, std::string_view key) {
  try {
    return bool(parse_toml(read_text_file(file, "a scene file"), file.string()).at_path(key));
  } catch (const InputError&) {
    return false;
  }
}

} // namespace maille
