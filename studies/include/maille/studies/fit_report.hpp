#pragma once
/// What `maille fit` says: errors on the scenes that were fitted and on those that were not, and why there is
/// no better.

#include "maille/studies/fit.hpp"

#include <nlohmann/json_fwd.hpp>

namespace maille::studies {

/// One scene's line.
struct FitRow {
  std::string scene;
  FitError error;
  std::optional<double>
      before; ///< with the limits and weights that the scene itself has; nothing where it has no answer
  std::optional<double> alone; ///< with limits found for this scene alone; only of fitted scenes
  Vec3 floor{};                ///< see unreachable
  std::optional<double>
      taut; ///< within taut limits at a scale of this scene's own; nothing where the method has no answer
  double least() const; ///< of all components
};

struct FitReport {
  std::string method, reference;
  Fit fit;
  std::vector<FitRow> fitted, held_out;
  std::vector<std::string> reasons; ///< why there is no better, in sentences
};

/// The row of a case, with what the scene itself would have come to.
FitRow fit_row(const FitCase& one, const FitError& error, std::optional<double> alone,
               const std::string& method, const Control& control);
/// Why the fit is no better: what nothing can reach, turned fibres, one set of limits for several moves.
std::vector<std::string> reasons_for(const FitReport& report, std::span<const FitCase> fitted);

/// sqrt of the mean of squares of the rows' errors.
double mean_error(std::span<const FitRow> rows);

/// For people.
std::string table(const FitReport& report);
nlohmann::ordered_json json(const FitReport& report);
/// Lines for the head of the material file.
std::vector<std::string> notes(const FitReport& report);

} // namespace maille::studies
