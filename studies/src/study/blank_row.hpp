#pragma once
/// Rows before there are figures.

#include "maille/studies/study_run.hpp"

namespace maille::studies {

/// Says which case of which study a row is of.
void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one);
/// A row with everything that is known before the case runs.
StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options);

} // namespace maille::studies
