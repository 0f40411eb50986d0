#pragma once
/// Runs studies: cases in sequence or in parallel, into a table that survives a killed process.

#include "compare/methods.hpp"
#include "maille/scene/warp/warp.hpp"
#include "study/plan/study_table.hpp"

#include <functional>

namespace maille::studies {

struct StudyOptions {
  std::filesystem::path out; ///< existing folder
  bool resume = false;
  bool overwrite = false;    ///< deletes an existing table and its files once the new one is complete
  int jobs = 1;              ///< parallel cases, each in its own process
  int shard = 1, shards = 1; ///< this run's part: cases shard, shard + shards, ...
  fem_ref::LinearSolver solver = fem_ref::LinearSolver::automatic;
  LengthUnit unit = LengthUnit::metre; ///< length unit in files for viewers
  int threads = 1;                     ///< threads of every method
};

/// Progress callback, called after every case.
using StudyProgress = std::function<void(int done, int of, double seconds_left)>;

struct StudyOutcome {
  std::vector<StudyRow> rows; ///< rows of the table, sorted
  int n_cases = 0;            ///< of this run's part
  int n_reused = 0;           ///< number of rows reused by --resume
  int n_left_over = 0;        ///< existing rows of another study; kept in STEM_older.jsonl
  bool is_interrupted = false;
  double seconds = 0;
  std::vector<std::filesystem::path> files;
};

/// Runs one case by some of study.row_methods(); the reference runs in any case, once.
/// Errors of the scene and exceptions of methods become rows with a message. If a file cannot be written, the
/// row stays valid and its message reports it.
/// @param hashes  one per method of `methods`; may be empty
/// Writes files for ParaView to options.out if the study requests them for this case.
/// @param body  of `coupled`, cached between cases if seconds are not repeated; null: no cache
/// @return rows in the order of `methods`; empty after a stop request
std::vector<StudyRow> run_case(const StudyFile& study, const StudyCase& one,
                               const std::vector<std::string>& methods,
                               const std::vector<std::string>& hashes, const StudyOptions& options,
                               const Control& control = {}, deform::ElasticBody* body = nullptr);

/// Path of the table of a run's part, without ending: OUT/NAME or OUT/NAME_2_of_8.
std::filesystem::path table_stem(const StudyFile& study, const StudyOptions& options);

/// @brief Runs all cases of this part that are missing in the table and appends their rows at once,
/// synchronised to disk: a killed process loses only the running cases.
///
/// Cases run in forked processes, so a crashed case still gives a row; call this before any thread starts.
/// With several jobs, or other load on the machine, rows mark their seconds as unreliable.
///
/// @throws FolderTaken if a table exists without resume, or another process has locked it; InputError for an
///         invalid table
/// Repeatable  rows, except seconds, do not depend on the numbers of jobs and parts
StudyOutcome run_study(const StudyFile& study, const StudyOptions& options, const Control& control = {},
                       const StudyProgress& progress = {});

} // namespace maille::studies
