#pragma once
/// The commands of `maille`, each as a struct of options and a function that returns an exit code.
///
/// Exit codes: 0 done, 1 the run failed, 2 wrong usage or a faulty input, 128 + N stopped by signal N.
/// cli/help.cpp lists the commands.
/// ResultsFolder is what the commands that write results share: one lock, one list, one rule for what may
/// go.

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

/// What --unit says, mm or m.
inline LengthUnit length_unit(std::string_view text) {
  return text == "mm" ? LengthUnit::millimetre : LengthUnit::metre;
}

/// A folder with the results of one scene, replaced as a set.
///
/// What is in a folder is listed by `SCENE_KIND_results.json`, KIND being run, compare or play. Results of
/// the same scene, by the same version, take the place of earlier ones; the earlier files that have no
/// follower go once the new ones stand, so that nothing is lost when the process is killed. Results of two
/// kinds stay side by side as long as every file that both have opened is the same. Only files that Maille
/// wrote go (is_name_of_result, has_provenance, digest_of); one process at a time has the folder.
class ResultsFolder {
public:
  /// Makes the folder. @throws UsageError where it cannot be written, another process has it, or it holds
  /// results of another scene or version, unless may_overwrite(): then they go, too
  /// @param sure see FolderLock
  ResultsFolder(std::filesystem::path folder, std::string scene, const std::filesystem::path& scene_file,
                std::string kind, const std::vector<std::string>& sure);

  const std::filesystem::path& path() const { return folder_; }
  /// A path in the folder: `SCENE` and this.
  std::filesystem::path file(const std::string& ending) const;
  /// Says that the command will write `SCENE` and this.
  void plan(const std::string& ending) { planned_.insert(scene_ + ending); }
  /// True if plan() named it.
  bool is_planned(const std::string& name) const { return planned_.contains(name); }
  /// Says that a file has been written.
  void add(const std::filesystem::path& file);
  void add(const std::vector<std::filesystem::path>& files);
  /// Says that the command came to no end: what it has not replaced stays, and the next one takes it away.
  void keep_earlier() { keeps_earlier_ = true; }
  /// Writes the list, with `results` in it, and takes away what the new results replace. @return the list's
  /// file
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
  std::map<std::string, std::string> inputs_; ///< digests of what was opened, by name
  std::set<std::string> planned_;             ///< names that this command will write
  std::set<std::string> written_;             ///< names in the folder
  std::map<std::string, std::string> stale_;  ///< names, and digests of what cannot hold provenance
  FolderLock lock_;
  bool keeps_earlier_ = false;
};

/// What the process says to its caller.
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

/// What both commands that answer scenes can be asked for.
struct AnswerOptions : CommonOptions {
  bool estimate = false;           ///< of the errors, see add_estimates
  std::optional<std::string> unit; ///< of lengths in files for viewers; nothing: as each kind of file has it
};

struct CheckOptions : CommonOptions {
  std::filesystem::path trajectory;   ///< of a world; empty: the scene alone
  bool why = false;                   ///< what the scene switches on, and what it pays for that
  std::optional<std::string> picture; ///< of the question
};

struct CompareOptions : AnswerOptions {
  std::string reference;         ///< empty: default_reference
  double reference_seconds = 60; ///< for the reference "best"
  std::optional<std::string> csv;
  std::optional<std::string> picture;
  std::string picture_of = "displacement"; ///< or strain, stress: what its colours show
};

/// Which images go with an answer.
struct WarpOptions {
  std::optional<std::filesystem::path> image, labels;
  std::vector<std::string> also; ///< formats beside .nii.gz
  float background = 0;
  std::vector<std::string> surfaces; ///< formats of surfaces
  std::string unit = "mm";           ///< of those
};

struct WarpCommandOptions : CommonOptions {
  WarpOptions warp;
};

struct RunOptions : AnswerOptions {
  int steps = 1;                      ///< of 1 the end alone is written
  std::optional<std::string> picture; ///< of force over displacement
  std::optional<std::string> film;    ///< of the body, step by step
  bool maps = false;                  ///< of the last step, on the voxels of the body's image
  bool is_warped = false;             ///< images of the last step
  std::optional<std::string> write;   ///< the question as input of CalculiX; "-": on stdout
  WarpOptions warp;
};

/// Where a rendered picture is taken from; what is not given sees everything.
struct CameraOptions {
  std::string direction = "-1,-1,-0.5"; ///< in which the eye looks
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

/// How a recorded hand feels a scene.
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
  FeelOptions feel;                         ///< where the trajectory is a recorded hand
  std::optional<std::filesystem::path> out; ///< folder for files; nothing: none are written
  std::string unit = "m";                   ///< of lengths in these files
  std::optional<std::string> picture;       ///< of four moments side by side
  bool pictures = true;                     ///< one a frame, and a film of them, in `out`
  std::string render = "surfaces";          ///< how pictures are made: surfaces or volume
  CameraOptions camera;                     ///< of volumes
  std::string stereo = "none";              ///< of volumes: none, side_by_side, anaglyph
  std::optional<std::string> json;
  int threads = 0; ///< 0: as many as there are processors; of a recorded hand one
};

