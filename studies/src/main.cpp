/// The `maille` command: reads the command line, calls one command, turns errors into exit codes.

#include "commands/command_line.hpp"
#include "commands/help.hpp"
#include "commands/stop_signals.hpp"

#include "maille/fem_ref/ranks.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/named_files.hpp"
#include "maille/studies/version.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <thread>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace {

using namespace maille::studies;

/// What only this rank has met must not leave the others waiting.
int fail(std::string_view message, int exit_code) {
  fmt::print(stderr, "maille: {}\n", for_terminal(std::string(message)));
  maille::fem_ref::abort_ranks(exit_code);
  return exit_code;
}

/// Several ranks share finite elements, which only these commands ask for; anything else the first does
/// alone.
bool is_for_all_ranks(int argc, char** argv) {
  const std::string_view command = argc > 1 ? argv[1] : "";
  return command == "compare" || command == "run" ||
         (command == "verify" && argc > 2 && std::string_view(argv[2]) == "--ranks");
}

int run(int argc, char** argv) {
  if (!maille::fem_ref::ranks().is_first() && !is_for_all_ranks(argc, argv))
    return exit_done;
  CLI::App app("Deforms voxel models by neighbour limits and checks them against finite elements.", "maille");
  app.set_version_flag("-v,--version", std::string("maille ") + version);
  app.formatter(std::make_shared<HelpFormat>());
  app.require_subcommand(1);
  app.failure_message([](const CLI::App* asked, const CLI::Error& error) {
    return wrong_words(*asked, error) + "\nRun with --help for more information.\n";
  });
  int code = exit_done;

  CompareOptions compare;
  auto* compare_app =
      app.add_subcommand("compare", "Answer a scene by several methods and measure them against FEM");
  add_common(compare_app, compare);
  add_running(compare_app, compare);
  compare_app->add_option("--reference", compare.reference,
                          "method that errors are measured against; best: the finest finite elements "
                          "that can be afforded, with an estimate of their own error");
  compare_app
      ->add_option("--reference-seconds", compare.reference_seconds,
                   "what the reference \"best\" may take, about")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  compare_app->add_option("--csv", compare.csv, "the table as CSV in FILE (- for stdout)");
  compare_app->add_option("--picture", compare.picture, "PNG of the deformed bodies side by side");
  compare_app
      ->add_option("--picture-of", compare.picture_of,
                   "what its colours show: displacement; strain, the principal one of largest size; stress, "
                   "von Mises'")
      ->check(CLI::IsMember({"displacement", "strain", "stress"}))
      ->capture_default_str();
  compare_app->final_callback([&] { code = compare_command(compare); });

  RunOptions run;
  auto* run_app = app.add_subcommand("run", "Answer a scene by one or more methods, at once or in steps");
  add_common(run_app, run);
  add_running(run_app, run);
  run_app
      ->add_option("--steps", run.steps,
                   "steps of equal size, written as a .pvd series that begins at rest; of one the end alone "
                   "is written")
      ->default_val(1);
  run_app->final_callback([&] { code = run_command(run); });

  PlayOptions play;
  auto* play_app = app.add_subcommand("play", "Play recorded input against a world of several objects");
  add_play(play_app, play);
  play_app->final_callback([&] { code = play_command(play); });

  FitOptions fitted;
  auto* fit_app = app.add_subcommand("fit", "Find the limits, or the weights of relaxed, that come nearest "
                                            "to finite elements over a family of scenes");
  add_fit(fit_app, fitted);
  fit_app->final_callback([&] { code = fit_command(fitted); });

  TradeOptions trade;
  auto* trade_app = app.add_subcommand(
      "trade", "Measure what accuracy costs: every method, lattice and tolerance, and the Pareto front");
  add_trade(trade_app, trade);
  trade_app->final_callback([&] { code = trade_command(trade); });

  ChooseOptions chosen;
  auto* choose_app = app.add_subcommand(
      "choose", "Find the cheapest method, lattice and tolerance within an error and a time");
  add_choose(choose_app, chosen);
  choose_app->final_callback([&] { code = choose_command(chosen); });

  ProbeCommandOptions probe;
  auto* probe_app = app.add_subcommand("probe", "Feel a scene by a recorded hand, a thousand times a second");
  add_probe(probe_app, probe);
  probe_app->final_callback([&] { code = probe_command(probe); });

  StudyCommandOptions study;
  auto* study_app = app.add_subcommand("study", "Run methods over a family of scenes into one table");
  add_study(study_app, study);
  study_app->final_callback([&] { code = study_command(study); });

  MergeOptions merge;
  auto* merge_app = app.add_subcommand("merge", "Put the tables of a study's parts together");
  merge_app->add_option("DIR", merge.places, "folders with tables, or tables (*.jsonl)")->required();
  merge_app->add_option("--out", merge.out, "folder for the whole table")->required();
  merge_app->final_callback([&] { code = merge_command(merge); });

  CheckOptions check;
  auto* check_app = app.add_subcommand(
      "check", "Read a scene, a world, a study, a trajectory or a material and report every fault in it");
  add_common(check_app, check);
  check_app->add_option("TRAJECTORY", check.trajectory, "of a world: checked against it");
  check_app->final_callback([&] { code = check_any_command(check); });

  CommonOptions explain;
  auto* explain_app =
      app.add_subcommand("explain", "Say what a scene switches on, and what it pays for that");
  add_common(explain_app, explain);
  explain_app->final_callback([&] { code = explain_command(explain); });

  ExportOptions exported;
  auto* export_app = app.add_subcommand("export", "Write a scene as input of another program");
  export_app->add_option("SCENE", exported.scene, "scene file (TOML)")->required();
  export_app->add_option("--format", exported.format, "ccx: an input deck of CalculiX")
      ->check(CLI::IsMember({"ccx"}))
      ->capture_default_str();
  export_app->add_option("--out", exported.file, "file to write, usually *.inp; default: stdout");
  export_app->final_callback([&] { code = export_command(exported); });

  MaterialsOptions materials;
  auto* materials_app =
      app.add_subcommand("materials", "Show the tissue library, or one tissue with derived constants");
  materials_app->add_option("NAME", materials.name, "e.g. muscle/soleus");
  add_json(materials_app, materials.json, nullptr);
  materials_app->final_callback([&] { code = materials_command(materials); });

  BenchCommandOptions bench;
  auto* bench_app = app.add_subcommand("bench", "Measure speed and exactness against rivals, in one run");
  bench_app->add_option("SUBJECT", bench.subject, fmt::format("{}", fmt::join(bench_subjects(), ", ")))
      ->required()
      ->check(CLI::IsMember(bench_subjects()));
  bench_app->add_flag("--quick", bench.quick, "small bodies: shows that it runs, figures mean nothing");
  add_json(bench_app, bench.json, nullptr);
  bench_app->final_callback([&] { code = bench_command(bench); });

  VerifyOptions verify;
  auto* verify_app =
      app.add_subcommand("verify", "Solve problems whose answers are known; exit code 3 where one is missed");
  verify_app->add_flag("--quick", verify.quick, "coarser meshes of what takes long");
  verify_app->add_flag("--ranks", verify.ranks,
                       "only: mpirun -n N maille verify --ranks, all ranks together against one alone");
  verify_app->add_option("--markdown", verify.markdown, "the table as a page in FILE");
  add_json(verify_app, verify.json, nullptr);
  verify_app->final_callback([&] { code = verify_command(verify); });

  StabilityCommandOptions stable;
  add_stability(
      app.add_subcommand("stability", "Ask every method the extremes; exit code 3 where a promise is broken"),
      stable, code);

  ReportOptions report;
  auto* report_app = app.add_subcommand("report", "Make one page (HTML) of a folder of results");
  report_app->add_option("OUT", report.folder, "folder that compare, run, study or trade wrote")->required();
  report_app->add_option("--out", report.out, "page to write; default: report.html in that folder");
  report_app->final_callback([&] { code = report_command(report); });

  for (CLI::App* command : app.get_subcommands({}))
    if (const std::string name = command->get_name(); name != "merge" && name != "materials" &&
                                                      name != "bench" && name != "verify" &&
                                                      name != "stability" && name != "report")
      command->add_flag_callback(
          "--sandbox", [] { maille::set_file_scope(maille::FileScope::sandbox); },
          "files that the scene names must lie in its folder or below, or in that of a variable: for scenes "
          "of others");
  add_footers(app);
  keep_command_line(argc, argv);
  std::vector<std::string> words = in_parsers_words({argv + 1, argv + argc});
  if (words.size() == 2 && words[1] == "--help")
    if (const auto text = help_topic(words[0])) {
      fmt::print("{}", *text);
      return exit_done;
    }
  if (argc > 2 && std::string_view(argv[1]) == "help")
    if (const auto wrong = unknown_topic(app, argv[2]))
      return fail(*wrong, exit_faulty_input);
  std::reverse(words.begin(), words.end()); // as the parser takes a vector
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    if (!maille::fem_ref::ranks().is_first())
      return error.get_exit_code() == 0 ? exit_done : exit_faulty_input;
    return app.exit(error) == 0 ? exit_done : exit_faulty_input;
  }
  return code;
}

