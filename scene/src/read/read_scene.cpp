#include "maille/scene/read_scene.hpp"

#include "maille/materials/library.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/fibre/fibre_lattice.hpp"
#include "read/measures.hpp"
#include "read/reader.hpp"

#include <array>
#include <tuple>
#include <utility>
#include <vector>

namespace maille {

namespace {

void read_given_limits(TableReader& table, LimitSettings& limits) {
  for (const char* key : {"stretch", "compress", "shear"})
    table.require(key, "given limits need stretch, compress and shear");
  if (const auto given = read_neighbour_limits(table))
    limits.given = *given;
}

constexpr std::array<std::pair<std::string_view, LimitSource>, 5> sources{
    {{"none", LimitSource::none},
     {"material", LimitSource::material},
     {"taut", LimitSource::taut},
     {"given", LimitSource::given},
     {"failure", LimitSource::failure}}};

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
  const toml::table* section = root.subtable("limits");
  if (!section)
    return;
  TableReader table(*section, root.path_of("limits"), root.faults());
  const auto from = table.choice("from", {"none", "material", "taut", "given", "failure"});
  for (const auto& [name, source] : sources)
    if (from == name)
      scene.limits.from = source;
  if (scene.limits.from == LimitSource::given)
    read_given_limits(table, scene.limits);
  else
    for (const char* key : {"stretch", "compress", "shear"})
      if (const toml::node* node = table.find(key))
        table.fault(key, "no such key unless from = \"given\"", describe(*node));
  if (from)
    check_limit_source(scene, table.path_of("from"), table.line_of_key("from"), table.faults());
  scene.limits.cut_is_allowed = table.choice("cut", {"refused", "allowed"}) == "allowed";
  table.finish();
}

void reader::read_relaxation(TableReader& root, Scene& scene) {
  const toml::table* section = root.subtable("relaxation");
  if (!section)
    return;
  TableReader table(*section, root.path_of("relaxation"), root.faults());
  if (const auto mode = table.choice("mode", {"elastic", "deformable"}))
    scene.relaxation.mode = *mode == "elastic" ? RelaxationMode::elastic : RelaxationMode::deformable;
  if (const auto tolerance = table.quantity("tolerance", Dimension::dimensionless)) {
    if (*tolerance > 0 && *tolerance < 1)
      scene.relaxation.tolerance = *tolerance;
    else
      table.fault("tolerance", wanted_tolerance, describe(*table.find("tolerance")));
  }
  if (const auto extrapolation = table.choice("extrapolation", {"none", "nested"}))
    scene.relaxation.extrapolation = *extrapolation == "nested" ? Extrapolation::nested : Extrapolation::none;
  if (const auto sweeps = table.integer("sweeps", 1, most_sweeps))
    scene.relaxation.sweeps = *sweeps;
  if (const auto frame = table.choice("frame", {"object", "blocks"}))
    scene.relaxation.frame = *frame == "object" ? StrainFrame::object : StrainFrame::blocks;
  if (const auto increments = table.integer("increments", 1, most_increments))
    scene.relaxation.increments = static_cast<int>(*increments);
  if (table.has("increments") && scene.relaxation.frame != StrainFrame::blocks)
    scene.left_out.push_back({0, table.path_of("increments") + " has no effect without frame = \"blocks\""});
  table.finish();
}

namespace {

/// `lattice = "fibre"`: everything was read on the lattice along the axes, where its faults make sense.
void turn_lattice(int line, FaultList& faults, Scene& scene) {
  auto turned = on_fibre_lattice(scene);
  if (const auto* refusal = std::get_if<LatticeRefusal>(&turned))
    faults.add(line, "specimen.lattice", refusal->expected + " for \"fibre\"", refusal->found);
  else
    scene = std::move(std::get<Scene>(turned));
}

/// @param given of the body, in place of a file that the scene names; null: none is
SceneAndMeasures read_root(const toml::table& document, const std::filesystem::path& file, FaultList& faults,
                           const Image* given = nullptr) {
  SceneAndMeasures read;
  Scene& scene = read.scene;
  scene.name = file.stem().string();
  TableReader root(document, "", faults);
  if (root.has("world")) {
    root.fault("world", "a scene with a [specimen]: worlds of objects are for `maille play`", "a [world]");
    return read;
  }
  read_units(root);
  scene.title = root.text("title").value_or(scene.name);
  bool body = false;
  int turned_lattice_line = 0;
  std::vector<float> labels; // of cells, where loads name them
  if (root.require("specimen", "a [specimen] table"))
    if (const toml::table* section = root.subtable("specimen")) {
      TableReader specimen(*section, "specimen", faults);
      if (specimen.choice("lattice", {"grid", "fibre"}).value_or("grid") == "fibre")
        turned_lattice_line = line_of(*specimen.find("lattice"));
      body = reader::read_specimen(specimen, file.parent_path(), scene,
                                   reader::asks_for_labels(document) ? &labels : nullptr, given);
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
  FaultList faults(file.string());
  const toml::table document = parse_toml(text, file.string());
  SceneAndMeasures read = read_root(document, file, faults);
  faults.throw_if_any();
  return read;
}

SceneAndMeasures reader::parse_scene_of(const Image& image, std::string_view text,
                                        const std::filesystem::path& file) {
  FaultList faults(file.string());
  const toml::table document = parse_toml(text, file.string());
  SceneAndMeasures read = read_root(document, file, faults, &image);
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
