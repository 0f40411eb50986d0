#include "maille/materials/density_law.hpp"

#include "library_files.hpp"
#include "maille/materials/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

double DensityLaw::youngs_modulus(double density) const {
  return modulus * std::pow(density / 1000, exponent);
}

DensityLaw parse_density_law(std::string_view text, const std::string& file, const std::string& name) {
  const toml::table document = parse_toml(text, file);
  FaultList faults(file);
  TableReader root(document, "", faults, "density_law");
  DensityLaw law;
  law.name = name;
  root.read("title", law.title);
  root.read("source", law.source);
  root.read("note", law.note);
  law.of = root.choice("density").value_or("apparent");
  root.read("modulus", law.modulus);
  root.read("exponent", law.exponent);
  root.read("least", law.least);
  root.read("most", law.most);
  if (law.most < law.least)
    root.fault("most", "a density above `least`");
  root.read("verified", law.verified);
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
