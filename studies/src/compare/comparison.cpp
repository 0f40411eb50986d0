#include "compare/comparison.hpp"

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/sliding.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace maille::studies {

namespace {

/// Limits of a scene, computed once for all methods that use them, and only if a method does: the scale of
/// taut limits may take longer than an answer. Its time counts as set-up of every method that needs it.
class LimitsOnce {
public:
  LimitsOnce(const Scene& asked, const std::vector<std::string>& methods) {
    const auto start = std::chrono::steady_clock::now();
    const bool any =
        std::ranges::any_of(methods, [&](const auto& m) { return deform::feels_limits(asked, m); });
    const bool is_taut = asked.limit_source() == LimitSource::taut;
    if (any && is_taut)
      known_.emplace(with_known_limits(asked));
    if (any || (asked.limits_bind_relaxed() && !is_taut))
      limits_.emplace(known_ ? *known_ : asked);
    has_play_ = !is_taut || taut_scale() > 0;
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  const Scene& known(const Scene& asked) const { return known_ ? *known_ : asked; }
  /// Null without use of limits, or if taut limits have no scale.
  const LinkLimits* limits() const { return limits_ && has_play_ ? &*limits_ : nullptr; }
  double taut_scale() const { return limits_ ? limits_->taut_scale() : 0; }
  double seconds() const { return known_ ? seconds_ : 0; }

private:
  std::optional<Scene> known_; ///< with the scale of taut limits
  std::optional<LinkLimits> limits_;
  bool has_play_ = true;
  double seconds_ = 0;
};

/// Violation in the frame (or frames) used by the method.
double violation_of(const Scene& scene, const LinkLimits& limits, const Answer& answer) {
  if (answer.method == "coupled" && in_blocks(scene))
    return largest_violation_in_blocks(scene, limits, answer.displacement);
  if (!answer.split.empty()) // the displacement stores their mean
    return largest_violation_of_sides(scene, limits, answer);
  return largest_violation(scene, limits, answer.displacement, object_frame(scene));
}

} // namespace

Scene with_known_limits(const Scene& scene) {
  Scene known = scene;
  known.limits.taut_scale = with_limits(scene).limits.taut_scale;
  return known;
}

const ComparisonRow* Comparison::reference_row() const {
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const ComparisonRow& r) { return r.answer.method == reference; });
  return row == rows.end() ? nullptr : &*row;
}

bool is_under_way(const Answer& answer) {
  return is_converged(answer.status) || (has_displacement(answer.status) && answer.iterations > 0);
}

bool Comparison::any_failed() const {
  const ComparisonRow* truth = reference_row();
  if (!reference.empty() && (!truth || !is_converged(truth->answer.status)))
    return true;
  return std::any_of(rows.begin(), rows.end(), [&](const ComparisonRow& row) {
    // With a reference, a method that refuses the scene is a valid result; without one, there is no answer.
    const bool accepted = row.answer.status == Status::refused && !reference.empty();
    const bool cut = (row.answer.n_cut > 0 || row.answer.status == Status::clamped) && !cut_is_allowed;
    return cut || (!is_converged(row.answer.status) && !accepted);
  });
}

Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control) {
  Methods methods;
  return compare_methods(scene, std::move(names), reference, control, methods);
}

Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control, Methods& methods, double seconds_for_reference) {
  const bool against_best = reference == "best";
  if (!reference.empty() && !against_best && std::find(names.begin(), names.end(), reference) == names.end())
    names.push_back(reference);
  Comparison comparison;
  comparison.reference = reference;
  comparison.threads = control.threads;
  comparison.cut_is_allowed = scene.limits.cut_is_allowed;
  const LimitsOnce limits(scene, names);
  comparison.taut_scale = limits.taut_scale();
  for (const std::string& method : names) {
    if (fem_ref::agree(control.should_stop()))
      break;
    const bool is_shared = methods.is_for_all_ranks(scene, method);
    if (!fem_ref::ranks().is_first() && !is_shared)
      continue;
    ComparisonRow row;
    const bool feels = deform::feels_limits(scene, method);
    Control of_method = control;
    of_method.communicator = is_shared ? fem_ref::communicator() : nullptr;
    row.answer = methods.answer(feels ? limits.known(scene) : scene, method, of_method);
    fail_where_inside_out(scene, row.answer);
    if (!fem_ref::ranks().is_first() && !method.starts_with("fem_"))
      continue; // the first rank has the answer
    if (has_displacement(row.answer.status) && feels)
      row.answer.seconds.setup += limits.seconds();
    if (is_under_way(row.answer) && limits.limits() && (feels || scene.limits_bind_relaxed()))
      row.limit_violation = violation_of(scene, *limits.limits(), row.answer);
    comparison.rows.push_back(std::move(row));
  }
  if (against_best && !fem_ref::agree(control.should_stop())) {
    BestReference best = best_reference(scene, seconds_for_reference, control, methods);
    fail_where_inside_out(scene, best.answer);
    comparison.reference_error = best.estimated_error;
    comparison.reference_coarser = best.coarser;
    comparison.rows.push_back({std::move(best.answer), std::nullopt, std::nullopt});
  }
  const ComparisonRow* truth = comparison.reference_row();
  if (truth && is_converged(truth->answer.status))
    for (ComparisonRow& row : comparison.rows)
      if (&row != truth && is_under_way(row.answer))
        row.error = compare(scene, row.answer.displacement, truth->answer.displacement);
  return comparison;
}

