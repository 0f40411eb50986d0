#pragma once
/// Measures of an answer, with their errors, as tables of results have them.

#include "maille/scene/measure/measure.hpp"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

struct MeasureRow {
  MeasuredValue value;
  std::optional<double> error; ///< see relative_error; none of the reference's own
};

/// @param reference  values of the same measures; empty without a reference
std::vector<MeasureRow> with_errors(std::vector<MeasuredValue> values,
                                    const std::vector<MeasuredValue>& reference);
/// Measures of a failed answer. @param why  in words
std::vector<MeasureRow> without_values(const std::vector<Measure>& measures, int dimension,
                                       const std::string& why);

/// A list of name, unit, value or vector or line, and why_not for missing values.
nlohmann::ordered_json measures_json(const std::vector<MeasureRow>& rows);
/// name: error, of those that have one; null where none has.
nlohmann::ordered_json measure_errors_json(const std::vector<MeasureRow>& rows);
/// A cell a column: NAME, of vectors NAME_x, NAME_y, NAME_z; null of nothing.
nlohmann::ordered_json measure_cells(const std::vector<MeasureRow>& rows, bool with_error);

/// One line of the table for people.
struct MeasureLine {
  std::string whose; ///< method, or method and lattice
  const MeasureRow* row;
};
/// A line a measure and answer, the answers of a measure below each other; empty of no measures.
/// @param answers  with the same measures each
std::string measures_in_words(const std::vector<MeasureLine>& answers);
std::vector<MeasureLine> lines_of(const std::string& whose, const std::vector<MeasureRow>& rows);

/// The measures of one step of a series.
struct MeasureStep {
  int step = 0;        ///< from 1 on
  double fraction = 0; ///< of the moves and loads
  std::vector<MeasureRow> rows;
};
/// A line a step, for people and as CSV; lines of points are left out. Empty where there is nothing else.
std::string measure_steps_in_words(const std::vector<MeasureStep>& steps);
std::string measure_steps_csv(const std::vector<MeasureStep>& steps);

/// `2.5 mm`, `41.8 kPa`, `3.2 %`: three or four digits in a unit that suits it.
std::string measure_in_words(double value, std::string_view unit);
/// `(0.17, 0, 0)`: components that are rounding beside the largest are 0.
std::string vector_in_words(std::span<const double> vector);
/// The points of a line as CSV: along_m, x_m, y_m, z_m, then the value, of vectors its components too.
std::string line_csv(const MeasuredValue& value);

} // namespace maille::studies
