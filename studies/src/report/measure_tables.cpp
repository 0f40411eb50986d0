/// What scenes ask for by name, as tables and as columns of tables of a page.

#include "page_parts.hpp"
#include "results/measure_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

std::string unit_of(const PageData& measure) {
  const PageData unit = at(measure, "unit");
  return unit.is_string() ? plain(unit) : "";
}

std::string in_words(const PageData& value, const std::string& unit) {
  return value.is_number() ? measure_in_words(value.get<double>(), unit) : "–";
}

/// From the least to the most of a line.
std::string line_in_words(const PageData& line, const std::string& unit) {
  double least = INFINITY, most = -INFINITY;
  for (const PageData& point : line)
    if (const PageData value = at(point, "value"); value.is_number()) {
      least = std::min(least, value.get<double>());
      most = std::max(most, value.get<double>());
    }
  return least <= most ? fmt::format("{} to {}", measure_in_words(least, unit), measure_in_words(most, unit))
                       : "–";
}

PageData value_cell(const PageData& measure) {
  const std::string unit = unit_of(measure);
  if (at(measure, "line").is_array())
    return text_cell(line_in_words(at(measure, "line"), unit));
  const PageData value = at(measure, "value"), why_not = at(measure, "why_not");
  if (!value.is_number() && why_not.is_string())
    return number_cell(plain(why_not), nullptr);
  return number_cell(in_words(value, unit), value);
}

std::string vector_in_words(const PageData& vector, const std::string& unit) {
  if (!vector.is_array())
    return "";
  double largest = 0;
  for (const PageData& component : vector)
    largest = std::max(largest, component.is_number() ? std::abs(component.get<double>()) : 0);
  std::string text;
  for (const PageData& component : vector) {
    const double value = component.is_number() ? component.get<double>() : NAN;
    text += fmt::format("{}{:.4g}", text.empty() ? "(" : ", ", std::abs(value) < 1e-7 * largest ? 0 : value);
  }
  return text + ") " + unit;
}

/// The measure of that name in a row; null if missing.
PageData measure_named(const PageData& row, const std::string& name) {
  for (const PageData& measure : at(row, "measures"))
    if (at(measure, "name") == name)
      return measure;
  return {};
}

} // namespace

std::vector<std::string> names_of_measures(const std::vector<PageData>& rows) {
  std::vector<std::string> names;
  for (const PageData& row : rows)
    if (const PageData measures = at(row, "measures"); measures.is_array())
      for (const PageData& measure : measures)
        if (const std::string name = plain(at(measure, "name"));
            std::ranges::find(names, name) == names.end())
          names.push_back(name);
  return names;
}

std::optional<PageData> measures_table(const std::vector<PageData>& rows, const std::string& reference,
                                       const std::string& id) {
  PageData table{{"id", id},
                 {"caption", "What the scene asks for by name"},
                 {"columns", {column("measure", false), column("method", false), column("value", true)}},
                 {"rows", PageData::array()}};
  if (!reference.empty())
    table["columns"].push_back(column("error", true, "relative, against " + reference));
  table["columns"].push_back(column("vector", false, "x, y and z of the world"));
  for (const std::string& name : names_of_measures(rows))
    for (const PageData& row : rows) {
      const PageData measure = measure_named(row, name);
      if (measure.is_null())
        continue;
      PageData cells{text_cell(name), text_cell(plain(at(row, "method"))), value_cell(measure)};
      const PageData error = at(at(row, "error", "measures"), name);
      if (!reference.empty())
        cells.push_back(number_cell(percent(error), error));
      cells.push_back(text_cell(vector_in_words(at(measure, "vector"), unit_of(measure))));
      table["rows"].push_back(
          {{"is_reference", at(row, "method") == reference}, {"cells", std::move(cells)}});
    }
  return table["rows"].empty() ? std::nullopt : std::optional(table);
}

void add_measure_columns(const std::vector<PageData>& rows, PageData& columns) {
  for (const std::string& name : names_of_measures(rows)) {
    columns.push_back(column(name, true));
    columns.push_back(column(name + " error", true));
  }
}

void add_measure_cells(const std::vector<PageData>& rows, const PageData& row, PageData& cells) {
  for (const std::string& name : names_of_measures(rows)) {
    const PageData error = at(at(row, "error", "measures"), name);
    cells.push_back(value_cell(measure_named(row, name)));
    cells.push_back(number_cell(percent(error), error));
  }
}

} // namespace maille::studies