/// Where address space is limited (`ulimit -v`), threads of OpenBLAS ask for their buffers without end, and
/// that library waits for them as the process forks or ends. It looks at its variable as it is loaded, which
/// was before: the process begins once more.
void do_without_threads_of_blas(char** argv) {
  rlimit limit{};
  constexpr const char* variable = "OPENBLAS_NUM_THREADS";
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
      std::getenv(variable) != nullptr)
    return;
  setenv(variable, "1", 1);
  setenv("MALLOC_ARENA_MAX", "1", 0); // else every thread reserves 64 MiB for its own
  execv("/proc/self/exe", argv);      // goes on where that cannot be
}

/// Where the caller closed one of the first three, the first file that is opened would take its place, and
/// messages would end in it. Of standard output it stays an error to write there; messages have nowhere to
/// go.
void open_standard_streams() {
  for (int descriptor = 0; descriptor < 3; ++descriptor)
    if (fcntl(descriptor, F_GETFD) == -1 && open("/dev/null", descriptor == 2 ? O_WRONLY : O_RDONLY) == -1)
      std::_Exit(exit_run_failed);
}

/// What is still in a buffer when the process ends would be lost without a word where the disk is full.
int with_all_output(int exit_code) {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return fail("cannot write to standard output", exit_run_failed);
  return exit_code;
}

} // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a limit of a file's size is then an error of writing, and said as such
  do_without_threads_of_blas(argv);
  catch_stop_signals();
  maille::fem_ref::start_ranks();
  try {
    return leave(with_all_output(run(argc, argv)));
  } catch (const maille::InputError& error) { // met by all ranks
    if (maille::fem_ref::ranks().is_first())
      fmt::print(stderr, "{}\n", for_terminal(error.what()));
    return leave(exit_faulty_input);
  } catch (const UsageError& error) {
    return leave(fail(error.what(), exit_faulty_input));
  } catch (const std::bad_alloc&) {
    return leave(fail("out of memory", exit_run_failed));
  } catch (const std::exception& error) {
    return leave(fail(error.what(), exit_run_failed));
  }
}
