#include "maille/materials/library.hpp"
#include "reader.hpp"

#include <sstream>

namespace maille::reader {

namespace {

std::optional<Material> from_library(const std::string& name, const toml::node& node, const std::string& path,
                                     FaultList& faults) {
  if (const LibraryEntry* entry = find_material(name))
    return entry->material;
  std::string expected = "a material of the library (maille materials lists them)";
  for (const std::string& similar : similar_material_names(name))
    expected += (expected.back() == ')' ? "; did you mean \"" : ", \"") + similar + "\"";
  faults.add(line_of(node), path, expected, "\"" + name + "\"");
  return std::nullopt;
}

std::optional<Material> from_table(const toml::table& values, const std::string& path, FaultList& faults) {
  TableReader table(values, path, faults);
  Material material;
  material.name = table.text("name").value_or(path);
  const auto elasticity = read_elastic_constants(table);
  material.limits = read_neighbour_limits(table);
  if (const auto density = table.quantity("density", Dimension::density)) {
    if (*density > 0)
      material.density = *density;
    else
      table.fault("density", "a density > 0", describe(*table.find("density")));
  }
  table.finish();
  if (!elasticity)
    return std::nullopt;
  material.elasticity = *elasticity;
  return material;
}

} // namespace

std::optional<std::uint8_t> MaterialTable::add(const toml::node& node, const std::string& path,
                                               FaultList& faults) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  if (const auto known = number_of_.find(text.str()); known != number_of_.end())
    return known->second;
  std::optional<Material> material;
  if (const auto* name = node.as_string())
    material = from_library(name->get(), node, path, faults);
  else if (const auto* values = node.as_table())
    material = from_table(*values, path, faults);
  else
    faults.add(line_of(node), path, "the name of a material or a table of constants", describe(node));
  if (!material)
    return std::nullopt;
  if (materials_.size() >= no_material) {
    faults.add(line_of(node), path, "at most 255 different materials", "one more");
    return std::nullopt;
  }
  const auto number = static_cast<std::uint8_t>(materials_.size());
  materials_.push_back(std::move(*material));
  number_of_.emplace(text.str(), number);
  return number;
}

} // namespace maille::reader
