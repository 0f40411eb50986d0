#pragma once
/// The commands of `maille`, each as a struct of options and a function that returns an exit code.
///
/// Exit codes: 0 done, 1 the run failed, 2 wrong usage or an input error, 128 + N stopped by signal N.
/// cli/help.cpp lists the commands.
/// Commands that write results share ResultsFolder: one lock, one list, one rule for the files that may be
/// deleted.

#include "export/warp_files.hpp"
#include "export/whole_file.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/answer.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

using maille::UsageError;

/// Unit of the option --unit, mm or m.
inline LengthUnit length_unit(std::string_view text) {
  return text == "mm" ? LengthUnit::millimetre : LengthUnit::metre;
}

/// A folder with the results of one scene, replaced as a set.
///
/// `SCENE_KIND_results.json` lists the files in the folder; KIND is run, compare or play. New results replace
/// earlier ones of the same scene and version; earlier files without a successor are deleted once the new
/// ones are complete, so a killed process loses nothing. Results of two kinds can coexist while all input
/// files that both have read are equal. Only files written by Maille are deleted (is_name_of_result,
/// has_provenance, digest_of). One process at a time owns the folder.
class ResultsFolder {
public:
  /// Creates the folder. @throws UsageError if it cannot be written, another process owns it, or it contains
  /// results of another scene or version, unless may_overwrite(): then these are deleted too
  /// @param sure see FolderLock
  ResultsFolder(std::filesystem::path folder, std::string scene, const std::filesystem::path& scene_file,
                std::string kind, const std::vector<std::string>& sure);

  const std::filesystem::path& path() const { return folder_; }
  /// Path in the folder: `SCENE` followed by `ending`.
  std::filesystem::path file(const std::string& ending) const;
  /// Announces the output file `SCENE` followed by `ending`.
  void plan(const std::string& ending) { planned_.insert(scene_ + ending); }
  /// True if plan() announced this file.
  bool is_planned(const std::string& name) const { return planned_.contains(name); }
  /// Records a written file.
  void add(const std::filesystem::path& file);
  void add(const std::vector<std::filesystem::path>& files);
  /// Records that the command was interrupted: files not replaced stay, and the next command deletes them.
  void keep_earlier() { keeps_earlier_ = true; }
  /// Writes the list, including `results`, and deletes the replaced files. @return the file of the list
  std::filesystem::path finish(nlohmann::ordered_json results);

private:
  void look_at(const std::filesystem::path& list);
  bool has_other_inputs(const nlohmann::ordered_json& list) const;
  void refuse_older_than_inputs() const;
  void add_stale(const std::string& name, const std::string& scene, const std::string& digest = "");
  void add_stale_of(const nlohmann::ordered_json& list);
  bool is_stale(const std::filesystem::path& file) const;
  bool is_of_replaced_series(const std::string& name) const;

  std::filesystem::path folder_;
  std::string scene_, kind_, scene_file_, scene_text_;
  std::map<std::string, std::string> inputs_; ///< digests of the opened files, by name
  std::set<std::string> planned_;             ///< names that this command will write
  std::set<std::string> written_;             ///< names in the folder
  std::map<std::string, std::string> stale_;  ///< names, with digests of files without provenance
  FolderLock lock_;
  bool keeps_earlier_ = false;
};

/// Exit codes of the process.
enum ExitCode : int { exit_done = 0, exit_run_failed = 1, exit_faulty_input = 2 };

/// Options that commands share.
struct CommonOptions {
  std::filesystem::path scene;
  std::vector<std::string> methods;         ///< empty: the command's own choice
  std::optional<std::string> json;          ///< "-": on stdout
  std::optional<std::filesystem::path> out; ///< folder for files; nothing: none are written
  std::string fem_solver = "automatic";     ///< one of fem_ref::linear_solver_names
  int threads = 1;
};

/// Options of both commands that solve scenes.
struct AnswerOptions : CommonOptions {
  bool estimate = false;           ///< estimate errors, see add_estimates
  std::optional<std::string> unit; ///< length unit in files for viewers; nothing: default of the file type
};

struct CheckOptions : CommonOptions {
  std::filesystem::path trajectory;   ///< trajectory of a world; empty: only the scene
  bool why = false;                   ///< list active model features and their costs
  std::optional<std::string> picture; ///< picture of the question
};

