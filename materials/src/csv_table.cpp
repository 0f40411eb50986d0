#include "maille/materials/csv_table.hpp"

#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace maille {

namespace {

/// True behind a comma at the end of a line.
bool is_end(const std::string& cell) {
  return trimmed(cell).empty();
}

} // namespace

CsvTable::CsvTable(std::string_view text, CsvComments comments, std::vector<CsvColumn> columns,
                   FaultList& faults, bool carries_units)
    : records_(text, comments), faults_(faults) {
  for (const CsvColumn& column : columns)
    columns_.push_back({column, {}, {}});
  const std::size_t before = faults.size();
  if (next_record())
    read_header();
  else
    faults.add(0, "", "a first row with the columns' names: " + names(), "an empty file");
  for (std::size_t k = 1; carries_units && k < columns_.size(); ++k)
    if (columns_[k].unit.empty() && columns_[k].dimension == columns_[k - 1].dimension)
      columns_[k].unit = columns_[k - 1].unit;
  is_readable_ = faults.size() == before;
}

std::string CsvTable::names() const {
  std::string all;
  for (const Column& column : columns_)
    all += (all.empty() ? "" : ", ") + std::string(column.name);
  return all;
}

/// The next one that is neither blank nor a comment.
bool CsvTable::next_record() {
  while (records_.next()) {
    const std::string_view first = trimmed(records_.cells().front());
    if ((first.empty() && records_.cells().size() == 1) || first.starts_with('#'))
      continue;
    if (records_.is_open())
      fault("", "a quote at the end of the cell, too", "the end of the file");
    return true;
  }
  return false;
}

void CsvTable::read_header() {
  header_line_ = line();
  n_cells_ = records_.cells().size() - (is_end(records_.cells().back()) ? 1 : 0);
  for (std::size_t place = 0; place < n_cells_; ++place)
    read_column(records_.cells()[place], place);
  for (const Column& column : columns_)
    if (column.is_needed && !column.place)
      fault(column.name, "a column of that name", "none");
}

void CsvTable::read_column(std::string_view cell, std::size_t place) {
  const std::size_t bracket = cell.find('[');
  const std::string_view name = trimmed(cell.substr(0, bracket));
  const auto column = std::ranges::find(columns_, name, &Column::name);
  if (column == columns_.end())
    return fault(name, "one of the columns " + names(), fmt::format("\"{}\"", name));
  if (column->place)
    return fault(name, "each column once", fmt::format("\"{}\" again", name));
  column->place = place;
  if (bracket == std::string_view::npos)
    return;
  const std::string_view behind = trimmed(cell.substr(bracket + 1));
  const std::string_view unit = trimmed(behind.substr(0, behind.find(']')));
  const bool is_one = unit == "1" && column->dimension == Dimension::dimensionless; // as ISO 80000 has it
  const bool is_unit = behind.ends_with(']') && !unit.empty() && column->dimension &&
                       parse_quantity(fmt::format("1 {}", unit), *column->dimension);
  if (!is_one && !is_unit)
    fault(name, column->dimension ? describe(*column->dimension) : "no unit", fmt::format("[{}]", unit));
  column->unit = is_one ? std::string_view() : unit;
}

const CsvTable::Column& CsvTable::at(std::string_view column) const {
  return *std::ranges::find(columns_, column, &Column::name);
}

bool CsvTable::next() {
  while (is_readable_ && next_record()) {
    const std::size_t n = records_.cells().size();
    if (n == n_cells_ || (n == n_cells_ + 1 && is_end(records_.cells().back())))
      return true;
    fault("", fmt::format("{} cells, as in the first row", n_cells_), fmt::format("{}", n));
  }
  return false;
}

std::string_view CsvTable::text(std::string_view column) const {
  const auto& place = at(column).place;
  return place ? trimmed(records_.cells()[*place]) : std::string_view();
}

std::optional<double> CsvTable::number(std::string_view column) {
  const Column& of = at(column);
  if (!of.place)
    return std::nullopt;
  const std::string_view cell = text(column);
  const auto value = parse_quantity(fmt::format("{} {}", cell, of.unit), *of.dimension);
  if (!value)
    fault(column, describe(*of.dimension), fmt::format("\"{}\"", cell));
  return value;
}

bool CsvTable::has_any(std::initializer_list<std::string_view> columns) const {
  return std::ranges::any_of(columns, [&](std::string_view column) { return !text(column).empty(); });
}

void CsvTable::fault(std::string_view column, std::string expected, std::string found) {
  faults_.add(line(), std::string(column), std::move(expected), std::move(found));
}

} // namespace maille
