#pragma once
/// The comparison of methods on one scene: the rows of its table, as text for people, JSON and CSV, and
/// whether the answer that it trusts deserves it.

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

/// One method's line.
struct ComparisonRow {
  Answer answer;
  /// In units of the spacing; none without displacement or limits that it has, or that the scene asks for
  std::optional<double> limit_violation;
  std::optional<ErrorNorms> error; ///< none for the reference's own row and without displacement
  std::optional<deform::ErrorEstimation> estimation = {}; ///< where add_estimates was asked for it
  std::optional<Mechanics> mechanics = {};                ///< where add_mechanics was; so is the next
  std::optional<MechanicsErrors> mechanics_errors = {};   ///< where there is an `error`
  std::vector<MeasureRow> measures = {};                  ///< where add_measures was asked for them
};

struct Comparison {
  std::string reference; ///< method that errors are measured against, or "best"; empty: none was asked for
  /// How far the reference "best" is itself from the truth, see BestReference; set where that was found out
  std::optional<ErrorNorms> reference_error;
  std::string reference_coarser; ///< what it was compared with for that
  double taut_scale = 0;         ///< LinkLimits::taut_scale [Pa]; 0 where no method felt limits
  bool cut_is_allowed = false;   ///< LimitSettings::cut_is_allowed
  int threads = 1;
  std::vector<ComparisonRow> rows;
  std::vector<std::string> warnings; ///< see reference_warnings

  /// The row of `reference`, or nullptr.
  const ComparisonRow* reference_row() const;
  /// True if a method did not end in a settled answer (beside a reference, one that refuses the scene is no
  /// failure), if the reference did not, or if limits cut back what a scene prescribes and it does not allow
  /// that.
  bool any_failed() const;
};

/// A copy of `scene` in which the scale of the taut limits is known that methods feel, asked for or not: its
/// steps keep the whole's.
Scene with_known_limits(const Scene& scene);
/// Whether an answer holds more than what was prescribed: its method ended, or was cut short after its first
/// iteration.
bool is_under_way(const Answer& answer);

/// What compare_methods may spend on the reference "best" [s], unless told otherwise.
inline constexpr double seconds_for_best = 60;

/// Runs methods one after the other and measures each against `reference` (run too where it is not among
/// them; empty: no errors; "best": see best_reference). Stops early, with fewer rows, where control asks to.
/// @pre all are methods (see is_method)
Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control);
/// The same by methods that were used before and may have kept what serves again.
Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control, Methods& methods,
                           double seconds_for_reference = seconds_for_best);

/// Estimates the error of every answer without finite elements, see deform::estimate_error; of theirs, and of
/// those that are far from settled, there is no estimate. Rows that control stops before are left without.
void add_estimates(const Scene& scene, Comparison& comparison, const Control& control);

/// Says of every answer that is_under_way() what it says of forces, strain, stress and energy, and how far
/// that is from the reference's.
void add_mechanics(const Scene& scene, Comparison& comparison);

/// measured() with the method's own energies of cells, where one of the measures asks for them.
std::vector<MeasuredValue> measured_answer(const Scene& scene, const std::vector<Measure>& measures,
                                           const Answer& answer);

/// Takes a scene's measures of every answer that is_under_way(), with their errors against the reference's;
/// rows without have all of them without a value.
void add_measures(const Scene& scene, const std::vector<Measure>& measures, Comparison& comparison);

/// The length of the largest displacement of a node [m].
double largest_displacement(const Scene& scene, const Displacement& displacement);

/// The table for people.
std::string table(const Scene& scene, const Comparison& comparison);
/// What `compare --json` prints; see docs/command.md.
nlohmann::ordered_json json(const Scene& scene, const Comparison& comparison);
/// A header line and one line a method.
std::string csv(const Scene& scene, const Comparison& comparison);

/// Sentences for people where the reference of a comparison may be far off itself: how far, and how we know.
///
/// If the error of a lattice method against finite elements is more than 1.5 times the method's estimated
/// error (add_estimates) and 2 %, most of it is the reference's: at least the difference, at most the sum of
/// error and estimate. If it is less than a third of an estimate of 5 % or more, both share an error. Without
/// estimates, a settled `coupled` that is more than 3 % from its reference is estimated here. Where that is
/// inconclusive, or without `coupled`, linear elements get a warning where they are known to lock: Poisson
/// ratios of 0.45 and more, and bodies of fewer than four cells across. No warning for the reference "best",
/// which knows its own error, or a reference without an answer.
///
/// Cost     nothing, or one estimate (about that of `coupled`, see deform::estimate_error)
std::vector<std::string> reference_warnings(const Scene& scene, const Comparison& comparison,
                                            const Control& control);

} // namespace maille::studies
