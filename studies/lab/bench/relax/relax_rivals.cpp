#include "bench/relax/relax.hpp"
#include "maille/scene/answer.hpp"
#include "rivals/lattice_rivals.hpp"

#include <limits>

namespace maille::lab {

namespace {

/// The best of three runs, for what a rival comes to hangs on how much of the processor it gets.
/// @return its error; nothing where it was not built
std::optional<double> best_of_three(const std::string& name, const Scene& box, const Displacement& reference,
                                    double seconds, BenchReport& report,
                                    const std::function<std::optional<RivalResult>()>& run) {
  std::optional<RivalResult> best;
  double least = std::numeric_limits<double>::infinity();
  for (int time = 0; time < 3; ++time) {
    std::optional<RivalResult> result = run();
    if (!result)
      return std::nullopt;
    const double error = result->displacement.empty()
                             ? std::numeric_limits<double>::infinity()
                             : compare(box, result->displacement, reference).relative_l2;
    if (!best || error < least) {
      least = error;
      best = std::move(result);
    }
  }
  report.add({{"rival", name},
              {"nodes", nodes_in_words(box)},
              {"budget_s", seconds},
              {"setup_s_not_counted", best->seconds_of_setup},
              {"seconds", best->seconds},
              {"time_steps", best->iterations},
              {"error", least},
              {"note", best->note}});
  return least;
}

} // namespace

void bench_rivals(const Scene& box, const Displacement& reference, const Measured& coupled,
                  BenchReport& report, RelaxFigures& figures) {
  const double seconds = coupled.seconds.total();
  figures.rivals.coupled_error = *coupled.error;
  figures.rivals.xpbd_error = *best_of_three("XPBD", box, reference, seconds, report,
                                             [&] { return std::optional(relax_by_xpbd(box, seconds)); });
  figures.rivals.bullet_error =
      best_of_three("Bullet", box, reference, seconds, report, [&] { return relax_by_bullet(box, seconds); });
  if (!figures.rivals.bullet_error)
    report.notes.emplace_back("bullet_error_at_equal_time omitted: built without libbullet.");
}

} // namespace maille::lab
