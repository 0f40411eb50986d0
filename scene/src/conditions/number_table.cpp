#include "conditions/number_table.hpp"

#include "maille/base/csv.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::reader {

namespace {

/// Where each column stands, and its unit.
class Header {
public:
  Header(const std::vector<std::string>& cells, int line, const std::vector<NumberColumn>& columns,
         const FileUnits& scene, FaultList& faults)
      : place_(columns.size()), unit_(columns.size()), n_cells_(cells.size()) {
    std::string names;
    for (const NumberColumn& column : columns)
      names += (names.empty() ? "" : ", ") + std::string(column.name);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto bracket = cells[i].find('[');
      const std::string name(trimmed(std::string_view(cells[i]).substr(0, bracket)));
      const auto column = std::ranges::find(columns, name, &NumberColumn::name);
      if (column == columns.end()) {
        faults.add(line, name, "one of the columns " + names, "\"" + name + "\"");
        continue;
      }
      const auto k = static_cast<std::size_t>(column - columns.begin());
      if (place_[k])
        faults.add(line, name, "each column once", "\"" + name + "\" again");
      place_[k] = i;
      if (bracket != std::string::npos)
        unit_[k] = trimmed(cells[i].substr(bracket + 1, cells[i].find(']') - bracket - 1));
      if (!unit_[k].empty() && !parse_quantity("1 " + unit_[k], column->dimension))
        faults.add(line, name, describe(column->dimension), "[" + unit_[k] + "]");
    }
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (columns[k].is_needed && !place_[k])
        faults.add(line, std::string(columns[k].name), "a column of that name", "none");
      // `x [mm], y, z`: a unit counts until another one is stated.
      if (k > 0 && unit_[k].empty() && columns[k].dimension == columns[k - 1].dimension)
        unit_[k] = unit_[k - 1];
      const bool is_angle = columns[k].dimension == Dimension::angle;
      const auto& bare = is_angle                                    ? scene.angle
                         : columns[k].dimension == Dimension::length ? scene.length
                                                                     : std::nullopt;
      const bool is_first = k == 0 || columns[k].dimension != columns[k - 1].dimension;
      if (is_first && place_[k] && unit_[k].empty() && bare.value_or(1) != 1)
        faults.add(line, std::string(columns[k].name),
                   fmt::format("a unit, such as {} [{}]: the scene's `units` are not those of its tables",
                               columns[k].name, is_angle ? "deg" : "mm"),
                   "none");
    }
  }
  std::size_t n_cells() const { return n_cells_; }
  const std::optional<std::size_t>& place(std::size_t k) const { return place_[k]; }
  const std::string& unit(std::size_t k) const { return unit_[k]; }

private:
  std::vector<std::optional<std::size_t>> place_;
  std::vector<std::string> unit_;
  std::size_t n_cells_;
};

NumberRow row_of(const std::vector<std::string>& cells, int line, const Header& header,
                 const std::vector<NumberColumn>& columns, FaultList& faults) {
  NumberRow row{line, std::vector<double>(columns.size(), 0)};
  if (cells.size() != header.n_cells()) {
    faults.add(line, "", fmt::format("{} cells, as in the first row", header.n_cells()),
               fmt::format("{}", cells.size()));
    return row;
  }
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (!header.place(k))
      continue;
    const std::string& cell = cells[*header.place(k)];
    const auto value = parse_quantity(cell + " " + header.unit(k), columns[k].dimension);
    if (!value)
      faults.add(line, std::string(columns[k].name), describe(columns[k].dimension), "\"" + cell + "\"");
    row.values[k] = value.value_or(0);
  }
  return row;
}

} // namespace

NumberTable read_number_table(const std::filesystem::path& file, const std::vector<NumberColumn>& columns,
                              const FileUnits& scene) {
  const std::string text = read_text_file(file, "a table");
  FaultList faults(file.string());
  CsvRecords records(text, CsvComments::lines);
  std::optional<Header> header;
  NumberTable table;
  while (records.next()) {
    const auto& cells = records.cells();
    if (cells.size() == 1 && trimmed(cells.front()).empty())
      continue;
    if (!header)
      header.emplace(cells, records.line(), columns, scene, faults);
    else
      table.rows.push_back(row_of(cells, records.line(), *header, columns, faults));
  }
  if (table.rows.empty() && faults.empty())
    faults.add(0, "", "a first row that names columns, and rows of numbers below it", "none");
  faults.throw_if_any();
  for (std::size_t k = 0; k < columns.size(); ++k)
    table.has.push_back(header->place(k).has_value());
  return table;
}

} // namespace maille::reader
