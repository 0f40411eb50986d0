#include "bench/studies/studies.hpp"

#include "bench/studies/scene_maker.hpp"
#include "choose/choose.hpp"
#include "compare/methods.hpp"
#include "maille/materials/fault.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>

namespace maille::lab {

namespace {

constexpr std::size_t n_quick = 2;
constexpr double reference_seconds = 60, quick_reference_seconds = 2;
constexpr std::array wishes{0.05, 0.1, 0.2, 0.4};

struct UnlikeTally {
  int scenes = 0, promises = 0, kept = 0, within = 0, without_reference = 0;
};

/// Error of the chosen way; infinite without an answer.
double error_of(Lattices& lattices, const Way& way, const Displacement& reference) {
  const Scene& scene = *lattices.at(way.halvings).scene;
  const Measured run = measure(scene, way.method, way.tolerance, {});
  if (!is_converged(run.answer.status))
    return std::numeric_limits<double>::infinity();
  return compare(lattices.scene(), between_lattices(scene, run.answer.displacement, lattices.scene()),
                 reference)
      .relative_l2;
}

void ask(const KindScene& kind, const SceneSet& scenes, double error, const Calibration& calibration,
         double seconds, const Control& control, BenchReport& report, UnlikeTally& tally) {
  Lattices lattices(kind.text, scenes.folder() / "kind.toml");
  ++tally.scenes;
  Wish wish;
  wish.error = error;
  wish.seconds = 60;
  const Choice choice = choose(lattices, wish, calibration, control);
  if (!choice.chosen) {
    report.notes.push_back(fmt::format("choose_unlike: {}: nothing promised for {:.0f} %{}{}", kind.name,
                                       100 * error, choice.probes.why_not.empty() ? "" : ": ",
                                       choice.probes.why_not));
    return;
  }
  Methods methods;
  const BestReference reference = best_reference(lattices.scene(), seconds, control, methods);
  if (!is_converged(reference.answer.status) || !reference.estimated_error ||
      reference.estimated_error->relative_l2 > error) {
    ++tally.without_reference;
    report.notes.push_back(fmt::format(
        "choose_unlike: {}: promised {:.2g} %, not judged: {}", kind.name, 100 * choice.chosen->error.high,
        reference.estimated_error ? fmt::format("the reference is known to {:.2g} % only",
                                                100 * reference.estimated_error->relative_l2)
                                  : "no reference knows its error"));
    return;
  }
  const double measured = error_of(lattices, choice.chosen->way, reference.answer.displacement);
  ++tally.promises;
  tally.kept += measured <= error;
  tally.within += measured <= choice.chosen->error.high;
  report.rows.push_back({{"unlike", kind.name},
                         {"wish", error},
                         {"chosen", choice.chosen->way.method},
                         {"spacing_factor", std::exp2(-choice.chosen->way.halvings)},
                         {"probe_factor", std::exp2(-choice.probes.halvings)},
                         {"expected", choice.chosen->error.median},
                         {"promised", choice.chosen->error.high},
                         {"measured", measured},
                         {"reference", reference.estimated_error->relative_l2}});
}

} // namespace

void add_choose_unlike_checks(const BenchOptions& options, const Control& control, BenchReport& report) {
  const SceneSet scenes = unlike_scenes();
  const Calibration calibration(built_in_trade_table());
  Control quiet;
  quiet.stop_requested = control.stop_requested;
  UnlikeTally tally;
  std::size_t turn = 0;
  for (const std::size_t i : spread(scenes.list().size(), options.quick ? n_quick : scenes.list().size())) {
    if (!goes_on(control, static_cast<double>(turn) / static_cast<double>(scenes.list().size()),
                 "choices, " + scenes.list()[i].name))
      break;
    try {
      ask(scenes.list()[i], scenes, wishes[turn++ % wishes.size()], calibration,
          options.quick ? quick_reference_seconds : reference_seconds, quiet, report, tally);
    } catch (const InputError& error) { // images that others have put into MAILLE_DATA
      report.notes.push_back(fmt::format("choose_unlike: {}: {}", scenes.list()[i].name, error.what()));
    }
  }
  report.notes.push_back(fmt::format("choose_unlike: {} scenes, {} promises, {} of them within their own "
                                     "upper end; {} more were not judged: their reference "
                                     "is not known to be within the wish",
                                     tally.scenes, tally.promises, tally.within, tally.without_reference));
  const double n = std::max(tally.promises, 1);
  report.checks.push_back({"choose_unlike_kept", tally.kept / n});
  report.checks.push_back(
      {"choose_unlike_refused",
       (tally.scenes - tally.promises - tally.without_reference) / static_cast<double>(tally.scenes)});
}

} // namespace maille::lab