struct CompareOptions : AnswerOptions {
  std::string reference;         ///< empty: default_reference
  double reference_seconds = 60; ///< for the reference "best"
  std::optional<std::string> csv;
  std::optional<std::string> picture;
  std::string picture_of = "displacement"; ///< quantity of its colours; also strain, stress, error
};

/// Images to warp with an answer.
struct WarpOptions {
  std::optional<std::filesystem::path> image, labels;
  std::vector<std::string> also; ///< formats in addition to .nii.gz
  float background = 0;
  std::vector<std::string> surfaces; ///< formats of surfaces
  std::string unit = "mm";           ///< length unit of surfaces
};

struct WarpCommandOptions : CommonOptions {
  WarpOptions warp;
};

struct RunOptions : AnswerOptions {
  int steps = 1;                      ///< 1: only the final state is written
  std::optional<std::string> picture; ///< plot of force over displacement
  std::optional<std::string> film;    ///< film of the body, step by step
  std::string field = "displacement"; ///< quantity of its colours; also strain, stress, error
  bool maps = false;                  ///< voxel maps of the last step, on the body's image
  bool is_warped = false;             ///< warp images by the last step
  std::optional<std::string> write;   ///< the question as input of CalculiX; "-": on stdout
  WarpOptions warp;
};

/// Camera of a rendered picture; the defaults show the whole scene.
struct CameraOptions {
  std::string direction = "-1,-1,-0.5"; ///< viewing direction
  std::string up = "0,0,1";
  std::optional<std::string> camera; ///< ParaView's: position, focal point, view up [m], view angle [deg]
  double zoom = 1;
  bool parallel = false;
  std::vector<std::string> clips;  ///< six numbers each: a point and a normal
  std::optional<std::string> crop; ///< six lengths: two corners, in the objects' frames
  int width = 640, height = 640;
  double samples = 2, depth_cue = 0;
  std::string light = "-0.4,0.6,1", background = "#ffffff";
};

/// Settings of a recorded hand in a scene.
struct FeelOptions {
  std::optional<std::string> tool; ///< nothing: a point
  std::string radius = "0 m", rule = "coupling";
  double rate = 1000, stiffness = 300, damping = 0, turn_stiffness = 0, device_damping = 0.5;
  double mass = 0, hand_stiffness = 0, hand_damping = 0, largest_force = 1000;
  bool no_clock = false;
  std::optional<std::string> csv;
};

struct PlayOptions {
  std::filesystem::path scene, trajectory;
  FeelOptions feel;                         ///< if the trajectory is a recorded hand
  std::optional<std::filesystem::path> out; ///< folder for files; nothing: none are written
  std::string unit = "m";                   ///< of lengths in these files
  std::optional<std::string> picture;       ///< picture of four moments, side by side
  bool pictures = true;                     ///< one per frame, and a film, in `out`
  std::string render = "surfaces";          ///< how pictures are made: surfaces or volume
  CameraOptions camera;                     ///< camera of volume pictures
  std::string stereo = "none";              ///< volume pictures: none, side_by_side, anaglyph
  std::optional<std::string> json;
  int threads = 0; ///< 0: number of processors; recorded hand: 1
};

struct RenderOptions {
  std::filesystem::path scene, out;
  std::optional<std::filesystem::path> answer; ///< folder of results; its first answer deforms the body
  std::string method;                          ///< method of the answer; empty: the first one
  CameraOptions camera;
  std::string field;           ///< displacement, strain, stress, error; empty: the look's colours
  std::string stereo = "none"; ///< none, side_by_side, anaglyph
  int ring = 0;                ///< > 0: number of views on a circle, numbered
  std::optional<std::string> json;
  int threads = 1;
};

/// Fits to finite elements, or, with `measured`, to measurements.
struct FitOptions {
  std::vector<std::filesystem::path> scenes, tests;
  std::vector<std::filesystem::path> measured; ///< empty, or one per scene
  std::vector<std::string> unknowns;           ///< dotted keys of the scenes
  std::optional<std::string> sigma;            ///< uncertainty of displacements, a length
  std::string method;                          ///< empty: limits, or coupled for measurements
  std::optional<double> holdout; ///< fraction of the scenes excluded from the fit; nothing: none
  std::string reference = "fem_q2";
  double reference_seconds = 60; ///< for the reference "best"
  int trials = 20000;
  std::optional<std::string> out, json;
  std::string fem_solver = "automatic";
  int threads = 1;
};

