#include "inputs.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/studies/export/kept_inputs.hpp"

#include <cstdlib>
#include <fstream>
#include <set>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Where a text of a scene would lead if it named a file: `$NAME/...`, `~/...`, beside the scene, or
/// anywhere.
fs::path where_it_leads(const std::string& text, const fs::path& folder) {
  const std::string name =
      text.substr(0, text.find(".toml#") == std::string::npos ? text.size() : text.find(".toml#") + 5);
  const std::size_t slash = std::min(name.find('/'), name.size());
  const char* base = nullptr;
  if (name.starts_with('$'))
    base = std::getenv(name.substr(1, slash - 1).c_str());
  else if (name.starts_with("~/"))
    base = std::getenv("HOME");
  if (base != nullptr)
    return fs::path(base) / name.substr(std::min(slash + 1, name.size()));
  return folder / name;
}

class Keeper {
public:
  /// @param names_others  a scene or a study; a material names no file
  void keep(const fs::path& file, bool names_others) {
    std::error_code error;
    if (!fs::is_regular_file(file, error) || !seen_.insert(fs::weakly_canonical(file, error).string()).second)
      return;
    keep_input(file);
    if (names_others && file.extension() == ".toml")
      keep_named_in_toml(file);
    else if (file.extension() == ".mhd")
      keep_data_of_image(file);
  }

private:
  void keep_named_in_toml(const fs::path& file) {
    try {
      visit(parse_toml(read_text_file(file, "a scene file"), file.string()), file.parent_path(), false);
    } catch (const InputError&) {
      // its reader says so
    }
  }

  void visit(const toml::node& node, const fs::path& folder, bool is_scene) {
    if (const auto* table = node.as_table())
      for (const auto& [key, value] : *table)
        visit(value, folder, key == "scene");
    else if (const auto* array = node.as_array())
      for (const auto& value : *array)
        visit(value, folder, is_scene);
    else if (const auto* text = node.as_string();
             text && text->get().size() < 4096 && text->get().find('\0') == std::string::npos)
      keep(where_it_leads(text->get(), folder), is_scene);
  }

  /// `ElementDataFile = body.raw`
  void keep_data_of_image(const fs::path& file) {
    std::ifstream stream(file);
    std::string line;
    for (int n = 0; n < 1000 && std::getline(stream, line); ++n) {
      if (!line.starts_with("ElementDataFile"))
        continue;
      const std::size_t begin = line.find_first_not_of(" \t=", 15), end = line.find_last_not_of(" \t\r");
      if (begin != std::string::npos && end >= begin)
        keep(file.parent_path() / line.substr(begin, end - begin + 1), false);
    }
  }

  std::set<std::string> seen_;
};

} // namespace

void keep_inputs(const std::vector<std::filesystem::path>& files) {
  Keeper keeper;
  for (const fs::path& file : files)
    keeper.keep(file, true);
}

std::string scene_text_of(const std::filesystem::path& file) {
  try {
    return read_text_file(file, "a scene file");
  } catch (const InputError&) {
    return {};
  }
}

} // namespace maille::studies
