#pragma once
/// What a row of a study holds, in every form, also before there are figures.

#include "maille/studies/study_run.hpp"
#include "maille/studies/study_table.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

template<>
struct Choices<Timing> {
  static constexpr std::array all{Timing::alone, Timing::busy, Timing::side_by_side};
};

const ResultTable<StudyRow>& columns_of_study();

/// Says which case of which study a row is of.
void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one);
/// A row with everything that is known before the case runs.
StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options);

} // namespace maille::studies