struct RenderOptions {
  std::filesystem::path scene, out;
  std::optional<std::filesystem::path> answer; ///< folder of results, whose first answer deforms the body
  std::string method;                          ///< of the answer; empty: the first that is there
  CameraOptions camera;
  std::string field;           ///< displacement, strain, stress, error; empty: the look's colours
  std::string stereo = "none"; ///< none, side_by_side, anaglyph
  int ring = 0;                ///< > 0: that many views around, numbered
  std::optional<std::string> json;
  int threads = 1;
};

/// Fits to finite elements, or with `measured` to what was measured on one scene.
struct FitOptions {
  std::vector<std::filesystem::path> scenes, tests;
  std::filesystem::path measured;
  std::vector<std::string> unknowns; ///< dotted keys of the scene
  std::optional<std::string> sigma;  ///< of displacements, a length
  std::string method;                ///< empty: limits; of what was measured coupled
  std::optional<double> holdout;     ///< part of the scenes that is kept from the fit; nothing: none
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
  std::vector<double> spacings;             ///< over the scene's; empty: 8, 4, 2, 1, 1/2
  std::vector<double> tolerances;           ///< empty: 1e-1 to 1e-4
  std::string reference = "best";
  double reference_seconds = 60; ///< for the reference "best"
  double row_seconds = 60;
  int repetitions = 3;
  std::optional<std::string> json, csv;
  bool all = false; ///< every row on the terminal, not only those of the fronts
  int threads = 1;
};

struct ChooseOptions {
  std::filesystem::path scene;
  std::string error, time;           ///< with units
  std::string of = "displacement";   ///< what the error is of, see quantity_named
  std::optional<std::string> memory; ///< nothing: what the machine has
  std::string level = "95%";
  std::vector<std::filesystem::path> tables; ///< empty: the built-in one
  std::optional<std::string> write;          ///< file for the scene on the lattice that is chosen
  std::optional<std::string> json;
  int threads = 1;
};

struct NewOptions {
  std::string kind;             ///< strip, calf, image or world
  std::filesystem::path labels; ///< of an image
  std::optional<std::string> out;
};

struct ReportOptions {
  std::filesystem::path folder;
  std::filesystem::path out; ///< empty: report.html in the folder
};

struct ManualOptions {
  std::filesystem::path out; ///< folder, as /usr/share
};

struct MaterialsOptions {
  std::string name; ///< of a tissue, or `library`: all
  std::optional<std::string> json;
};

struct StudyCommandOptions {
  std::filesystem::path study;
  std::optional<std::filesystem::path> out; ///< nothing: out/NAME
  std::optional<std::string> json;
  std::optional<std::string> picture;
  std::string picture_of; ///< a column of the table, or of a measure; empty: default_response()
  std::string shard;      ///< `i/N`; empty: the whole study
  std::string unit = "m"; ///< of lengths in files for viewers
  std::string fem_solver = "automatic";
  bool resume = false;
  int jobs = 1;
  int threads = 0; ///< 0: as many as the processors are for each job
};

struct MergeOptions {
  std::vector<std::filesystem::path> places; ///< folders, or tables of JSON lines
  std::filesystem::path out;
  std::optional<std::filesystem::path> study; ///< of whose tables sensitivities are found
};

int compare_command(const CompareOptions& options);
int run_command(const RunOptions& options);
/// Of whatever file there is: scenes, worlds, studies, trajectories with their worlds, materials.
int check_any_command(const CheckOptions& options);
int explain_command(const CheckOptions& options);

int materials_command(const MaterialsOptions& options);
int warp_command(const WarpCommandOptions& options);
/// @throws UsageError for formats that are none. The images are kept from being written over.
WarpRequest warp_request(const WarpOptions& options);
int play_command(const PlayOptions& options);
int feel_command(const PlayOptions& options);
/// True for a CSV file whose columns begin with time,x,y,z, in place of a trajectory of frames.
bool is_recorded_hand(const std::filesystem::path& file);
int render_command(const RenderOptions& options);
int new_command(const NewOptions& options);
/// A calf of closed formulas, in a folder.
void new_calf(const std::filesystem::path& folder);
int trade_command(const TradeOptions& options);
int choose_command(const ChooseOptions& options);
int study_command(const StudyCommandOptions& options);
int merge_command(const MergeOptions& options);
int fit_command(const FitOptions& options);
int report_command(const ReportOptions& options);
int manual_command(const ManualOptions& options);