double largest_displacement(const Scene& scene, const Displacement& displacement) {
  double largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    double square = 0;
    for (int b = 0; b < scene.dimension(); ++b)
      square += displacement(b, node) * displacement(b, node);
    largest = std::max(largest, square);
  }
  return std::sqrt(largest);
}

void add_mechanics(const Scene& scene, Comparison& comparison) {
  const ComparisonRow* truth = comparison.reference_row();
  std::optional<MechanicsReference> reference;
  for (ComparisonRow& row : comparison.rows) {
    if (!is_under_way(row.answer))
      continue;
    row.mechanics = mechanics_of(
        scene, row.answer, deform::cell_energies(scene, row.answer, comparison.threads), comparison.threads);
    if (row.error && !reference)
      reference.emplace(scene, truth->answer, true);
    if (row.error)
      row.mechanics_errors = reference->errors_of(row.answer);
  }
}

std::vector<MeasuredValue> measured_answer(const Scene& scene, const std::vector<Measure>& measures,
                                           const Answer& answer) {
  const bool asks_for_energy =
      std::ranges::any_of(measures, [](const Measure& of) { return of.kind == MeasureKind::energy; });
  return measured(scene, measures, answer,
                  asks_for_energy ? deform::cell_energies(scene, answer) : std::vector<double>());
}

void add_measures(const Scene& scene, const std::vector<Measure>& measures, Comparison& comparison) {
  if (measures.empty())
    return;
  const auto values_of = [&](const Answer& answer) { return measured_answer(scene, measures, answer); };
  const ComparisonRow* truth = comparison.reference_row();
  std::vector<MeasuredValue> wanted;
  if (truth && is_converged(truth->answer.status))
    wanted = values_of(truth->answer);
  for (ComparisonRow& row : comparison.rows)
    if (!is_under_way(row.answer))
      row.measures = without_values(measures, scene.dimension(), std::string(to_string(row.answer.status)));
    else if (&row == truth && !wanted.empty())
      row.measures = with_errors(wanted, {});
    else
      row.measures = with_errors(values_of(row.answer), wanted);
}

void add_estimates(const Scene& scene, Comparison& comparison, const Control& control) {
  for (ComparisonRow& row : comparison.rows) {
    if (!is_under_way(row.answer) || control.should_stop())
      continue;
    const bool is_of_lattice =
        std::ranges::find(deform::methods(), row.answer.method) != deform::methods().end();
    row.estimation =
        is_of_lattice ? deform::estimate_error(scene, row.answer, control)
                      : deform::ErrorEstimation{{}, "of finite elements there is none: see --reference best"};
  }
}

} // namespace maille::studies
