#include "study/measures.hpp"

#include "median.hpp"
#include "results/measure_values.hpp"
#include "results/result_table.hpp"
#include "text.hpp"

#include <algorithm>

namespace maille::studies {

namespace {

using Names = std::vector<StudyMeasure>; ///< without values

Names columns_of(const std::vector<StudyRow>& rows) {
  Names columns;
  for (const StudyRow& row : rows)
    for (const StudyMeasure& measure : row.measures)
      if (std::ranges::find(columns, measure.name, &StudyMeasure::name) == columns.end())
        columns.push_back({measure.name, measure.unit, std::nullopt});
  return columns;
}

std::optional<double> value_of_measure(const StudyRow& row, const std::string& name) {
  const auto found = std::ranges::find(row.measures, name, &StudyMeasure::name);
  return found == row.measures.end() ? std::nullopt : found->value;
}

/// One measure of one method over all cases.
struct SummaryLine {
  std::string measure, method, unit;
  std::vector<double> values, errors;

  std::optional<std::string> least() const { return in_words(std::ranges::min_element(values)); }
  std::optional<std::string> most() const { return in_words(std::ranges::max_element(values)); }
  std::optional<std::string> median() const {
    return values.empty() ? std::nullopt : std::optional(measure_in_words(upper_median(values), unit));
  }
  std::optional<double> median_error() const {
    return errors.empty() ? std::nullopt : std::optional(upper_median(errors));
  }

private:
  std::optional<std::string> in_words(std::vector<double>::const_iterator at) const {
    return at == values.end() ? std::nullopt : std::optional(measure_in_words(*at, unit));
  }
};

const ResultTable<SummaryLine>& columns_of_summary() {
  static const ResultTable<SummaryLine> table = [] {
    ResultTable<SummaryLine> columns;
    columns.add({"", "", "", "its name"}, {"measure", -16}, &SummaryLine::measure);
    columns.add({"", "", "", "that answered"}, {"method", -9}, &SummaryLine::method);
    columns.add({"", "", "", "over the cases"}, {"least", 13}, &SummaryLine::least);
    columns.add({"", "", "", "over the cases"}, {"median", 13}, &SummaryLine::median);
    columns.add({"", "", "", "over the cases"}, {"largest", 13}, &SummaryLine::most);
    columns.add({"", "", "", "median over the cases"}, {"error", 10, in_percent, true},
                &SummaryLine::median_error);
    return columns;
  }();
  return table;
}

} // namespace

std::vector<StudyRow> with_same_measures(std::vector<StudyRow> rows) {
  const Names columns = columns_of(rows);
  for (StudyRow& row : rows) {
    Names all = columns;
    for (StudyMeasure& measure : all)
      measure.value = value_of_measure(row, measure.name);
    row.measures = std::move(all);
  }
  return rows;
}

std::string measures_in_words(const std::vector<StudyRow>& rows) {
  const Names columns = columns_of(rows);
  std::vector<SummaryLine> lines;
  for (const StudyMeasure& column : columns) {
    const std::string error = column.name + "_error";
    if (std::ranges::find(columns, error, &StudyMeasure::name) == columns.end())
      continue; // a component of a vector, or an error
    for (const StudyRow& row : rows) {
      auto line = std::ranges::find_if(lines, [&](const SummaryLine& one) {
        return one.measure == column.name && one.method == row.method;
      });
      if (line == lines.end())
        line = lines.insert(lines.end(), {column.name, row.method, column.unit, {}, {}});
      if (const auto value = value_of_measure(row, column.name))
        line->values.push_back(*value);
      if (const auto value = value_of_measure(row, error))
        line->errors.push_back(*value);
    }
  }
  std::erase_if(lines, [](const SummaryLine& line) { return line.values.empty(); });
  return lines.empty() ? "" : columns_of_summary().text(lines);
}

} // namespace maille::studies
