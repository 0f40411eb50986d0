#include "cli/commands.hpp"

#include "bench/fem.hpp"
#include "bench/materials/materials.hpp"
#include "bench/propagate/propagate.hpp"
#include "bench/relax/relax.hpp"
#include "bench/studies/studies.hpp"
#include "bench/world/world.hpp"

#include <algorithm>
#include <array>
#include <thread>

namespace maille::studies {

namespace {

using Bench = BenchReport (*)(const BenchOptions&, const Control&);

/// One that ends by itself, and is timed with nothing beside it.
template<BenchReport (*bench)(const BenchOptions&)>
BenchReport alone(const BenchOptions& options, const Control&) {
  return bench(options);
}

struct Subject {
  const char* name;
  Bench bench;
  bool stops = false; ///< by itself, after Ctrl-C, with what it has
};

constexpr std::array subjects{
    Subject{"propagate", alone<bench_propagate>},
    Subject{"relax", alone<bench_relax>},
    Subject{"fem", alone<bench_fem>},
    Subject{"materials", bench_materials, true},
    Subject{"studies", bench_studies, true},
    Subject{"estimates", bench_estimates, true},
    Subject{"choices", bench_choices, true},
    Subject{"world", alone<bench_world>},
};

} // namespace

std::vector<std::string> bench_subjects() {
  std::vector<std::string> names;
  for (const Subject& subject : subjects)
    names.emplace_back(subject.name);
  return names;
}

int bench_command(const BenchCommandOptions& options) {
  prepare_file("--json", options.json);
  const Subject& subject =
      *std::ranges::find_if(subjects, [&](const Subject& s) { return s.name == options.subject; });
  const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const Control control = subject.stops ? terminal_control(threads) : Control{};
  const BenchReport report = subject.bench({.quick = options.quick}, control);
  end_progress();
  deliver(options.json ? json_text(report.json()) : report.table(), options.json);
  return control.should_stop() ? exit_run_failed : exit_done;
}

} // namespace maille::studies
