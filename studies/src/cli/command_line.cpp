#include "cli/command_line.hpp"

#include "cli/live_options.hpp"
#include "maille/fem_ref/solve.hpp"

#include <fmt/format.h>

#include <thread>

namespace maille::studies {

namespace {

/// `--out`, `--picture` or `--csv`: a file or a folder to write.
template<class File>
CLI::Option* add_file(CLI::App* command, const char* name, File& file, const std::string& meaning) {
  return command->add_option(name, file, meaning);
}

template<class Scene>
CLI::Option* add_scene(CLI::App* command, Scene& scene, const std::string& meaning = "scene file (TOML)") {
  return command->add_option("SCENE", scene, meaning);
}

/// Adds the length unit of files; shows its default, if it has one.
template<class Unit>
void add_unit(CLI::App* command, Unit& unit, const std::string& of_what) {
  command->add_option("--unit", unit, of_what)->check(CLI::IsMember({"mm", "m"}))->capture_default_str();
}

/// Adds the number of threads, for timed commands.
void add_one_thread(CLI::App* command, int& threads) {
  command->add_option("--threads", threads, "threads; one is what times repeat at")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

/// Adds the number of threads; default: number of processors.
void add_threads(CLI::App* command, int& threads, const std::string& meaning = "threads") {
  command->add_option("--threads", threads, meaning)
      ->check(CLI::Range(1, 1024))
      ->default_val(std::max(1u, std::thread::hardware_concurrency()));
}

void add_fem_solver(CLI::App* command, std::string& fem_solver) {
  command
      ->add_option(
          "--fem-solver", fem_solver,
          fmt::format("how finite elements solve: {}", fmt::join(maille::fem_ref::linear_solver_names, ", ")))
      ->default_str("automatic");
}

/// Adds a time > 0.
void add_seconds(CLI::App* command, const std::string& name, double& seconds, const std::string& meaning) {
  command->add_option(name, seconds, meaning)->check(CLI::PositiveNumber)->capture_default_str();
}

/// Adds a list of values separated by commas.
template<class List>
void add_list(CLI::App* command, const std::string& name, List& list, const std::string& meaning) {
  command->add_option(name, list, meaning)->delimiter(',')->allow_extra_args(false);
}

/// Without a value, `--json` means stdout; a scene is not mistaken for its file.
void settle_json(CLI::App* command, std::optional<std::string>& json, std::filesystem::path* scene) {
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
}

/// `--json` without a value prints to stdout, `--json FILE` writes a file; a scene is not mistaken for that
/// file.
/// @param scene of the command, if any: it must exist
void add_json(CLI::App* command, std::optional<std::string>& json, std::filesystem::path* scene) {
  command->add_option("--json", json, "machine-readable result on stdout, or in FILE")
      ->expected(0, 1)
      ->default_str("-")
      ->type_name("FILE");
  command->parse_complete_callback([&json, scene, command] { settle_json(command, json, scene); });
}

/// Adds the field that colours of a picture or a film show.
CLI::Option* add_field(CLI::App* command, const std::string& name, std::string& field,
                       const std::string& meaning, const std::vector<std::string>& more = {}) {
  std::vector<std::string> fields{"displacement", "strain", "stress", "error"};
  fields.insert(fields.end(), more.begin(), more.end());
  return command->add_option(name, field, meaning)->check(CLI::IsMember(fields));
}

/// Adds options of commands that solve a scene.
void add_running(CLI::App* command, AnswerOptions& options) {
  add_common(command, options);
  command->add_flag("--estimate", options.estimate,
                    "estimate how far every answer is from elasticity, and where, without finite elements");
  add_list(command, "--methods,--method", options.methods,
           "methods, separated by commas; see below for their names, and for what is asked without");
  add_file(command, "--out", options.out, "folder for the files that ParaView opens");
  add_unit(command, options.unit,
           "with --out: lengths in files for viewers, mm or m; default: m in .vti and .vtu, mm in surfaces");
  add_fem_solver(command, options.fem_solver);
  add_threads(command, options.threads);
}

/// Adds options for images to warp with an answer.
void add_images(CLI::App* command, WarpOptions& options, const std::string& when) {
  command->add_option("--image", options.image,
                      when +
                          "image of grey values (.nii, .nii.gz, .mha, .mhd, .nrrd, .vti, or a DICOM folder)");
  command->add_option("--labels", options.labels,
                      when + "image of labels; default: the one that the body was read from");
  add_list(command, "--also", options.also,
           when + "formats beside .nii.gz, of warped images and the pull field");
  command->get_option("--also")->type_name("TEXT:{mha,nrrd}");
  command
      ->add_option("--background", options.background,
                   when + "value of the warped image where there is no matter")
      ->capture_default_str();
  add_list(command, "--surface", options.surfaces,
           when + "formats of the deformed labels' (else materials') surfaces");
  command->get_option("--surface")->type_name("TEXT:{stl,ply,vtp}");
}

} // namespace

void add_common(CLI::App* command, CommonOptions& options) {
  add_scene(command, options.scene);
  add_json(command, options.json, &options.scene);
}

void add_compare(CLI::App* command, CompareOptions& options) {
  add_running(command, options);
  command->add_option("--reference", options.reference,
                      "method that errors are measured against; best: the finest finite elements "
                      "that can be afforded, with an estimate of their own error");
  add_seconds(command, "--reference-seconds", options.reference_seconds,
              "what the reference \"best\" may take, about");
  add_file(command, "--csv", options.csv, "the table as CSV in FILE (- for stdout)");
  add_file(command, "--picture", options.picture, "PNG of the deformed bodies side by side");
  add_field(command, "--picture-of", options.picture_of,
            "what its colours show: strain is the principal one of largest size; stress von Mises'; error "
            "against the reference")
      ->capture_default_str();
}

void add_run(CLI::App* command, RunOptions& options) {
  add_running(command, options);
  command
      ->add_option("--steps", options.steps,
                   "steps of equal size, written as a .pvd series that begins at rest; of one the end alone "
                   "is written")
      ->default_val(1);
  add_file(command, "--picture", options.picture,
           "with --steps: PNG or SVG of the force and the energy over the displacement");
  auto* film = command->add_option("--film", options.film,
                                   "with --steps: MP4 of the body, step by step; needs ffmpeg");
  add_field(command, "--field", options.field, "with --film: what its colours show; error needs --estimate")
      ->capture_default_str()
      ->needs(film);
  command->add_flag(
      "--maps", options.maps,
      "with --out: strain, displacement and stress of the last step on the voxels of the body's "
      "image (NIfTI), to lie over the scan");
  command->add_flag("--warp", options.is_warped,
                    "with --out: images and labels where the last step has moved them, and the fields that "
                    "other programs take");
  add_images(command, options.warp, "with --warp: ");
  command->add_option(
      "--write", options.write,
      "the question as input of CalculiX, in FILE.inp (- for stdout); alone it answers nothing");
}

void add_warp(CLI::App* command, WarpCommandOptions& options) {
  add_common(command, options);
  add_list(command, "--methods,--method", options.methods, "methods, separated by commas; default: coupled");
  add_images(command, options.warp, "");
  add_unit(command, options.warp.unit, "of surfaces: mm or m");
  add_file(command, "--out", options.out, "folder for warped images and labels, and the fields");
  add_fem_solver(command, options.fem_solver);
  add_threads(command, options.threads);
}

void add_merge(CLI::App* command, MergeOptions& options) {
  command->add_option("DIR", options.places, "folders with tables, or tables (*.jsonl)")->required();
  add_file(command, "--out", options.out, "folder for the whole table")->required();
  command->add_option("--study", options.study,
                      "the study that the tables are of: says which parameter makes which share (Sobol)");
}

void add_check(CLI::App* command, CheckOptions& options) {
  add_common(command, options);
  command->get_option("SCENE")->description(
      "scene file (TOML), another file, a tissue such as muscle/soleus, or library");
  command->add_option("TRAJECTORY", options.trajectory, "of a world: checked against it");
  command->add_flag("--why", options.why, "say what the scene switches on, and what it pays for that");
  add_file(command, "--picture", options.picture,
           "PNG of the question: labels, holds, moves, loads and fibres, with the world's axes");
}

void add_new(CLI::App* command, NewOptions& options) {
  command->add_option("KIND", options.kind, "strip, calf, image or world")
      ->required()
      ->check(CLI::IsMember({"strip", "calf", "image", "world"}));
  command->add_option("LABELS", options.labels, "of an image: the file with its labels");
  add_file(command, "--out", options.out,
           "file to write, of a calf a folder; default: strip.toml, calf, world.toml, or the image's name");
}

void add_report(CLI::App* command, ReportOptions& options) {
  command->add_option("OUT", options.folder, "folder that compare, run, study or trade wrote")->required();
  add_file(command, "--out", options.out, "page to write; default: report.html in that folder");
}

void add_manual(CLI::App* command, ManualOptions& options) {
  add_file(command, "--out", options.out,
           "folder that becomes like /usr/share: man/man1, bash-completion, zsh/vendor-completions")
      ->required();
}

void add_fit(CLI::App* command, FitOptions& options) {
  add_scene(command, options.scenes, "scene files (TOML): a family")->required();
  command->add_option("--test", options.tests, "scenes to measure on and not to fit to");
  command->add_option("--holdout", options.holdout,
                      "the part of SCENE to measure on and not to fit to, chosen at random, the same in "
                      "every run; default: none");
  command->add_option(
      "--method", options.method,
      "limits (default): fits limits; relaxed: fits its weights; with --measured the one that "
      "answers, default coupled");
  command
      ->add_option("--reference", options.reference, "what the method is to come near to: a method, or best")
      ->capture_default_str();
  add_seconds(command, "--reference-seconds", options.reference_seconds,
              "what the reference \"best\" may take a scene, about");
  command->add_option("--trials", options.trials, "give up after this many trials of the family")
      ->check(CLI::Range(1, 1'000'000'000))
      ->capture_default_str();
  add_file(
      command, "--out", options.out,
      "material file (TOML) to write: what scenes name as their material, of several by FILE.toml#NAME; with "
      "--measured the scene with the values that were found");
  add_json(command, options.json, nullptr);
  add_fem_solver(command, options.fem_solver);
  add_threads(command, options.threads);
  add_list(
      command, "--measured", options.measured,
      "fit constants to these files, one a scene, separated by commas: CSV of its [[measure]] tables, with "
      "the columns measure, value and, if wanted, sigma and fraction; or of points: x, y, z, ux, uy, uz; "
      "or an image of displacements in mm");
  auto* const measured = command->get_option("--measured");
  command
      ->add_option("--sigma", options.sigma,
                   "standard deviation of the displacements of an image or of points, a length")
      ->needs(measured);
  add_list(command, "--unknown", options.unknowns,
           "keys of the scene, separated by commas, such as specimen.material.E_fibre, or constants of its "
           "materials, \"E_fibre, E_cross of muscle/soleus\"; the search begins with their values");
  measured->needs(command->get_option("--unknown")->needs(measured));
  for (const char* name : {"--test", "--holdout", "--reference", "--reference-seconds", "--trials"})
    measured->excludes(command->get_option(name));
}

void add_trade(CLI::App* command, TradeOptions& options) {
  add_scene(command, options.scene);
  add_list(command, "--methods,--method", options.methods,
           "methods, separated by commas; default: all but the oracles");
  add_list(command, "--spacings", options.spacings,
           "lattices: spacings over the scene's, powers of 2; default 8,4,2,1,0.5");
  add_list(command, "--tolerances", options.tolerances,
           "of sweep, relaxed and coupled; default 0.1,0.01,0.001,0.0001");
  command->add_option("--reference", options.reference, "what errors are measured against: a method, or best")
      ->capture_default_str();
  add_seconds(command, "--reference-seconds", options.reference_seconds,
              "what the reference \"best\" may take, about");
  add_seconds(command, "--row-seconds", options.row_seconds, "what one row may take");
  command
      ->add_option("--repetitions", options.repetitions, "measurements of rows below a second; medians count")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_file(command, "--csv", options.csv,
           "the table as CSV in FILE (- for stdout): what choose --table reads");
  add_file(command, "--out", options.out, "folder for the table (JSON, CSV) and the picture (SVG, PNG)");
  command->add_flag("--all", options.all, "print every row, not only those on the Pareto fronts");
  add_json(command, options.json, &options.scene);
  add_one_thread(command, options.threads);
}

void add_choose(CLI::App* command, ChooseOptions& options) {
  add_scene(command, options.scene);
  command->add_option("--error", options.error, "largest relative error, such as 5%")->required();
  command
      ->add_option(
          "--of", options.of,
          "what the error is of: displacement (L2), force (on moves, else holds), energy, stress (L2 over "
          "cells), or the name of a [[measure]]")
      ->capture_default_str();
  command->add_option("--time", options.time, "longest time, set-up and solve, such as 16ms")->required();
  command->add_option("--memory", options.memory, "most memory, such as 1GiB; default: what the machine has");
  command->add_option("--level", options.level, "how often the error, and the time, are to be kept")
      ->capture_default_str();
  add_list(command, "--table", options.tables,
           "tables (CSV) that `maille study trade --out` wrote, separated by commas or the option "
           "repeated, in place of the built-in one");
  command->add_option("--write", options.write,
                      "write the scene, on the lattice that is chosen, to FILE (TOML)");
  add_json(command, options.json, &options.scene);
  add_one_thread(command, options.threads);
}

void add_study(CLI::App* command, StudyCommandOptions& options) {
  command->add_option("STUDY", options.study, "study file (TOML)")->required();
  add_file(command, "--out", options.out,
           "folder for the table and for files that ParaView opens; default out/NAME");
  add_unit(command, options.unit, "lengths in files for ParaView, mm or m");
  command->add_flag("--resume", options.resume, "go on with the table that is there");
  command->add_option("--jobs", options.jobs, "cases at a time; their seconds are then marked")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--shard", options.shard,
                      "i/N: only cases i, i + N, i + 2 N, ...; maille study merge puts the parts together");
  add_file(command, "--picture", options.picture,
           "plots over every parameter, or over two as a map, in FILE (SVG or PNG)");
  command->add_option(
      "--picture-of", options.picture_of,
      "what they show: a column of the table, such as force, test_stiffness or relative_l2; "
      "default: what [test] comes to, else the first measure, else the force, else the error");
  add_json(command, options.json, nullptr);
  add_fem_solver(command, options.fem_solver);
  command
      ->add_option("--threads", options.threads,
                   "threads of every method; default: the processors shared among the jobs")
      ->check(CLI::Range(1, 1024));
}

void add_play(CLI::App* command, PlayOptions& options) {
  add_scene(command, options.scene, "scene file (TOML): a world of objects, or one body")->required();
  command
      ->add_option("TRAJECTORY", options.trajectory,
                   "recorded input (TOML, or CSV); or a hand that feels the scene (CSV: time,x,y,z)")
      ->required();
  add_file(command, "--picture", options.picture,
           "PNG of four moments side by side; of a hand force and latency over time, PNG or SVG");
  add_json(command, options.json, nullptr);
  command
      ->add_option("--threads", options.threads,
                   "threads; default: as many as there are processors, of a hand one")
      ->check(CLI::Range(1, 1024));
  const std::size_t n_shared = command->get_options().size();
  add_file(command, "--out", options.out,
           "folder for files that ParaView opens, a picture a frame, and a film where there is ffmpeg");
  add_unit(command, options.unit, "with --out: lengths in files for ParaView, mm or m");
  command->add_flag("!--no-pictures", options.pictures, "with --out: neither pictures nor a film");
  command
      ->add_option("--render", options.render,
                   "how the pictures of frames are made: surfaces, or volume, by the looks of the scene")
      ->check(CLI::IsMember({"surfaces", "volume"}))
      ->capture_default_str();
  const std::size_t n_before = command->get_options().size();
  add_camera(command, options.camera);
  add_stereo(command, options.stereo);
  const std::vector<CLI::Option*> all = command->get_options();
  for (std::size_t o = n_before; o < all.size(); ++o)
    all[o]->needs(command->get_option("--render"));
  const std::vector<CLI::Option*> of_frames(all.begin() + static_cast<std::ptrdiff_t>(n_shared), all.end());
  command->parse_complete_callback(
      [&options, command, of_frames, of_hand = add_feeling(command, options.feel)] {
        settle_json(command, options.json, nullptr);
        const bool is_hand = is_recorded_hand(options.trajectory);
        for (const CLI::Option* option : is_hand ? of_frames : of_hand)
          if (option->count() > 0)
            throw CLI::ValidationError(
                option->get_name(),
                is_hand ? "expected a trajectory of frames, found a recorded hand"
                        : "expected a recorded hand (CSV: time,x,y,z), found a trajectory of frames");
        if (options.threads == 0)
          options.threads = is_hand ? 1 : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
      });
}

void add_live(CLI::App* command, LiveOptions& options) {
  add_scene(command, options.scene,
            "scene file (TOML): a world of objects, or one body; default: a menu of prototypes");
  command->add_option("--record", options.record,
                      "trajectory of what the hand does (CSV), always up to now: maille play replays it");
  command->add_option("--script", options.script, "events in place of a hand (CSV), see docs/live.md");
  command->add_option("--device", options.device, "mouse, spacenav, gamepad or udp:PORT")
      ->capture_default_str();
  command
      ->add_option("--method", options.method,
                   "limits, relaxed or coupled; default: the world's, of one "
                   "body limits")
      ->check(CLI::IsMember({"limits", "relaxed", "coupled"}));
  command->add_option("--frame-budget", options.budget,
                      "that a frame of the physics may take, such as 16ms; default: 22ms where bodies have "
                      "forces, else until it has settled");
  command->add_option("--stereo", options.stereo, "none, side-by-side or anaglyph")
      ->check(CLI::IsMember({"none", "side-by-side", "anaglyph"}))
      ->capture_default_str();
  command->add_option("--size", options.size, "of the window, in pixels")->capture_default_str();
  command->add_option("--text", options.text, "size of letters, 1: 16 pixels; default: of the screen")
      ->check(CLI::Range(0.5, 4.0));
  command->add_option("--shots", options.shots, "folder of screenshots and films")->capture_default_str();
  command->add_flag("--full-screen", options.full_screen, "begin with it");
  command->add_flag("--headless", options.headless,
                    "no window: plays the script, each event once all before it has been done");
  add_json(command, options.json, nullptr);
  add_threads(command, options.threads);
}

void add_render(CLI::App* command, RenderOptions& options) {
  add_scene(command, options.scene);
  add_file(command, "--out", options.out, "PNG")->required();
  command->add_option("--answer", options.answer,
                      "folder of `maille run --out`: the body as an answer left it");
  command->add_option("--method", options.method, "whose answer; default: the first that is there");
  add_field(command, "--field", options.field, "what colours show in place of the look's own",
            {"labels", "fibres"});
  add_camera(command, options.camera);
  add_stereo(command, options.stereo);
  command->add_option("--ring", options.ring, "views around, into OUT_000.png, ...")
      ->check(CLI::Range(1, 3600));
  add_json(command, options.json, &options.scene);
  add_threads(command, options.threads);
}

} // namespace maille::studies
