#include "identify/identify.hpp"

#include "maille/materials/library.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace maille::studies {

namespace {

template<class Values>
toml::array array_of(const Values& values) {
  toml::array list;
  for (const double value : values)
    list.push_back(value);
  return list;
}

toml::table table_of(const Material& material, const std::string& constant) {
  const ElasticConstants& elasticity = material.elasticity;
  const auto pascals = [](double value) { return fmt::format("{:.17g} Pa", value); };
  toml::table table{{"name", material.name}, {"density", fmt::format("{:.17g} kg/m^3", material.density)}};
  if (constant == "youngs_modulus" || constant == "poisson_ratio") {
    if (!elasticity.is_isotropic())
      throw std::invalid_argument("one of E_fibre, E_cross, G_fibre, nu_fibre, nu_cross");
    table.insert("youngs_modulus", pascals(elasticity.youngs_modulus[0]));
    table.insert("poisson_ratio", elasticity.nu12);
  } else {
    if (elasticity.is_isotropic())
      throw std::invalid_argument("youngs_modulus or poisson_ratio");
    table.insert("E_fibre", pascals(elasticity.youngs_modulus[0]));
    table.insert("E_cross", pascals(elasticity.youngs_modulus[1]));
    table.insert("G_fibre", pascals(elasticity.G12));
    table.insert("nu_fibre", elasticity.nu12);
    table.insert("nu_cross", elasticity.nu23);
  }
  if (material.limits) {
    table.insert("stretch", array_of(material.limits->stretch));
    table.insert("compress", array_of(material.limits->compress));
    toml::array shear;
    for (const auto& row : material.limits->shear)
      shear.push_back(array_of(row));
    table.insert("shear", std::move(shear));
  }
  return table;
}

/// The table at `key` of `parent`, where it is of that material.
void add_table(toml::table& parent, std::string_view key, const MaterialConstant& wanted,
               std::vector<toml::table*>& tables) {
  toml::node* node = parent.get(key);
  if (node != nullptr && node->value<std::string>() == wanted.material)
    if (const LibraryEntry* entry = find_material(wanted.material)) {
      parent.insert_or_assign(key, table_of(entry->material, wanted.constant));
      node = parent.get(key);
    }
  toml::table* table = node != nullptr ? node->as_table() : nullptr;
  if (table == nullptr || (*table)["name"].value<std::string>() != wanted.material)
    return;
  if (!table->contains(wanted.constant))
    throw std::invalid_argument("a constant that stands in its table");
  tables.push_back(table);
}

} // namespace

std::vector<MaterialConstant> constants_in(const std::vector<std::string>& words) {
  constexpr std::string_view of = " of ";
  const auto text = [](std::string_view part) { return std::string(trimmed(part, " ")); };
  std::vector<MaterialConstant> constants;
  for (const std::string& word : words) {
    const std::size_t at = word.find(of);
    if (at == word.npos) {
      constants.push_back({text(word), {}});
      continue;
    }
    constants.push_back({text(word.substr(0, at)), text(word.substr(at + of.size()))});
    for (auto before = constants.rbegin() + 1; before != constants.rend() && before->material.empty() &&
                                               before->constant.find('.') == std::string::npos;
         ++before)
      before->material = constants.back().material;
  }
  return constants;
}

std::vector<toml::table*> tables_of(toml::table& document, const MaterialConstant& wanted) {
  std::vector<toml::table*> tables;
  toml::table* specimen = document["specimen"].as_table();
  if (specimen == nullptr)
    return tables;
  add_table(*specimen, "material", wanted, tables);
  toml::table* labels = (*specimen)["labels"].as_table();
  if (labels == nullptr)
    return tables;
  std::vector<std::string> keys;
  for (const auto& entry : *labels)
    keys.emplace_back(entry.first.str());
  for (const std::string& key : keys)
    add_table(*labels, key, wanted, tables);
  return tables;
}

} // namespace maille::studies
