#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/worlds.hpp"
#include "explain_parts.hpp"
#include "maille/base/vectors.hpp"
#include "maille/deform/solve.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "results/scene_tables.hpp"
#include "study/plan/study.hpp"
#include "text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Size of the part of one label, or of one material without labels.
struct BodyPart {
  std::optional<std::int32_t> label;
  std::string material;
  std::int64_t cells = 0;
  double size = 0; ///< m^3; m^2 in 2D, m in 1D
  int dimension = 3;
};

/// Results of the check of a file.
struct CheckedMeasure {
  std::string name, unit, meaning;
};

struct Checked {
  std::string file, kind;                       ///< kind empty: a scene
  std::optional<std::int64_t> cases{}, bytes{}; ///< of a study; bytes of its lattice methods, at most
  double seconds = 0;                           ///< of all cases of a study on one thread; 0: unknown
  std::vector<Fault> faults{};
  std::optional<Plausibility> proportions{}; ///< for a scene with one body, like the next member
  std::vector<BodyPart> parts{};
  std::vector<StatedPart> conditions{};
  std::vector<MaterialSummary> materials{};
  std::vector<CheckedMeasure> measures{};
  std::optional<std::vector<std::string>> world_warnings{};
  std::string words{};
};

const ResultTable<CheckedMeasure>& columns_of_measures() {
  static const ResultTable<CheckedMeasure> table([](ResultTable<CheckedMeasure>& columns) {
    columns.add({"", "name", "", "as the scene has it"}, &CheckedMeasure::name);
    columns.add({"", "unit", "", "of its values"}, &CheckedMeasure::unit);
    columns.add({"", "meaning", "", "in words"}, &CheckedMeasure::meaning);
  });
  return table;
}

std::string size_in_words(const BodyPart& part) {
  constexpr std::array<const char*, 3> units{"mm", "mm^2", "mm^3"};
  return fmt::format("{:.5g} {}", part.size * std::pow(1e3, part.dimension),
                     units[static_cast<std::size_t>(part.dimension) - 1]);
}

const ResultTable<BodyPart>& columns_of_body() {
  static const ResultTable<BodyPart> table([](ResultTable<BodyPart>& columns) {
    columns.add({"", "label", "", "grey value of the image"}, {"label", -8}, &BodyPart::label);
    columns.add({"", "voxels", "", "of matter"}, {"voxels", 9}, &BodyPart::cells);
    columns.add({}, {"size", 17}, size_in_words);
    columns.add({"", "volume_m3", "m^3", "m^2 in 2D, m in 1D"}, &BodyPart::size);
    columns.add({"", "material", "", "its name"}, {"material"}, &BodyPart::material);
  });
  return table;
}

const ResultTable<StatedPart>& columns_of_conditions() {
  static const ResultTable<StatedPart> table([](ResultTable<StatedPart>& columns) {
    columns.add({"", "name", "", "`hold[1]`: the first [[hold]]"}, {"condition", -16}, &StatedPart::name);
    columns.add({"", "nodes", "", "that it is the first to ask for"}, {"nodes", 9}, &StatedPart::nodes);
    columns.add({}, {"area", 16},
                [](const StatedPart& part) { return fmt::format("{:.5g} mm^2", 1e6 * part.area); });
    columns.add({"", "area_m2", "m^2", "of outer faces, in 2D per metre of thickness"}, &StatedPart::area);
    columns.add({"", "share", "", "of the body's mean cross-section"}, {"of section", 12, in_percent},
                &StatedPart::share);
    columns.add({"", "where", "", "as the scene has it"}, {"where"}, &StatedPart::where);
  });
  return table;
}

const ResultTable<MaterialSummary>& columns_of_materials() {
  static const ResultTable<MaterialSummary> table([](ResultTable<MaterialSummary>& columns) {
    constexpr auto modulus = [](const MaterialSummary& of) {
      const auto [unit, name] = of.most >= 1e9   ? std::pair(1e9, "GPa")
                                : of.most >= 1e6 ? std::pair(1e6, "MPa")
                                                 : std::pair(1e3, "kPa");
      return of.least == of.most ? fmt::format("{:.4g} {}", of.most / unit, name)
                                 : fmt::format("{:.4g} to {:.4g} {}", of.least / unit, of.most / unit, name);
    };
    columns.add({"", "name", "", "as the scene has it"}, {"material", -28}, &MaterialSummary::name);
    columns.add({}, {"E", 28}, modulus);
    columns.add({"", "least_modulus", "Pa", "Young's, of all axes and cells"}, &MaterialSummary::least);
    columns.add({"", "largest_modulus", "Pa", "the same"}, &MaterialSummary::most);
    columns.add({}, {"density", 16},
                [](const MaterialSummary& of) { return fmt::format("{:.5g} kg/m^3", of.density); });
    columns.add({"", "density", "kg/m^3", "that gravity takes"}, &MaterialSummary::density);
    columns.add({"", "fibre", "", "where its direction is from"}, {"fibre"}, &MaterialSummary::fibre);
  });
  return table;
}

