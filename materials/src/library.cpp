#include "maille/materials/library.hpp"

#include "library_files.hpp"
#include "maille/materials/density_law.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/toml_reader.hpp"

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {
namespace {

/// Reads a required, non-empty text.
void read_text(TableReader& table, std::string_view key, std::string& into) {
  table.read(key, into);
  if (table.has(key) && into.empty() && table.find(key)->is_string())
    table.fault(key, "a text that says something");
}

void read_elasticity(TableReader& root, Material& material) {
  if (auto table = root.open("elasticity")) {
    read_mechanics(*table, material);
    table->finish();
  }
}

void read_limits(TableReader& root, Material& material) {
  if (auto table = root.open("limits")) {
    for (const std::string_view key : {"stretch", "compress", "shear"})
      table->require(key, "a ratio: limits of a tissue are given whole");
    material.limits = read_neighbour_limits(*table);
    table->finish();
  }
}

/// Damage with its source, which is required in the library.
void read_damage_of(TableReader& root, Material& material) {
  if (auto table = root.open("damage")) {
    for (const std::string_view key : {"of", "source"}) {
      const toml::node* const node = table->require(key, "a text in quotes");
      if (node && node->value_or(std::string("a fault of its own")).empty())
        table->fault(key, "a text that says something");
    }
    table->require("verified", "true or false");
    material.damage = read_damage(*table);
    table->finish();
  }
}

std::vector<LibraryEntry> read_library() {
  std::vector<LibraryEntry> entries;
  std::vector<Fault> faults;
  for (const LibraryFile& file : library_files()) {
    const std::string name(file.name);
    if (name.starts_with(density_law_group))
      continue;
    try {
      entries.push_back(parse_library_entry(file.text, "materials/library/" + name + ".toml", name));
    } catch (const InputError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  if (!faults.empty())
    throw InputError(std::move(faults));
  std::sort(entries.begin(), entries.end(),
            [](const LibraryEntry& a, const LibraryEntry& b) { return a.material.name < b.material.name; });
  return entries;
}

std::string_view without_group(std::string_view name) {
  return name.substr(name.rfind('/') + 1);
}

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return lower;
}

/// Edit distance of `name` from `known`: the group may be missing or wrong, and a whole word of the name
/// counts as one edit.
std::size_t distance_of_names(std::string_view name, std::string_view known) {
  constexpr std::size_t fewest_letters = 3; // shorter words occur in too many names by chance
  const std::size_t whole = spelling_distance(name, known);
  const std::size_t leaf = spelling_distance(without_group(name), without_group(known));
  const bool stands_in =
      name.size() >= fewest_letters && in_lower_case(known).find(in_lower_case(name)) != std::string::npos;
  return std::min({whole, leaf, stands_in ? std::size_t{1} : whole});
}

} // namespace

LibraryEntry parse_library_entry(std::string_view text, const std::string& file, const std::string& name) {
  const toml::table document = parse_toml(text, file);
  FaultList faults(file);
  TableReader root(document, "", faults, "library");
  LibraryEntry entry;
  entry.material.name = name;
  for (const auto& [key, into] : {std::pair("title", &entry.title),
                                  {"state", &entry.state},
                                  {"species", &entry.species},
                                  {"source", &entry.source}})
    read_text(root, key, *into);
  root.read("uncertainty", entry.uncertainty);
  root.read("note", entry.note);
  root.read("verified", entry.verified);
  root.read("density", entry.material.density);
  read_elasticity(root, entry.material);
  read_limits(root, entry.material);
  read_damage_of(root, entry.material);
  root.finish();
  faults.throw_if_any();
  return entry;
}

const std::vector<LibraryEntry>& material_library() {
  static const std::vector<LibraryEntry> library = read_library();
  return library;
}

const LibraryEntry* find_material(std::string_view name) {
  const std::vector<LibraryEntry>& library = material_library();
  const auto entry = std::lower_bound(
      library.begin(), library.end(), name,
      [](const LibraryEntry& a, std::string_view wanted) { return a.material.name < wanted; });
  return entry != library.end() && entry->material.name == name ? &*entry : nullptr;
}

std::vector<std::string> similar_material_names(std::string_view name, int count) {
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const LibraryEntry& entry : material_library()) {
    const std::string& known = entry.material.name;
    const std::size_t distance = distance_of_names(name, known);
    if (is_slip(distance, std::max(without_group(name).size(), without_group(known).size())))
      ranked.emplace_back(distance, known);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> names;
  for (const auto& [distance, known] : ranked) {
    if (names.size() < static_cast<std::size_t>(std::max(count, 0)))
      names.push_back(known);
  }
  return names;
}

} // namespace maille
