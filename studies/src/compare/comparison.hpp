#pragma once
/// Comparison of methods on one scene: its rows as text, JSON and CSV, and a check of whether its reference
/// is trustworthy.

#include "compare/methods.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/answer.hpp"
#include "results/measure_values.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// Row of one method.
struct ComparisonRow {
  Answer answer;
  /// In units of the spacing; none without displacement, or without limits in the method or the scene
  std::optional<double> limit_violation;
  std::optional<ErrorNorms> error; ///< none for the reference's row and without displacement
  std::optional<deform::ErrorEstimation> estimation = {}; ///< from add_estimates
  std::optional<Mechanics> mechanics = {};                ///< from add_mechanics, like the next member
  std::optional<MechanicsErrors> mechanics_errors = {};   ///< if there is an `error`
  std::vector<MeasureRow> measures = {};                  ///< from add_measures
};

struct Comparison {
  std::string reference; ///< reference method of errors, or "best"; empty: no errors
  /// Error of the reference "best" itself, see BestReference; set if it is known
  std::optional<ErrorNorms> reference_error;
  std::string reference_coarser; ///< the coarser mesh of that estimate
  double taut_scale = 0;         ///< LinkLimits::taut_scale [Pa]; 0 if no method uses limits
  bool cut_is_allowed = false;   ///< LimitSettings::cut_is_allowed
  int threads = 1;
  std::vector<ComparisonRow> rows;
  std::vector<std::string> warnings; ///< see reference_warnings

  /// The row of `reference`, or nullptr.
  const ComparisonRow* reference_row() const;
  /// True if a method has no settled answer (refusing the scene is no failure if there is a reference), if
  /// the reference has none, or if limits clip prescribed values and the scene does not allow that.
  bool any_failed() const;
};

/// A copy of `scene` with the scale of taut limits computed, whether the methods request it or not: all steps
/// then use the scale of the whole scene.
Scene with_known_limits(const Scene& scene);
/// True if an answer has more than the prescribed values: its method completed, or was stopped after its
/// first iteration.
bool is_under_way(const Answer& answer);

/// Default time for the reference "best" in compare_methods [s].
inline constexpr double seconds_for_best = 60;

/// Runs the methods one by one and computes their errors against `reference` (run too if it is not among
/// them; empty: no errors; "best": see best_reference). Stops early, with fewer rows, on a stop request.
/// @pre all are methods (see is_method)
Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control);
/// The same with existing methods, which may have cached set-up.
Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control, Methods& methods,
                           double seconds_for_reference = seconds_for_best);

/// Estimates the error of every answer without finite elements, see deform::estimate_error. Finite-element
/// answers and answers far from settled get no estimate, nor do rows after a stop request.
void add_estimates(const Scene& scene, Comparison& comparison, const Control& control);

/// Adds forces, strain, stress and energy of every answer that is_under_way(), and their errors against the
/// reference.
void add_mechanics(const Scene& scene, Comparison& comparison);

/// measured() with the method's own cell energies, if a measure requires them.
std::vector<MeasuredValue> measured_answer(const Scene& scene, const std::vector<Measure>& measures,
                                           const Answer& answer);

/// Evaluates the scene's measures for every answer that is_under_way(), with errors against the reference;
/// other rows have all measures without a value.
void add_measures(const Scene& scene, const std::vector<Measure>& measures, Comparison& comparison);

/// The length of the largest displacement of a node [m].
double largest_displacement(const Scene& scene, const Displacement& displacement);

/// The table for people.
std::string table(const Scene& scene, const Comparison& comparison);
/// JSON of `compare --json`; see docs/command.md.
nlohmann::ordered_json json(const Scene& scene, const Comparison& comparison);
/// A header line and one line per method.
std::string csv(const Scene& scene, const Comparison& comparison);

/// Warnings if the reference of a comparison may be inaccurate: by how much, and the evidence.
///
/// If the error of a lattice method against finite elements exceeds both 1.5 times its estimated error
/// (add_estimates) and 2 %, most of it is the reference's: at least the difference, at most the sum of error
/// and estimate. If it is less than a third of an estimate of 5 % or more, both share an error. Without
/// estimates, a settled `coupled` more than 3 % from its reference is estimated here. If that is
/// inconclusive, or without `coupled`, linear elements get a warning for known locking: Poisson ratios of
/// 0.45 and more, and bodies less than four cells thick. No warning for the reference "best", whose error is
/// known, or for a reference without an answer.
///
/// Cost     nothing, or one estimate (similar to `coupled`, see deform::estimate_error)
std::vector<std::string> reference_warnings(const Scene& scene, const Comparison& comparison,
                                            const Control& control);

} // namespace maille::studies
