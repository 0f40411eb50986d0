#include "bench/studies/studies.hpp"

#include "bench/studies/scene_maker.hpp"
#include "compare/methods.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr std::size_t n_quick = 2;
constexpr double factor = 2, reference_seconds = 10;

/// How many of the answers of each sort there were.
struct KindsTally {
  int answers = 0, estimated = 0, below = 0, within = 0;
};

/// The true answer at the scene's own nodes; nothing where no trusted one can be had.
std::optional<Displacement> true_answer(const Scene& scene, const Control& control) {
  if (scene.specimen.shape == "box") {
    const Scene fine = refined(scene);
    const Answer answer = answer_by(fine, "fem_q2", control);
    if (is_converged(answer.status))
      return at_coarse_nodes(scene, fine, answer.displacement);
  }
  Methods methods;
  BestReference best = best_reference(scene, reference_seconds, control, methods);
  if (!is_converged(best.answer.status))
    return std::nullopt;
  return std::move(best.answer.displacement);
}

void judge(const KindScene& kind, const Scene& scene, BenchReport& report, KindsTally& tally) {
  Control control;
  control.threads = 1;
  const Answer answer = answer_by(scene, "coupled", control);
  const auto truth = true_answer(scene, control);
  if (!truth || !is_converged(answer.status)) {
    report.notes.push_back(fmt::format("estimate_kinds: {}: not counted: {}", kind.name,
                                       truth ? answer.message : "finite elements have no answer"));
    return;
  }
  ++tally.answers;
  const double true_error = compare(scene, answer.displacement, *truth).relative_l2;
  const deform::ErrorEstimation found = deform::estimate_error(scene, answer.displacement, control);
  nlohmann::ordered_json row{{"kind", kind.name}, {"true_error", true_error}};
  if (found.estimate) {
    const double ratio = found.estimate->norms.relative_l2 / true_error;
    ++tally.estimated;
    tally.below += ratio >= 1 ? 1 : 0;
    tally.within += ratio >= 1 / factor && ratio <= factor ? 1 : 0;
    row["estimated_error"] = found.estimate->norms.relative_l2;
    row["ratio"] = ratio;
    row["other_lattice"] = deform::to_string(found.estimate->lattice);
    row["cycles"] = found.estimate->cycles;
    row["estimate_over_coupled"] = found.estimate->seconds / answer.seconds.total();
    report.rows.push_back(std::move(row));
  } else {
    report.notes.push_back(fmt::format("estimate_kinds: {}: true error {:.3g}, no estimate: {}", kind.name,
                                       true_error, found.reason));
  }
}

} // namespace

void check_estimate_kinds(const BenchOptions& options, const Control& control, BenchReport& report) {
  const SceneSet kinds = kind_scenes(1);
  KindsTally tally;
  for (const std::size_t i : spread(kinds.list().size(), options.quick ? n_quick : kinds.list().size())) {
    const KindScene& kind = kinds.list()[i];
    if (!goes_on(control, static_cast<double>(i) / static_cast<double>(kinds.list().size()),
                 "estimates, " + kind.name))
      break;
    try {
      judge(kind, parse_scene(kind.text, kinds.folder() / "kind.toml"), report, tally);
    } catch (const InputError& error) { // images that others have put into MAILLE_DATA
      report.notes.push_back(fmt::format("estimate_kinds: {}: {}", kind.name, error.what()));
    }
  }
  const double n = std::max(tally.estimated, 1);
  report.checks.push_back({"estimate_kinds_below", tally.below / n});
  report.checks.push_back({"estimate_kinds_within_2", tally.within / n});
  report.checks.push_back(
      {"estimate_kinds_estimated", static_cast<double>(tally.estimated) / std::max(tally.answers, 1)});
}

} // namespace maille::lab