/// What `explain` says about a scene, for people.
std::string explanation(const Scene& scene);
/// Keeps the words that the process was called with; its own name stands as `maille`.
void keep_command_line(int argc, char** argv);
/// As one word of a shell's command line, in quotes only where it needs them.
std::string in_shell(const std::string& word);
/// Them, as a shell would take them.
std::string command_line();

/// What the sections of `maille report` on a study and a trade need beside their tables: the command line,
/// the file that was asked about, its text, and what `explain` says.
nlohmann::ordered_json asked_about(const std::filesystem::path& file, const std::string& explanation);

/// The file of one answer for ParaView, relative to the folder of the results.
struct AnswerFile {
  std::string method, file;
};
/// Writes what `maille report` needs beside the files for ParaView: the results, the command line, the scene
/// file's text and its explanation. @return the file
std::filesystem::path finish(ResultsFolder& folder, const Scene& scene, const std::vector<AnswerFile>& files,
                             nlohmann::ordered_json results);
/// Says on stderr why a picture could not be drawn; an older one in its place goes: it shows something else.
/// @param why_not  nothing: it was drawn @param says_so  then, on stdout @return whether it was
bool tell_of_picture(const std::optional<std::string>& why_not, const std::filesystem::path& file,
                     bool says_so = false);
/// True where Ctrl-C came before any method had an answer: earlier results are worth more. Says on stderr
/// that they stay.
bool is_cut_short(const Control& control, bool has_answers, bool has_files);

/// Prints warnings of files that the command's own output does not have.
void say_file_warnings();
/// Replaces this process by the program `maille-NAME` (python/program.py.in), which has the request on its
/// standard input and ends with the command's exit code. Call it last: it never returns a value.
int become_python_program(const std::string& name, const nlohmann::ordered_json& request);
/// Runs the same as a process of its own, to its end. @return its exit code
int run_python_program(const std::string& name, const nlohmann::ordered_json& request);

/// Threads, signals that ask to stop (see catch_stop_signals) and a progress line on stderr where that is a
/// terminal.
Control terminal_control(int threads);
/// Clears the progress line.
void end_progress();

/// As files and programs get it; what is no UTF-8, as names of files may be, is replaced.
std::string json_text(nlohmann::ordered_json json);
/// What titles and names in files hold must not steer a terminal: control characters become `?`, but for tabs
/// and ends of lines.
std::string for_terminal(std::string text);
/// Prints to stdout, or to the file where one is named; a text that stands on stdout ends with a newline.
void deliver(const std::string& text, const std::optional<std::string>& file);
/// Makes the folder, finds out that files can be written there, before any work is done, and takes away what
/// processes that were killed left unfinished.
/// @throws UsageError
void prepare_folder(const std::filesystem::path& folder);
/// Whether --overwrite was given: the command may replace results of other scenes and foreign files.
bool& may_overwrite();
/// Checks, before any work is done, that `file` (nothing and "-": stdout) can be written, and is not an
/// input, nor a file of `results`, nor, unless may_overwrite(), a file that Maille did not write; a later
/// attempt to read it is refused (reserve_output). A scene file is replaced only if `ending` is ".toml".
/// @throws UsageError
void prepare_file(const std::string& option, const std::optional<std::string>& file,
                  const std::optional<ResultsFolder>& results = {}, std::string_view ending = "");
/// Refuses a file of an option under the name of a result in `folder`. @throws UsageError
void refuse_name_of_result(const std::string& option, const std::optional<std::string>& file,
                           const std::filesystem::path& folder,
                           const std::function<bool(const std::string&)>& is_result);
/// What commands ask where nothing is said.
inline constexpr const char* default_run_method = "coupled";
std::vector<std::string> default_compare_methods();
/// Checks every method's name. @throws UsageError
/// @return the methods, each once, in their order
std::vector<std::string> check_methods(const std::vector<std::string>& methods,
                                       const std::string& option = "--methods");
/// @throws UsageError
fem_ref::LinearSolver check_fem_solver(const std::string& name);
/// JSON for the field data of a file: version, scene, method, status, seconds.
std::string provenance(const Scene& scene, const Answer& answer, int threads);

/// Ctrl-C (SIGINT), `timeout`, `scancel` and systemd (SIGTERM), closed terminals (SIGHUP): all three ask the
/// process to end. Until hear_stop_signals() such a signal ends the process at once; files that are only half
/// written are removed. A SIGHUP that the caller had ignored (nohup) stays ignored. To be called first thing.
void catch_stop_signals();
/// From now on the first of them is only noted; a second one, more than 0.2 s later, ends the process.
void hear_stop_signals();
/// The one that has been noted; 0: none.
int stop_signal();
/// Flushes the C library's buffers and ends the process, without the clean-up of libraries if an abandoned
/// thread still uses one of them. @return without such a thread `exit_code`, or 128 + the signal that
/// stopped what ran
int leave(int exit_code);

} // namespace maille::studies
