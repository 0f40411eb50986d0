#include "study/response.hpp"

#include "study/table_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Lesser errors are shown as this [%]: of what agrees to rounding there is nothing to see.
constexpr double least_percent = 1e-3;

/// Columns whose numbers say how a case came out.
bool is_response(const Column& column) {
  return !column.csv.empty() && (column.is_real || column.csv == "bytes" || column.csv == "iterations") &&
         column.csv != "processor_share" && column.csv != "load_average";
}

bool is_mechanical(const std::string& name) {
  const std::string_view costs[] = {"setup_s",    "solve_s",         "total_s",      "bytes",
                                    "iterations", "limit_violation", "relative_max", "rms_m"};
  return std::ranges::find(costs, name) == std::end(costs) && !name.starts_with("reference_");
}

} // namespace

double Response::in_column(const StudyRow& row) const {
  const Values values = columns_of_study().values(row);
  return values[column].is_number() ? values[column].get<double>() : NAN;
}

double Response::of_measure(const StudyRow& row) const {
  const auto found = std::ranges::find(row.measures, measure, &StudyMeasure::name);
  return found == row.measures.end() ? NAN : found->value.value_or(NAN);
}

std::optional<double> Response::value(const StudyRow& row) const {
  const double value = (is_percent ? 100 : 1) * (measure.empty() ? in_column(row) : of_measure(row));
  if (!std::isfinite(value))
    return std::nullopt;
  return is_error ? std::max(is_percent ? least_percent : 0.0, value) : value;
}

Response response_of(const std::string& name, const std::vector<StudyRow>& rows) {
  Response response;
  const auto& list = columns_of_study().list();
  const auto column = std::ranges::find(list, name, &Column::csv);
  if (column == list.end()) {
    response.name = response.measure = name;
    response.is_percent = response.is_error = name.ends_with("_error");
    std::string unit = response.is_percent ? "%" : "";
    for (const StudyRow& row : rows)
      for (const StudyMeasure& measure : row.measures)
        if (measure.name == name && unit.empty())
          unit = measure.unit;
    response.label = unit.empty() ? name : fmt::format("{} [{}]", name, unit);
    return response;
  }
  response.column = static_cast<std::size_t>(column - list.begin());
  response.name = name;
  response.is_percent = name.ends_with("relative_l2") || name.ends_with("relative_max");
  response.is_error = response.is_percent || name.ends_with("rms_m");
  const std::string unit = response.is_percent ? "%" : column->unit;
  response.label = name == "relative_l2" ? "L2 error [%]"
                   : unit.empty()        ? name
                                         : fmt::format("{} [{}]", name, unit);
  return response;
}

std::vector<std::string> study_responses() {
  std::vector<std::string> names;
  for (const Column& column : columns_of_study().list())
    if (is_response(column))
      names.push_back(column.csv);
  return names;
}

std::vector<std::string> mechanical_responses(const std::vector<StudyRow>& rows) {
  std::vector<std::string> names, all = study_responses();
  for (const StudyMeasure& measure : rows.empty() ? std::vector<StudyMeasure>() : rows.front().measures)
    all.push_back(measure.name);
  for (const std::string& name : all) {
    const Response response = response_of(name, rows);
    if (is_mechanical(name) &&
        std::ranges::any_of(rows, [&](const StudyRow& row) { return response.value(row).has_value(); }))
      names.push_back(name);
  }
  return names;
}

std::string default_response(const std::vector<StudyRow>& rows) {
  std::vector<std::string> wanted{"test_apparent_modulus", "test_stiffness", "test_reaction"};
  for (const StudyMeasure& measure : rows.empty() ? std::vector<StudyMeasure>() : rows.front().measures)
    if (!measure.name.ends_with("_error"))
      wanted.push_back(measure.name);
  wanted.emplace_back("force");
  const std::vector<std::string> all = mechanical_responses(rows);
  const auto has = [&](const std::string& name) { return std::ranges::find(all, name) != all.end(); };
  const auto found = std::ranges::find_if(wanted, has);
  return found == wanted.end() ? "relative_l2" : *found;
}

} // namespace maille::studies
