#include "bench/studies/mechanics_promises.hpp"

#include "bench/studies/scene_maker.hpp"
#include "choose/choose.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace maille::lab {

namespace {

constexpr std::uint32_t seed = 20270116;
constexpr int n_scenes = 40, n_quick = 4;
constexpr std::array wishes{0.05, 0.1, 0.2, 0.4};
constexpr double most_seconds = 60;

struct ForceTally {
  int scenes = 0, promises = 0, kept = 0, within = 0, without_reference = 0;
};

void ask(const UnseenScene& asked, double error, const Calibration& calibration, const Control& control,
         BenchReport& report, ForceTally& tally) {
  Lattices lattices(asked.text, "unseen.toml");
  ++tally.scenes;
  Wish wish;
  wish.error = error;
  wish.seconds = most_seconds;
  wish.of = *quantity_named("force");
  const std::string name = fmt::format("{}, {}, {}", asked.shape, asked.load, asked.material);
  const Choice choice = choose(lattices, wish, calibration, control);
  if (!choice.chosen) {
    report.notes.push_back(fmt::format("choose_force: {}: nothing promised for {:.0f} %{}{}", name,
                                       100 * error, choice.probes.why_not.empty() ? "" : ": ",
                                       choice.probes.why_not));
    return;
  }
  const auto truth = true_mechanics(lattices.scene(), control);
  if (!truth) {
    ++tally.without_reference;
    return;
  }
  const Way& way = choice.chosen->way;
  const LatticeScene lattice = lattices.at(way.halvings);
  const Measured run = measure(*lattice.scene, way.method, way.tolerance, control);
  const auto measured = wish.of.difference({lattice.scene.get(), &run.answer}, {&lattices.scene(), &*truth});
  ++tally.promises;
  tally.kept += measured && *measured <= error;
  tally.within += measured && *measured <= choice.chosen->error.high;
  report.rows.push_back({{"force of", name},
                         {"wish", error},
                         {"spacing_factor", std::exp2(-way.halvings)},
                         {"tolerance", way.tolerance.value_or(0)},
                         {"probe_factor", std::exp2(-choice.probes.halvings)},
                         {"growth", choice.probes.growth.value_or(0)},
                         {"expected", choice.chosen->error.median},
                         {"promised", choice.chosen->error.high},
                         {"measured", measured.value_or(-1)}});
}

} // namespace

std::vector<BenchCheck> choose_force_checks(const BenchOptions& options, const Control& control,
                                            BenchReport& report) {
  const Calibration calibration(built_in_trade_table());
  Control quiet;
  quiet.stop_requested = control.stop_requested;
  UnseenScenes scenes(seed);
  ForceTally tally;
  const int wanted = options.quick ? n_quick : n_scenes;
  for (int i = 0; i < wanted; ++i) {
    if (!goes_on(control, static_cast<double>(i) / wanted, "choices by force"))
      break;
    ask(scenes.draw(), wishes[static_cast<std::size_t>(i) % wishes.size()], calibration, quiet, report,
        tally);
  }
  report.notes.push_back(
      fmt::format("choose_force: {} scenes, {} promises, {} of them within their own upper "
                  "end; {} were not judged: finite elements have no answer",
                  tally.scenes, tally.promises, tally.within, tally.without_reference));
  return {{"choose_force_kept", tally.kept / static_cast<double>(std::max(tally.promises, 1))},
          {"choose_force_refused", (tally.scenes - tally.promises - tally.without_reference) /
                                       static_cast<double>(std::max(tally.scenes, 1))}};
}

} // namespace maille::lab