struct TradeOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out; ///< folder for files; nothing: none are written
  std::vector<std::string> methods;         ///< empty: all but the oracles
  std::vector<double> spacings;             ///< multiples of the scene's; empty: 8, 4, 2, 1, 1/2
  std::vector<double> tolerances;           ///< empty: 1e-1 to 1e-4
  std::string reference = "best";
  double reference_seconds = 60; ///< for the reference "best"
  double row_seconds = 60;
  int repetitions = 3;
  std::optional<std::string> json, csv;
  bool all = false; ///< print all rows, not only those on the fronts
  int threads = 1;
};

struct ChooseOptions {
  std::filesystem::path scene;
  std::string error, time;           ///< with units
  std::string of = "displacement";   ///< quantity of the error, see quantity_named
  std::optional<std::string> memory; ///< nothing: memory of the machine
  std::string level = "95%";
  std::vector<std::filesystem::path> tables; ///< empty: the built-in one
  std::optional<std::string> write;          ///< file for the scene on the chosen lattice
  std::optional<std::string> json;
  int threads = 1;
};

struct NewOptions {
  std::string kind;             ///< strip, calf, image or world
  std::filesystem::path labels; ///< label image, for kind image
  std::optional<std::string> out;
};

struct ReportOptions {
  std::filesystem::path folder;
  std::filesystem::path out; ///< empty: report.html in the folder
};

struct ManualOptions {
  std::filesystem::path out; ///< folder such as /usr/share
};

struct MaterialsOptions {
  std::string name; ///< name of a tissue, or `library` for all
  std::optional<std::string> json;
};

struct StudyCommandOptions {
  std::filesystem::path study;
  std::optional<std::filesystem::path> out; ///< nothing: out/NAME
  std::optional<std::string> json;
  std::optional<std::string> picture;
  std::string picture_of; ///< column of the table or of a measure; empty: default_response()
  std::string shard;      ///< `i/N`; empty: the whole study
  std::string unit = "m"; ///< of lengths in files for viewers
  std::string fem_solver = "automatic";
  bool resume = false;
  int jobs = 1;
  int threads = 0; ///< 0: number of processors per job
};

struct MergeOptions {
  std::vector<std::filesystem::path> places; ///< folders, or tables of JSON lines
  std::filesystem::path out;
  std::optional<std::filesystem::path> study; ///< study of the tables, for sensitivities
};

int compare_command(const CompareOptions& options);
int run_command(const RunOptions& options);
/// Checks any file: scenes, worlds, studies, trajectories with their worlds, materials.
int check_any_command(const CheckOptions& options);
int explain_command(const CheckOptions& options);

int materials_command(const MaterialsOptions& options);
int warp_command(const WarpCommandOptions& options);
/// @throws UsageError for unknown formats. The images are protected from being overwritten.
WarpRequest warp_request(const WarpOptions& options);
int play_command(const PlayOptions& options);
int feel_command(const PlayOptions& options);
/// True for a CSV file whose columns start with time,x,y,z: a recorded hand, not a trajectory of frames.
bool is_recorded_hand(const std::filesystem::path& file);
int render_command(const RenderOptions& options);
int new_command(const NewOptions& options);
/// Writes a sample calf, defined by closed formulas, to a folder.
void new_calf(const std::filesystem::path& folder);
int trade_command(const TradeOptions& options);
int choose_command(const ChooseOptions& options);
int study_command(const StudyCommandOptions& options);
int merge_command(const MergeOptions& options);
int fit_command(const FitOptions& options);
int report_command(const ReportOptions& options);
int manual_command(const ManualOptions& options);

/// Text of `explain` for a scene.
std::string explanation(const Scene& scene);
/// Stores the command line of the process, with `maille` as its program name.
void keep_command_line(int argc, char** argv);
/// Quotes a word for a shell, only if necessary.
std::string in_shell(const std::string& word);
/// The stored command line, quoted for a shell.
std::string command_line();

/// Data for the sections of `maille report` on a study and a trade, in addition to their tables: the command
/// line, the input file, its text, and the text of `explain`.
nlohmann::ordered_json asked_about(const std::filesystem::path& file, const std::string& explanation);

