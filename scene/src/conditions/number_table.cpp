#include "conditions/number_table.hpp"

#include "maille/materials/csv_table.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

namespace maille::reader {

namespace {

/// A scene with `units` of its own does not say those of its tables.
void check_units(const CsvTable& table, const std::vector<CsvColumn>& columns, const FileUnits& scene,
                 FaultList& faults) {
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto& [name, dimension, is_needed] = columns[k];
    const bool is_angle = dimension == Dimension::angle,
               is_first = k == 0 || dimension != columns[k - 1].dimension;
    const auto& bare = is_angle ? scene.angle : dimension == Dimension::length ? scene.length : std::nullopt;
    if (is_first && table.has(name) && table.unit(name).empty() && bare.value_or(1) != 1)
      faults.add(table.line_of_header(), std::string(name),
                 fmt::format("a unit, such as {} [{}]: the scene's `units` are not those of its tables", name,
                             is_angle ? "deg" : "mm"),
                 "none");
  }
}

} // namespace

NumberTable read_number_table(const std::filesystem::path& file, const std::vector<CsvColumn>& columns,
                              const FileUnits& scene) {
  const std::string text = read_text_file(file, "a table");
  FaultList faults(file.string());
  CsvTable cells(text, CsvComments::lines, columns, faults, true);
  check_units(cells, columns, scene, faults);
  NumberTable table;
  while (cells.next()) {
    NumberRow& row = table.rows.emplace_back(NumberRow{cells.line(), {}});
    for (const CsvColumn& column : columns)
      row.values.push_back(cells.number(column.name).value_or(0));
  }
  if (table.rows.empty() && faults.empty())
    faults.add(0, "", "a first row that names columns, and rows of numbers below it", "none");
  faults.throw_if_any();
  for (const CsvColumn& column : columns)
    table.has.push_back(cells.has(column.name));
  return table;
}

} // namespace maille::reader
