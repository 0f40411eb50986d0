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

std::optional<double> Response::value(const StudyRow& row) const {
  const Values values = columns_of_study().values(row);
  if (!values[column].is_number())
    return std::nullopt;
  const double value = (is_percent ? 100 : 1) * values[column].get<double>();
  if (!std::isfinite(value))
    return std::nullopt;
  return is_error ? std::max(is_percent ? least_percent : 0.0, value) : value;
}

Response response_of(const std::string& name) {
  Response response;
  const auto& list = columns_of_study().list();
  const auto column = std::ranges::find(list, name, &Column::csv);
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
  std::vector<std::string> names;
  for (const std::string& name : study_responses()) {
    const Response response = response_of(name);
    if (is_mechanical(name) &&
        std::ranges::any_of(rows, [&](const StudyRow& row) { return response.value(row).has_value(); }))
      names.push_back(name);
  }
  return names;
}

std::string default_response(const std::vector<StudyRow>& rows) {
  const std::vector<std::string> all = mechanical_responses(rows);
  for (const char* name : {"test_apparent_modulus", "test_stiffness", "test_reaction", "force"})
    if (std::ranges::find(all, name) != all.end())
      return name;
  return "relative_l2";
}

} // namespace maille::studies
