#include "commands/command_line.hpp"

#include "maille/fem_ref/solve.hpp"

#include <fmt/format.h>

#include <thread>

namespace maille::studies {

namespace {

void add_overwrite(CLI::App* command, bool& overwrite) {
  command->add_flag("--overwrite", overwrite,
                    "with --out: replace results of another scene or version that are there");
}

void add_one_thread(CLI::App* command, int& threads) {
  command->add_option("--threads", threads, "threads; one is what times repeat at")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

} // namespace

void add_json(CLI::App* command, std::optional<std::string>& json, std::filesystem::path* scene) {
  command->add_option("--json", json, "machine-readable result on stdout, or in FILE")
      ->expected(0, 1)
      ->default_str("-")
      ->type_name("FILE");
  command->parse_complete_callback([&json, scene, command] {
    if (command->count("--json") && (!json || json->empty()))
      json = "-";
    if (json && scene && scene->empty() && json->ends_with(".toml")) {
      *scene = *json;
      json = "-";
    }
    if (json && json->ends_with(".toml"))
      throw CLI::ValidationError("--json", "expected a file to write, found \"" + *json + "\", a scene");
    if (scene && scene->empty())
      throw CLI::RequiredError("SCENE");
  });
}

void add_common(CLI::App* command, CommonOptions& options) {
  command->add_option("SCENE", options.scene, "scene file (TOML)");
  add_json(command, options.json, &options.scene);
}

void add_solving(CLI::App* command, std::string& fem_solver, int& threads) {
  command
      ->add_option(
          "--fem-solver", fem_solver,
          fmt::format("how finite elements solve: {}", fmt::join(maille::fem_ref::linear_solver_names, ", ")))
      ->default_str("automatic");
  command->add_option("--threads", threads, "threads")
      ->check(CLI::Range(1, 1024))
      ->default_val(std::max(1u, std::thread::hardware_concurrency()));
}

void add_running(CLI::App* command, AnswerOptions& options) {
  command->add_flag("--estimate", options.estimate,
                    "estimate how far every answer is from elasticity, and where, without finite elements");
  command
      ->add_option("--methods,--method", options.methods,
                   "methods, separated by commas; see below for their names, and for what is asked without")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--out", options.out, "folder for the files that ParaView opens");
  add_overwrite(command, options.overwrite);
  add_solving(command, options.fem_solver, options.threads);
}

void add_fit(CLI::App* command, FitOptions& options) {
  command->add_option("SCENE", options.scenes, "scene files (TOML): a family")->required();
  command->add_option("--test", options.tests, "scenes to measure on and not to fit to");
  command->add_option(
      "--holdout", options.holdout,
      "the part of SCENE to measure on and not to fit to, by lot, the same in every run; default: none");
  command->add_option("--method", options.method, "limits: fits limits; relaxed: fits its weights")
      ->capture_default_str();
  command
      ->add_option("--reference", options.reference, "what the method is to come near to: a method, or best")
      ->capture_default_str();
  command
      ->add_option("--reference-seconds", options.reference_seconds,
                   "what the reference \"best\" may take a scene, about")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--trials", options.trials, "give up after so many trials of the family")
      ->check(CLI::Range(1, 1'000'000'000))
      ->capture_default_str();
  command->add_option(
      "--out", options.out,
      "material file (TOML) to write: what scenes name as their material, of several by FILE.toml#NAME");
  add_json(command, options.json, nullptr);
  add_solving(command, options.fem_solver, options.threads);
}

void add_trade(CLI::App* command, TradeOptions& options) {
  command->add_option("SCENE", options.scene, "scene file (TOML)");
  command
      ->add_option("--methods,--method", options.methods,
                   "methods, separated by commas; default: all but the oracles")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--spacings", options.spacings,
                   "lattices: spacings over the scene's, powers of 2; default 8,4,2,1,0.5")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--tolerances", options.tolerances,
                   "of sweep, relaxed and coupled; default 0.1,0.01,0.001,0.0001")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--reference", options.reference, "what errors are measured against: a method, or best")
      ->capture_default_str();
  command
      ->add_option("--reference-seconds", options.reference_seconds,
                   "what the reference \"best\" may take, about")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--row-seconds", options.row_seconds, "what one row may take")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--repetitions", options.repetitions, "measurements of rows below a second; medians count")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--csv", options.csv,
                      "the table as CSV in FILE (- for stdout): what choose --table reads");
  command->add_option("--out", options.out, "folder for the table (JSON, CSV) and the picture (SVG, PNG)");
  command->add_flag("--all", options.all, "print every row, not only those on the Pareto fronts");
  add_json(command, options.json, &options.scene);
  add_one_thread(command, options.threads);
}

void add_choose(CLI::App* command, ChooseOptions& options) {
  command->add_option("SCENE", options.scene, "scene file (TOML)");
  command->add_option("--error", options.error, "largest relative L2 error, such as 5%")->required();
  command->add_option("--time", options.time, "longest time, set-up and solve, such as 16ms")->required();
  command->add_option("--memory", options.memory, "most memory, such as 1GiB; default: what the machine has");
  command->add_option("--level", options.level, "how often the error, and the time, are to be kept")
      ->capture_default_str();
  command
      ->add_option("--table", options.tables,
                   "tables (CSV) that `maille trade --out` wrote, separated by commas or the option "
                   "repeated, in place of the built-in one")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--write", options.write,
                      "write the scene, on the lattice that is chosen, to FILE (TOML)");
  add_json(command, options.json, &options.scene);
  add_one_thread(command, options.threads);
}

