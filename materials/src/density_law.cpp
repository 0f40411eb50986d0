#include "maille/materials/density_law.hpp"

#include "library_files.hpp"
#include "maille/materials/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

namespace {

/// A quantity > 0 that has to be there; 0 and a fault where it is not.
double required(TableReader& table, std::string_view key, Dimension dimension) {
  table.require(key, describe(dimension));
  const auto value = table.quantity(key, dimension);
  if (value && !(*value > 0))
    table.fault(key, "a value > 0", describe(*table.find(key)));
  return value.value_or(0);
}

std::string required_text(TableReader& table, std::string_view key) {
  table.require(key, "a text in quotes");
  return table.text(key).value_or("");
}

} // namespace

double DensityLaw::youngs_modulus(double density) const {
  return modulus * std::pow(density / 1000, exponent);
}

DensityLaw parse_density_law(std::string_view text, const std::string& file, const std::string& name) {
  const toml::table document = parse_toml(text, file);
  FaultList faults(file);
  TableReader root(document, "", faults);
  DensityLaw law;
  law.name = name;
  law.title = required_text(root, "title");
  law.source = required_text(root, "source");
  law.note = root.text("note").value_or("");
  law.of = root.choice("density", {"apparent", "ash"}).value_or("apparent");
  law.modulus = required(root, "modulus", Dimension::pressure);
  law.exponent = required(root, "exponent", Dimension::dimensionless);
  law.least = required(root, "least", Dimension::density);
  law.most = required(root, "most", Dimension::density);
  if (law.most < law.least)
    root.fault("most", "a density above `least`", describe(*root.find("most")));
  const toml::node* const verified = root.require("verified", "true or false");
  law.verified = verified && verified->value_or(false);
  root.finish();
  faults.throw_if_any();
  return law;
}

const std::vector<DensityLaw>& density_laws() {
  static const std::vector<DensityLaw> laws = [] {
    std::vector<DensityLaw> all;
    for (const LibraryFile& file : library_files())
      if (file.name.starts_with(density_law_group))
        all.push_back(parse_density_law(file.text, "materials/library/" + std::string(file.name) + ".toml",
                                        std::string(file.name.substr(density_law_group.size()))));
    std::ranges::sort(all, {}, &DensityLaw::name);
    return all;
  }();
  return laws;
}

const DensityLaw* find_density_law(std::string_view name) {
  const auto law = std::ranges::find(density_laws(), name, &DensityLaw::name);
  return law == density_laws().end() ? nullptr : &*law;
}

} // namespace maille
