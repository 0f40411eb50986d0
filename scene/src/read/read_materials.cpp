#include "maille/materials/library.hpp"
#include "maille/materials/material.hpp"
#include "maille/materials/text_file.hpp"
#include "read/reader.hpp"

#include <algorithm>
#include <sstream>
#include <tuple>

namespace maille::reader {

namespace {

/// Separates a file of several materials from the name of one of them.
constexpr std::string_view ending_before_name = ".toml#";

std::optional<Material> from_table(const toml::table& values, const std::string& path, FaultList& faults) {
  TableReader table(values, path, faults, "material");
  Material material;
  material.name = table.text("name").value_or(path);
  const bool is_valid = read_mechanics(table, material);
  material.limits = read_neighbour_limits(table);
  material.relaxed_weights = table.three("relaxed_weights").value_or(material.relaxed_weights);
  if (auto damage = table.open("damage")) {
    material.damage = read_damage(*damage);
    damage->finish();
  }
  table.read("density", material.density);
  table.finish();
  return is_valid ? std::optional(material) : std::nullopt;
}

/// Names of the materials in a file of several; empty for a file of one.
std::vector<std::string> names_in(const toml::table& document) {
  std::vector<std::string> names;
  for (const auto& [key, value] : document)
    if (value.is_table())
      names.emplace_back(key.str());
  return names.size() == document.size() ? names : std::vector<std::string>{};
}

/// One of a file's materials; the only one if `one` is empty.
std::optional<Material> from_document(const toml::table& document, const std::string& one,
                                      FaultList& faults) {
  const std::vector<std::string> names = names_in(document);
  if (one.empty() && names.empty())
    return from_table(document, "", faults);
  if (const toml::table* table = document[one].as_table(); table && !names.empty())
    return from_table(*table, one, faults);
  std::string known;
  for (const std::string& name : names)
    known += (known.empty() ? "" : ", ") + faults.file() + "#" + name;
  faults.add(0, one,
             names.empty() ? "a file of several materials, each a table under its name" : "one of " + known,
             one.empty() ? "a file of several materials" : "no such table");
  return std::nullopt;
}

/// The material in a file. @param one its name among several; empty: the only one. @throws InputError
std::optional<Material> from_file(const std::filesystem::path& file, const std::string& one) {
  std::error_code no_matter;
  if (std::filesystem::exists(file, no_matter) && !std::filesystem::is_regular_file(file, no_matter))
    throw InputError(
        {{file.string(), 0, "", "a material file", "something else there"}}); // a pipe would block
  const std::string text = read_text_file(file, "a material file");
  FaultList faults(file.string());
  const toml::table document = parse_toml(text, file.string());
  auto material = from_document(document, one, faults);
  faults.throw_if_any();
  return material;
}

/// @param name FILE.toml, or FILE.toml#NAME
std::optional<Material> from_named_file(const std::string& name, int line, const std::string& path,
                                        FaultList& faults) {
  const std::size_t end = name.find(ending_before_name) == std::string::npos
                              ? name.size()
                              : name.find(ending_before_name) + ending_before_name.size() - 1;
  const auto file = resolve_path(name.substr(0, end), path, line, faults);
  if (!file)
    return std::nullopt;
  try {
    auto material = from_file(*file, end < name.size() ? name.substr(end + 1) : "");
    if (material && material->name.empty())
      material->name = file->stem().string();
    return material;
  } catch (const InputError& error) {
    adopt(error, path, line, faults);
    return std::nullopt;
  }
}

} // namespace

std::optional<Material> library_material(const std::string& name, const std::string& path, int line,
                                         FaultList& faults) {
  if (const LibraryEntry* entry = find_material(name))
    return entry->material;
  std::string expected = "a material of the library (maille check library lists them)";
  for (const std::string& similar : similar_material_names(name))
    expected += (expected.back() == ')' ? "; did you mean \"" : ", \"") + similar + "\"";
  faults.add(line, path, expected, "\"" + name + "\"");
  return std::nullopt;
}

std::optional<std::uint8_t> MaterialTable::add(const toml::node& node, const std::string& path,
                                               FaultList& faults) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  if (const auto known = number_of_.find(text.str()); known != number_of_.end())
    return known->second;
  std::optional<Material> material;
  if (const auto* name = node.as_string())
    material = name->get().ends_with(".toml") || name->get().find(ending_before_name) != std::string::npos
                   ? from_named_file(name->get(), line_of(node), path, faults)
                   : library_material(name->get(), path, line_of(node), faults);
  else if (const auto* values = node.as_table())
    material = from_table(*values, path, faults);
  else
    faults.add(line_of(node), path, "the name of a material or a table of constants", describe(node));
  if (!material)
    return std::nullopt;
  const auto number = append(std::move(*material), path, line_of(node), faults);
  if (number)
    number_of_.emplace(text.str(), *number);
  return number;
}

namespace {

bool is_same(const Material& a, const Material& b) {
  const auto constants = [](const Material& m) {
    const ElasticConstants& c = m.elasticity;
    return std::tuple(c.youngs_modulus, c.nu12, c.nu13, c.nu23, c.G12, c.G13, c.G23, m.density,
                      m.relaxed_weights);
  };
  const auto failure = [](const Damage& d) {
    return std::tie(d.stretch, d.compress, d.shear, d.of, d.source, d.verified);
  };
  return a.name == b.name && constants(a) == constants(b) && a.law == b.law && a.limits == b.limits &&
         a.damage.has_value() == b.damage.has_value() &&
         (!a.damage || failure(*a.damage) == failure(*b.damage));
}

} // namespace

std::optional<std::uint8_t> MaterialTable::add(Material material, const std::string& path,
                                               FaultList& faults) {
  const auto known =
      std::ranges::find_if(materials_, [&](const Material& other) { return is_same(material, other); });
  return known != materials_.end() ? std::optional(static_cast<std::uint8_t>(known - materials_.begin()))
                                   : append(std::move(material), path, 0, faults);
}

std::optional<std::uint8_t> MaterialTable::append(Material material, const std::string& path, int line,
                                                  FaultList& faults) {
  if (materials_.size() >= no_material) {
    faults.add(line, path, "at most 255 different materials", "one more");
    return std::nullopt;
  }
  materials_.push_back(std::move(material));
  return static_cast<std::uint8_t>(materials_.size() - 1);
}

} // namespace maille::reader