void add_study(CLI::App* command, StudyCommandOptions& options) {
  command->add_option("STUDY", options.study, "study file (TOML)")->required();
  command->add_option("--out", options.out,
                      "folder for the table and for files that ParaView opens; default out/NAME");
  add_overwrite(command, options.overwrite);
  command->add_flag("--resume", options.resume, "go on with the table that is there");
  command->add_option("--jobs", options.jobs, "cases at a time; their seconds are then marked")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--shard", options.shard,
                      "i/N: only cases i, i + N, i + 2 N, ...; maille merge puts the parts together");
  command->add_option("--picture", options.picture,
                      "plots of the errors over every parameter, in FILE (SVG or PNG)");
  add_json(command, options.json, nullptr);
  command
      ->add_option(
          "--fem-solver", options.fem_solver,
          fmt::format("how finite elements solve: {}", fmt::join(maille::fem_ref::linear_solver_names, ", ")))
      ->default_str("automatic");
  command
      ->add_option("--threads", options.threads,
                   "threads of every method; default: the processors shared among the jobs")
      ->check(CLI::Range(1, 1024));
}

void add_stability(CLI::App* command, StabilityCommandOptions& options, int& code) {
  command->add_flag("--quick", options.quick, "fewer drags, cycles and random scenes; no quadratic elements");
  command->add_option("--only", options.extremes,
                      "only this extreme, by the name that the table has for it; may be repeated");
  command->add_option("--markdown", options.markdown, "the table as a page in FILE");
  add_json(command, options.json, nullptr);
  command->add_option("--threads", options.threads, "questions at a time, each in a process of its own")
      ->check(CLI::Range(1, 1024))
      ->default_val(std::max(1u, std::thread::hardware_concurrency()));
  command->final_callback([&] { code = stability_command(options); });
}

void add_play(CLI::App* command, PlayOptions& options) {
  command->add_option("SCENE", options.scene, "scene file (TOML) with a [world]")->required();
  command->add_option("TRAJECTORY", options.trajectory, "recorded input (TOML, or CSV)")->required();
  command->add_option(
      "--out", options.out,
      "folder for files that ParaView opens, a picture a frame, and a film where there is ffmpeg");
  add_overwrite(command, options.overwrite);
  command->add_flag("!--no-pictures", options.pictures, "with --out: neither pictures nor a film");
  command->add_option("--picture", options.picture, "PNG of four moments side by side");
  add_json(command, options.json, nullptr);
  command->add_option("--threads", options.threads, "threads")
      ->check(CLI::Range(1, 1024))
      ->default_val(std::max(1u, std::thread::hardware_concurrency()));
}

void add_probe(CLI::App* command, ProbeCommandOptions& options) {
  command->add_option("SCENE", options.scene, "scene file (TOML): a world of objects, or one body")
      ->required();
  command->add_option("MOTION", options.motion, "where the hand was (CSV: time,x,y,z)")->required();
  command->add_option("--tool", options.tool,
                      "the rigid object of the scene that the hand holds; default: a point");
  command
      ->add_option("--radius", options.radius, "of the part of a body that goes with the tool, such as 2mm")
      ->capture_default_str();
  command
      ->add_option("--rule", options.rule,
                   "coupling: forces through a spring; reaction: the body's own where that is passive")
      ->check(CLI::IsMember({"coupling", "reaction"}))
      ->capture_default_str();
  const auto number = [&](const char* name, double& value, const char* what, const CLI::Validator& range) {
    command->add_option(name, value, what)->check(range)->capture_default_str();
  };
  number("--rate", options.rate, "forces a second", CLI::Range(1.0, 1e5));
  number("--stiffness", options.stiffness, "of the coupling [N/m]", CLI::PositiveNumber);
  number("--damping", options.damping, "of the coupling [N s/m]", CLI::NonNegativeNumber);
  number("--turn-stiffness", options.turn_stiffness, "of the coupling, of tools [N m/rad]",
         CLI::NonNegativeNumber);
  number("--device-damping", options.device_damping, "of the device itself [N s/m]", CLI::NonNegativeNumber);
  number("--mass", options.mass, "of hand and device [kg]; 0: the recording is followed exactly",
         CLI::NonNegativeNumber);
  number("--hand-stiffness", options.hand_stiffness, "of the hand, where it has mass [N/m]",
         CLI::NonNegativeNumber);
  number("--hand-damping", options.hand_damping, "of the hand, where it has mass [N s/m]",
         CLI::NonNegativeNumber);
  number("--largest-force", options.largest_force, "of the device [N]", CLI::PositiveNumber);
  command->add_flag("--no-clock", options.no_clock,
                    "tick after tick, physics within the tick: the same bits every time");
  command->add_option("--csv", options.csv, "a line a tick in FILE (- for stdout)");
  command->add_option("--picture", options.picture, "force and latency over time, PNG or SVG");
  add_json(command, options.json, nullptr);
  add_one_thread(command, options.threads);
}

} // namespace maille::studies