const ResultTable<Checked>& columns_of_check() {
  static const ResultTable<Checked> table([](ResultTable<Checked>& columns) {
    const auto has_body = [](const Checked& of) { return of.proportions.has_value(); };
    columns.add({"", "scene", "", "the file"}, &Checked::file);
    columns.add({"", "kind", "", "study, trajectory or material; of scenes none"}, &Checked::kind)
        .json_where([](const Checked& of) { return !of.kind.empty(); });
    columns.add_rows({"", "faults", "", "all of them"}, columns_of_faults(), &Checked::faults);
    columns.add({"", "cases", "", "of a study"}, &Checked::cases).json_where([](const Checked& of) {
      return of.cases.has_value();
    });
    columns.add({"", "bytes_at_most", "B", "one case of a study by its lattice methods"}, &Checked::bytes)
        .json_where([](const Checked& of) { return of.bytes.has_value(); });
    columns
        .add({"", "seconds", "s", "all cases of a study on one thread, within a factor of three"},
             &Checked::seconds)
        .json_where([](const Checked& of) { return of.seconds > 0; });
    add_plausibility(columns, has_body, &Checked::proportions);
    columns.add({"", "warnings", "", "of a world"}, &Checked::world_warnings)
        .json_where([](const Checked& of) { return of.world_warnings.has_value(); });
    columns.add_rows({"", "parts", "", "a row a label, else a material"}, columns_of_body(), &Checked::parts)
        .json_where(has_body);
    columns
        .add_rows({"", "conditions", "", "holds, moves and loads"}, columns_of_conditions(),
                  &Checked::conditions)
        .json_where(has_body);
    columns.add_rows({"", "materials", "", "of the body"}, columns_of_materials(), &Checked::materials)
        .json_where(has_body);
    columns
        .add_rows({"", "measures", "", "that the scene asks for"}, columns_of_measures(), &Checked::measures)
        .json_where([](const Checked& of) { return !of.measures.empty(); });
  });
  return table;
}

std::vector<BodyPart> parts_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  struct Content {
    std::int64_t cells = 0;
    double tissue = 0;
  };
  std::map<std::pair<std::int32_t, std::uint8_t>, Content> contents;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      Content& content = contents[{body.label.empty() ? 0 : body.label[cell], body.material(cell)}];
      ++content.cells;
      content.tissue += body.tissue_of(cell);
    }
  const double of_cell = cell_volume(body.grid);
  std::vector<BodyPart> parts;
  for (const auto& [key, content] : contents)
    parts.push_back({body.label.empty() ? std::nullopt : std::optional(key.first),
                     scene.materials[key.second].name, content.cells, content.tissue * of_cell,
                     scene.dimension()});
  return parts;
}

/// @throws InputError also if every method would refuse the numbers
void check_scene(Checked& checked) {
  const auto [scene, measures] = read_scene_and_measures(checked.file);
  if (const std::string reason = unusable_number(scene); !reason.empty())
    throw InputError({{checked.file, 0, "", "numbers that methods can reckon with", reason}});
  Plausibility& proportions = checked.proportions.emplace(plausibility(scene));
  const std::vector<std::string> of_files = file_warnings();
  proportions.warnings.insert(proportions.warnings.begin(), of_files.begin(), of_files.end());
  if (const std::string motion = scene.sliding.empty() ? remaining_rigid_motion(scene) : std::string{};
      !motion.empty())
    proportions.warnings.push_back(motion + ": coupled and finite elements refuse it");
  checked.parts = parts_of(scene);
  checked.conditions = stated_parts(scene);
  checked.materials = materials_of(scene);
  checked.words = fmt::format(
      "{}D, {} cells, {} nodes, {} material{}, {} prescribed components\n{}\n", scene.dimension(),
      scene.specimen.n_matter_cells(), scene.specimen.n_matter_nodes(), scene.materials.size(),
      scene.materials.size() == 1 ? "" : "s", scene.prescribed.size(), maille::in_words(scene, proportions));
  for (const std::string& warning : proportions.warnings)
    checked.words += fmt::format("warning: {}\n", warning);
  checked.words += columns_of_body().text(checked.parts) + columns_of_conditions().text(checked.conditions) +
                   columns_of_materials().text(checked.materials);
  if (scene.specimen.fibre_report.source == "tensor_image")
    checked.words += fmt::format("fibres: {}\n", in_words(scene.specimen.fibre_report));
  for (const LeftOutPiece& piece : scene.left_out)
    if (piece.cells < 0)
      checked.words += piece.name + "\n";
  for (const Measure& measure : measures) {
    checked.measures.push_back(
        {measure.name, std::string(unit_of(measure, scene.dimension())), in_words(measure)});
    checked.words += fmt::format("measure {}: {}\n", measure.name, checked.measures.back().meaning);
  }
}

