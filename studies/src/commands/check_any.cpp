#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "json_parts.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "maille/studies/study.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <functional>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

enum class FileKind { scene, study, trajectory, material };

bool has_any(const toml::table& table, std::initializer_list<std::string_view> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return table.contains(key); });
}

bool is_material(const toml::table& table) {
  return has_any(table, {"youngs_modulus", "E", "E_fibre"});
}

/// By the keys that only one kind of file has; what cannot be read is left to the reader of scenes.
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

/// As JSON where that is asked for, else in a line; faults are reported by main, or in the JSON.
int report(const CheckOptions& options, const fs::path& file, const char* kind,
           const std::function<std::string()>& check) {
  if (!options.json) {
    deliver(fmt::format("{}: no faults; {}\n", file.string(), check()), std::nullopt);
    return exit_done;
  }
  nlohmann::ordered_json out{
      {"scene", file.string()}, {"kind", kind}, {"faults", nlohmann::ordered_json::array()}};
  try {
    check();
  } catch (const InputError& error) {
    out["faults"] = faults_json(error.faults());
  }
  deliver(json_text(out), options.json);
  return out["faults"].empty() ? exit_done : exit_faulty_input;
}

std::string check_study(const fs::path& file) {
  const StudyFile study = read_study(file);
  return "a study, " + study.title;
}

std::string check_trajectory(const fs::path& file, const fs::path& world) {
  const WorldScene scene = read_world_scene(world);
  const Trajectory trajectory = read_trajectory(file, scene);
  return fmt::format("a trajectory of {} frame{}, {} drive{}, for {}", trajectory.n_frames,
                     trajectory.n_frames == 1 ? "" : "s", trajectory.spans.size(),
                     trajectory.spans.size() == 1 ? "" : "s", scene.name);
}

/// A material is read as scenes read it: by a scene of one cell that names it.
std::string check_material(const fs::path& file) {
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
  return fmt::format("{} material{}", names.size(), names.size() == 1 ? "" : "s");
}

} // namespace

int check_any_command(const CheckOptions& options) {
  fs::path first = options.scene, second = options.trajectory;
  keep_inputs(second.empty() ? std::vector{first} : std::vector{first, second});
  prepare_file("--json", options.json);
  FileKind kind = kind_of(first);
  if (kind == FileKind::trajectory && !second.empty())
    std::swap(first, second); // in whichever order
  if (kind == FileKind::trajectory && second.empty())
    throw UsageError(fmt::format("{}: expected with a trajectory the world that it moves: maille check "
                                 "WORLD.toml {}, found the trajectory alone",
                                 first.string(), first.filename().string()));
  if (!second.empty())
    return report(options, second, "trajectory", [&] { return check_trajectory(second, first); });
  if (kind == FileKind::study)
    return report(options, first, "study", [&] { return check_study(first); });
  if (kind == FileKind::material)
    return report(options, first, "material", [&] { return check_material(first); });
  return check_command(options);
}

} // namespace maille::studies
