#include "cli/command_table.hpp"

#include "cli/command_line.hpp"

#include <memory>

namespace maille::studies {

namespace {

/// Options that live as long as what runs the command with them.
template<class Options>
auto taking(void (*add)(CLI::App*, Options&), int (*run)(const Options&)) {
  return [add, run](CLI::App* command) {
    const auto options = std::make_shared<Options>();
    add(command, *options);
    return [options, run] { return run(*options); };
  };
}

} // namespace

std::vector<Command> all_commands() {
  return {
      {"compare", "Answer a scene by several methods and measure them against FEM",
       "maille compare strip.toml --methods limits,coupled,fem_q1 --out out/strip", "files.md",
       taking(add_compare, compare_command)},
      {"run", "Answer a scene by one or more methods, at once or in steps",
       "maille run strip.toml --steps 10 --out out/strip", "command.md", taking(add_run, run_command)},
      {"play", "Play recorded input against a world of several objects",
       "maille play world.toml press.toml --out out/press", "world.md", taking(add_play, play_command)},
      {"fit",
       "Find the limits, or the weights of relaxed, that come nearest to finite elements over a family of "
       "scenes",
       "maille fit pull.toml bend.toml --out fitted.toml", "fit.md", taking(add_fit, fit_command)},
      {"trade", "Measure what accuracy costs: every method, lattice and tolerance, and the Pareto front",
       "maille trade strip.toml --out out/trade", "trade.md", taking(add_trade, trade_command)},
      {"choose", "Find the cheapest method, lattice and tolerance within an error and a time",
       "maille choose strip.toml --error 5% --time 16ms", "trade.md", taking(add_choose, choose_command)},
      {"probe", "Feel a scene by a recorded hand, a thousand times a second",
       "maille probe world.toml hand.csv --tool stamp --csv felt.csv", "probe.md",
       taking(add_probe, probe_command)},
      {"study", "Run methods over a family of scenes into one table",
       "maille study pennation.toml --out out/pennation", "study.md", taking(add_study, study_command)},
      {"merge", "Put the tables of a study's parts together", "maille merge part1 part2 --out whole",
       "study.md", taking(add_merge, merge_command), false},
      {"check", "Read a scene, a world, a study, a trajectory or a material and report every fault in it",
       "maille check strip.toml", "scene.md", taking(add_check, check_any_command)},
      {"explain", "Say what a scene switches on, and what it pays for that", "maille explain strip.toml",
       "scene.md", taking(add_common, explain_command)},
      {"export", "Write a scene as input of another program", "maille export strip.toml --out strip.inp",
       "verification.md", taking(add_export, export_command)},
      {"materials", "Show the tissue library, or one tissue with derived constants",
       "maille materials muscle/soleus", "tissue_to_limits.md", taking(add_materials, materials_command),
       false},
      {"bench", "Measure speed and exactness against rivals, in one run", "maille bench relax --quick",
       "relax.md", taking(add_bench, bench_command), false},
      {"verify", "Solve problems whose answers are known; exit code 3 where one is missed",
       "maille verify --quick", "verification.md", taking(add_verify, verify_command), false},
      {"stability", "Ask every method the extremes; exit code 3 where a promise is broken",
       "maille stability --quick", "stability.md", taking(add_stability, stability_command), false},
      {"report", "Make one page (HTML) of a folder of results", "maille report out/strip", "report.md",
       taking(add_report, report_command), false},
  };
}

} // namespace maille::studies