/// Checks the world and each body by itself.
void check_world(Checked& checked) {
  const WorldScene world = read_world_scene(checked.file);
  const PlacedWorld made = placed(world, checked.file);
  checked.words = in_words(world) + "\n";
  for (const WorldObject& object : world.objects)
    checked.words += fmt::format("{}: size {}\n", object.name,
                                 size_in_words(object.scene, plausibility(object.scene).size));
  checked.words += fmt::format(
      "set up in {}; a frame without a hand takes {}{} on one thread, frames in contact more\n",
      in_seconds(made.set_up_seconds), made.frame_seconds < longest_first_frame ? "" : "at least ",
      in_seconds(made.frame_seconds));
  checked.world_warnings = world_warnings(world);
  for (const std::string& warning : *checked.world_warnings)
    checked.words += fmt::format("warning: {}\n", warning);
  for (std::size_t object = 0; object < made.thin.size(); ++object)
    if (made.thin[object] > 0)
      checked.words +=
          fmt::format("kept apart to a cell only: {:.2g} % of `{}` is thinner than a cell of the "
                      "world and counts as one cell thick (docs/contact.md)\n",
                      made.thin[object], world.objects[object].name);
  const bool knows_forces = world.method == "coupled" || world.method == "relaxed";
  const bool has_body = std::ranges::any_of(
      world.objects, [](const WorldObject& object) { return object.kind == ObjectKind::deformable; });
  if (world.contact == ContactLaw::cells && knows_forces && has_body && world.objects.size() > 1)
    checked.words +=
        "forces to a cell only: with contact = \"cells\" what two objects press each other with "
        "differs by what a cell of the world more or less makes; contact = \"surfaces\" balances "
        "it (docs/contact.md)\n";
}

/// Reads every case of a small study and evenly spaced ones of a large study, for their faults and memory.
void check_study(Checked& checked) {
  constexpr std::int64_t most_read = 64;
  const StudyFile study = read_study(checked.file);
  const std::int64_t n = checked.cases.emplace(n_cases(study));
  const std::vector<std::string> methods = study.row_methods();
  checked.words = fmt::format("a study, {}: {} case{} by {}\n", study.title, n, n == 1 ? "" : "s",
                              fmt::join(methods, ", "));
  const std::vector<StudyCase> all = cases(study);
  const auto is_lattice = [](const std::string& method) {
    return std::ranges::find(deform::methods(), method) != deform::methods().end();
  };
  std::int64_t bytes = 0;
  int largest = 0;
  double slowest = 0; // of a method and case: other lattice methods take at most about as long as coupled
  for (std::int64_t i = 0; i < n; i += (n + most_read - 1) / most_read)
    try {
      const StudyCase& one = all[static_cast<std::size_t>(i)];
      const Scene scene =
          parse_scene_and_measures(resolved_scene(study, one), study.scenes[one.scene].file).scene;
      slowest = std::max(slowest, seconds_of_coupled(scene));
      for (const std::string& method : methods)
        if (is_lattice(method))
          if (const std::int64_t needed = deform::bytes_needed(scene, method); needed > bytes) {
            bytes = needed;
            largest = one.number;
          }
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults())
        checked.words += fmt::format("warning: case {} has no answer: {}: expected {}, found {}\n", i + 1,
                                     fault.key, fault.expected, fault.found);
    }
  if (bytes > 0) {
    checked.bytes = bytes;
    checked.words += fmt::format("memory of the lattice methods at most {} (case {})\n",
                                 bytes_in_words(static_cast<double>(bytes)), largest);
  }
  if (std::ranges::all_of(methods, is_lattice))
    checked.seconds = static_cast<double>(n * std::ssize(methods)) * slowest;
  if (checked.seconds > 0)
    checked.words +=
        fmt::format("about {} on one thread (a third to three times that)\n", in_seconds(checked.seconds));
}

