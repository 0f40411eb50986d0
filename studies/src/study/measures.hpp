#pragma once
/// Measures in the rows of studies.

#include "study/plan/study_table.hpp"

namespace maille::studies {

/// Rows of one table have the same columns of measures: those that some row lacks are added to it, empty.
std::vector<StudyRow> with_same_measures(std::vector<StudyRow> rows);

/// A line a measure and method with its least, median and largest value over the cases, and the median of its
/// error; empty of no measures.
std::string measures_in_words(const std::vector<StudyRow>& rows);

} // namespace maille::studies
