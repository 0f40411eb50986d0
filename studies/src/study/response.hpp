#pragma once
/// What a study is about: a column of its table, as pictures and sensitivities take it.

#include "study/plan/study_table.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct Response {
  std::size_t column = 0;
  std::string measure;     ///< not empty: the column of a measure
  std::string name, label; ///< the label with the unit
  bool is_percent = false, is_error = false;

  /// Value of a row in the shown unit; nothing if the row has no such number.
  std::optional<double> value(const StudyRow& row) const;

private:
  double in_column(const StudyRow& row) const;
  double of_measure(const StudyRow& row) const;
};

/// @param name one of study_responses(), or of a column of a measure in the rows
Response response_of(const std::string& name, const std::vector<StudyRow>& rows);

/// Those of study_responses() that say what the body does, not what its answer costs, and the error; without
/// columns that no row has.
std::vector<std::string> mechanical_responses(const std::vector<StudyRow>& rows);

} // namespace maille::studies