/// The file of one answer for ParaView, relative to the folder of the results.
struct AnswerFile {
  std::string method, file;
};
/// Writes the data for `maille report`, in addition to the files for ParaView: the results, the command line,
/// the scene file's text and its explanation. @return the file
std::filesystem::path finish(ResultsFolder& folder, const Scene& scene, const std::vector<AnswerFile>& files,
                             nlohmann::ordered_json results);
/// Prints to stderr why a picture could not be drawn, and deletes an outdated picture of that name.
/// @param why_not  nothing: it was drawn @param says_so  then, on stdout @return whether it was
bool tell_of_picture(const std::optional<std::string>& why_not, const std::filesystem::path& file,
                     bool says_so = false);
/// True if the run was stopped before any method had an answer: earlier results are kept. Prints this to
/// stderr.
bool is_cut_short(const Control& control, bool has_answers, bool has_files);

/// Prints file warnings that the command's own output does not include.
void say_file_warnings();
/// Replaces this process by the program `maille-NAME` (python/program.py.in), which reads the request from
/// standard input and ends with the exit code of the command. Call it last: it never returns.
int become_python_program(const std::string& name, const nlohmann::ordered_json& request);
/// Runs the same program as a child process and waits for it. @return its exit code
int run_python_program(const std::string& name, const nlohmann::ordered_json& request);

/// Control with threads, stop signals (see catch_stop_signals) and, on a terminal, a progress line on stderr.
Control terminal_control(int threads);
/// Clears the progress line.
void end_progress();

/// JSON as text for files and programs; invalid UTF-8, which file names may contain, is replaced.
std::string json_text(nlohmann::ordered_json json);
/// Text that is safe for a terminal: control characters from titles and names become `?`, except tabs and
/// line ends.
std::string for_terminal(std::string text);
/// Writes to the file, or to stdout if none is named; adds a missing newline on stdout.
void deliver(const std::string& text, const std::optional<std::string>& file);
/// Creates the folder, checks before any work that files can be written there, and deletes unfinished files
/// of killed processes.
/// @throws UsageError
void prepare_folder(const std::filesystem::path& folder);
/// True with --overwrite: the command may replace results of other scenes and foreign files.
bool& may_overwrite();
/// Checks before any work that `file` (nothing and "-": stdout) can be written, and is neither an input nor a
/// file of `results` nor, unless may_overwrite(), a file not written by Maille. Later attempts to read it are
/// refused (reserve_output). A scene file is replaced only if `ending` is ".toml".
/// @param head of the table, for CSV: see is_own_result() @throws UsageError
void prepare_file(const std::string& option, const std::optional<std::string>& file,
                  const std::optional<ResultsFolder>& results = {}, std::string_view ending = "",
                  std::string_view head = "");
/// Refuses an output file with the name of a result in `folder`. @throws UsageError
void refuse_name_of_result(const std::string& option, const std::optional<std::string>& file,
                           const std::filesystem::path& folder,
                           const std::function<bool(const std::string&)>& is_result);
/// Default methods of the commands.
inline constexpr const char* default_run_method = "coupled";
std::vector<std::string> default_compare_methods();
/// Checks every method's name. @throws UsageError
/// @return the methods in their order, without duplicates
std::vector<std::string> check_methods(const std::vector<std::string>& methods,
                                       const std::string& option = "--methods");
/// @throws UsageError
fem_ref::LinearSolver check_fem_solver(const std::string& name);
/// JSON for the field data of a file: version, scene, method, status, seconds.
std::string provenance(const Scene& scene, const Answer& answer, int threads);

/// Handles SIGINT (Ctrl-C), SIGTERM (`timeout`, `scancel`, systemd) and SIGHUP (closed terminals). Until
/// hear_stop_signals() such a signal ends the process at once, after deleting unfinished files. A SIGHUP
/// ignored by the caller (nohup) stays ignored. Call it first.
void catch_stop_signals();
/// From now on, the first stop signal is only recorded; a second one, more than 0.2 s later, ends the
/// process.
void hear_stop_signals();
/// The recorded stop signal; 0: none.
int stop_signal();
/// Flushes the C library's buffers. If an abandoned thread still uses a library, ends the process without the
/// clean-up of libraries. @return without such a thread: `exit_code`, or 128 + the signal that stopped the
/// command
int leave(int exit_code);

} // namespace maille::studies
