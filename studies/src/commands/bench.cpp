#include "cli/commands.hpp"

#include "bench/anatomy/anatomy.hpp"
#include "bench/bodies/bodies.hpp"
#include "bench/ecosystem/ecosystem.hpp"
#include "bench/fem.hpp"
#include "bench/live/live.hpp"
#include "bench/materials/materials.hpp"
#include "bench/mechanics/mechanics.hpp"
#include "bench/propagate/propagate.hpp"
#include "bench/relax/relax.hpp"
#include "bench/render/render.hpp"
#include "bench/studies/studies.hpp"
#include "bench/world/world.hpp"

#include <algorithm>
#include <array>
#include <thread>

namespace maille::studies {

namespace {

using Bench = BenchReport (*)(const BenchOptions&, const Control&);

/// One that is stopped between two rows.
template<void (*bench)(const BenchOptions&, BenchReport&)>
BenchReport row_by_row(const BenchOptions& options, const Control& control) {
  BenchReport report;
  report.control = control;
  try {
    bench(options, report);
  } catch (const BenchStopped&) {
    report.checks.clear();
    report.notes.emplace_back("stopped: rows that were measured by then, and no checks");
  }
  return report;
}

struct Subject {
  const char* name;
  Bench bench;
};

constexpr std::array subjects{
    Subject{"propagate", row_by_row<bench_propagate>},
    Subject{"relax", row_by_row<bench_relax>},
    Subject{"bodies", row_by_row<bench_bodies>},
    Subject{"fem", row_by_row<bench_fem>},
    Subject{"materials", bench_materials},
    Subject{"mechanics", row_by_row<bench_mechanics>},
    Subject{"anatomy", row_by_row<bench_anatomy>},
    Subject{"studies", bench_studies},
    Subject{"estimates", bench_estimates},
    Subject{"choices", bench_choices},
    Subject{"world", row_by_row<bench_world>},
    Subject{"live", row_by_row<bench_live>},
    Subject{"ecosystem", row_by_row<bench_ecosystem>},
    Subject{"render", row_by_row<bench_render>},
};

} // namespace

std::vector<std::string> bench_subjects() {
  std::vector<std::string> names;
  for (const Subject& subject : subjects)
    names.emplace_back(subject.name);
  return names;
}

int bench_command(const BenchCommandOptions& options) {
  if (!options.only.empty() && options.subject != "world")
    throw UsageError("--only: expected the subject `world`, found `" + options.subject + "`");
  prepare_file("--json", options.json);
  const Subject& subject =
      *std::ranges::find_if(subjects, [&](const Subject& s) { return s.name == options.subject; });
  const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const Control control = terminal_control(threads);
  const BenchReport report = subject.bench({.quick = options.quick, .only = options.only}, control);
  end_progress();
  deliver(options.json ? json_text(report.json()) : report.table(), options.json);
  return control.should_stop() ? exit_run_failed : exit_done;
}

} // namespace maille::studies
