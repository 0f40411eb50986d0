#pragma once
/// Measures of an answer and their errors, for result tables.

#include "maille/scene/measure/measure.hpp"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

struct MeasureRow {
  MeasuredValue value;
  std::optional<double> error; ///< see relative_error; none for the reference itself
};

/// @param reference  values of the same measures; empty without a reference
std::vector<MeasureRow> with_errors(std::vector<MeasuredValue> values,
                                    const std::vector<MeasuredValue>& reference);
/// Measures of a failed answer. @param why  in words
std::vector<MeasureRow> without_values(const std::vector<Measure>& measures, int dimension,
                                       const std::string& why);

/// A list of name, unit, value or vector or line, and why_not for missing values.
nlohmann::ordered_json measures_json(const std::vector<MeasureRow>& rows);
/// Object of name: error for measures with an error; null if there are none.
nlohmann::ordered_json measure_errors_json(const std::vector<MeasureRow>& rows);
/// One cell per column: NAME; for vectors NAME_x, NAME_y, NAME_z; null without a value.
nlohmann::ordered_json measure_cells(const std::vector<MeasureRow>& rows, bool with_error);

/// One line of the text table.
struct MeasureLine {
  std::string whose; ///< name of the method, or method and lattice
  const MeasureRow* row;
};
/// One line per measure and answer, grouped by measure; empty without measures.
/// @param answers  all with the same measures
std::string measures_in_words(const std::vector<MeasureLine>& answers);
std::vector<MeasureLine> lines_of(const std::string& whose, const std::vector<MeasureRow>& rows);

/// The measures of one step of a series.
struct MeasureStep {
  int step = 0;        ///< counted from 1
  double fraction = 0; ///< fraction of the moves and loads
  std::vector<MeasureRow> rows;
};
/// One line per step, as text and CSV, without line measures. Empty if there are no others.
std::string measure_steps_in_words(const std::vector<MeasureStep>& steps);
std::string measure_steps_csv(const std::vector<MeasureStep>& steps);

/// `2.5 mm`, `41.8 kPa`, `3.2 %`: three or four digits in a suitable unit.
std::string measure_in_words(double value, std::string_view unit);
/// `(0.17, 0, 0)`: components that are rounding beside the largest are 0.
std::string vector_in_words(std::span<const double> vector);
/// Points of a line as CSV: along_m, x_m, y_m, z_m, the value, and for vectors its components.
std::string line_csv(const MeasuredValue& value);

} // namespace maille::studies
