#include "builder/build_scene.hpp"
#include "read/measures.hpp"

#include <fmt/format.h>

namespace maille {

namespace {

/// Empty tables, one per hold or move: the reader counts them for measures of force.
toml::array tables_of(std::size_t n) {
  toml::array tables;
  for (std::size_t i = 0; i < n; ++i)
    tables.push_back(toml::table{});
  return tables;
}

} // namespace

/// By the reader of scene files; faults lose their lines, which refer to the pieces of text.
std::vector<Measure> SceneBuilder::Assembly::measures() {
  FaultList faults("");
  faults.units = {1.0, 1.0};
  toml::array tables;
  for (const auto& [name, keys] : asked_.measures_) {
    const std::string path = fmt::format("measure[{}]", tables.size() + 1);
    toml::table table;
    try {
      table = parse_toml(keys, "");
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults())
        add_fault(path, "keys of a [[measure]] in TOML: " + fault.expected, fault.found);
    }
    if (table.contains("name"))
      add_fault(path + ".name", "a name as the first argument alone", "one among the keys, too");
    table.insert_or_assign("name", name);
    tables.push_back(std::move(table));
  }
  if (tables.empty())
    return {};
  toml::table document{{"hold", tables_of(asked_.holds_.size())},
                       {"move", tables_of(asked_.moves_.size())},
                       {"measure", std::move(tables)}};
  TableReader root(document, "", faults, "scene");
  std::vector<Measure> measures = reader::read_measures(root, scene_, has_body_);
  try {
    faults.throw_if_any();
  } catch (const InputError& error) {
    take(error.faults());
  }
  return measures;
}

SceneAndMeasures SceneBuilder::build_with_measures() const {
  return Assembly(*this).scene_and_measures();
}

} // namespace maille