void check_trajectory(Checked& checked, const fs::path& world) {
  const WorldScene scene = read_world_scene(world);
  const Trajectory trajectory = read_trajectory(checked.file, scene);
  checked.words = fmt::format("a trajectory of {} frame{}, {} drive{}, for {}\n", trajectory.n_frames,
                              trajectory.n_frames == 1 ? "" : "s", trajectory.spans.size(),
                              trajectory.spans.size() == 1 ? "" : "s", scene.name);
}

bool has_any(const toml::table& table, std::initializer_list<std::string_view> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return table.contains(key); });
}

bool is_material(const toml::table& table) {
  return has_any(table, {"youngs_modulus", "E", "E_fibre", "law"});
}

/// Reads a material the way scenes do: by a scene of one cell that names it.
void check_material(Checked& checked) {
  const fs::path file = checked.file;
  const toml::table root = parse_toml(read_text_file(file, "a material file"), file.string());
  std::vector<std::string> names{""};
  if (!is_material(root)) {
    names.clear();
    for (const auto& [key, value] : root)
      if (value.is_table())
        names.push_back("#" + std::string(key.str()));
  }
  const std::string plain = file.filename().string();
  for (const std::string& name : names)
    parse_scene(fmt::format("[specimen]\nshape = \"box\"\ncells = [1, 1, 1]\nspacing = \"1 mm\"\n"
                            "material = '{}{}'\n[[hold]]\nwhere = \"x-\"\n",
                            plain, name),
                file.parent_path() / "a scene that names it");
  checked.words = fmt::format("{} material{}\n", names.size(), names.size() == 1 ? "" : "s");
}

enum class FileKind { scene, study, trajectory, material };

/// File type by keys that only one type has; unreadable files are left to the reader of scenes.
FileKind kind_of(const fs::path& file) {
  if (file.extension() == ".csv")
    return FileKind::trajectory;
  try {
    const toml::table root = parse_toml(read_text_file(file, "a scene file"), file.string());
    if (has_any(root, {"specimen", "world"}))
      return FileKind::scene;
    if (has_any(root, {"drive", "frame_time"}))
      return FileKind::trajectory;
    if (root.contains("scene"))
      return FileKind::study;
    for (const auto& [key, value] : root)
      if (const toml::table* section = value.as_table(); section && is_material(*section))
        return FileKind::material;
    return is_material(root) ? FileKind::material : FileKind::scene;
  } catch (const InputError&) {
    return FileKind::scene;
  }
}

/// True for a tissue of the library, `muscle/soleus`, or `library`, unless it is a file or has a dot.
bool is_word_of_tissue(const std::string& word) {
  return !word.empty() && word.front() != '-' && word.find('.') == std::string::npos &&
         !std::filesystem::exists(word);
}

} // namespace

int check_any_command(const CheckOptions& options) {
  if (is_word_of_tissue(options.scene.string()))
    return materials_command({options.scene.string(), options.json});
  if (options.why || options.picture)
    return explain_command(options);
  fs::path first = options.scene, second = options.trajectory;
  keep_inputs(second.empty() ? std::vector{first} : std::vector{first, second});
  prepare_file("--json", options.json);
  const FileKind kind = kind_of(first);
  if (kind == FileKind::trajectory && !second.empty())
    std::swap(first, second); // in either order
  if (kind == FileKind::trajectory && second.empty())
    throw UsageError(fmt::format("{}: expected with a trajectory the world that it moves: maille check "
                                 "WORLD.toml {}, found the trajectory alone",
                                 first.string(), first.filename().string()));
  Checked checked{first.string(), ""};
  std::function<void(Checked&)> check = is_world_scene(first) ? check_world : check_scene;
  if (!second.empty()) {
    checked = {second.string(), "trajectory"};
    check = [&](Checked& of) { check_trajectory(of, first); };
  } else if (kind == FileKind::study) {
    checked.kind = "study";
    check = check_study;
  } else if (kind == FileKind::material) {
    checked.kind = "material";
    check = check_material;
  }
  try {
    check(checked);
  } catch (const InputError& error) {
    if (!options.json)
      throw; // reported by main
    checked.faults = error.faults();
    checked.proportions.reset();
  }
  deliver(options.json ? json_text(columns_of_check().json(checked))
                       : fmt::format("{}: no faults; {}", checked.file, checked.words),
          options.json);
  return checked.faults.empty() ? exit_done : exit_faulty_input;
}

} // namespace maille::studies
