#pragma once
/// Which parameter of a study makes which share of a result's variance, from the study's own samples.

#include "study/plan/study_table.hpp"
#include "study/sensitivity/sensitivity.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace maille::studies {

/// Sensitivity of one column of the table, by one method on one scene.
struct StudySensitivity {
  std::string scene, method;
  std::string response, label;         ///< the column, and with its unit
  std::vector<std::string> parameters; ///< in the order of the indices
  Sensitivity found;
};

/// Sensitivities of every mechanical column and of the error. The plan decides the estimator: variances on
/// whole grids, pairs of points for Saltelli plans, polynomials for all others and grids with gaps.
/// @param rows of this study; cases without a row are left out and counted
/// @return empty for studies with fewer than two parameters
std::vector<StudySensitivity> sensitivities(const StudyFile& study, const std::vector<StudyRow>& rows);

nlohmann::ordered_json json(const std::vector<StudySensitivity>& all);

/// A table for people: of the column that the study is about, see default_response; empty without.
std::string in_words(const std::vector<StudySensitivity>& all, const std::string& response);

} // namespace maille::studies
