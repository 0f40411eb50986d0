#pragma once
/// Runs studies: case after case, or several side by side, into a table that survives being killed.

#include "compare/methods.hpp"
#include "maille/scene/warp/warp.hpp"
#include "study/plan/study_table.hpp"

#include <functional>

namespace maille::studies {

struct StudyOptions {
  std::filesystem::path out; ///< folder that exists
  bool resume = false;
  bool overwrite = false;    ///< a table that is there goes, with its files, once the new one is whole
  int jobs = 1;              ///< cases at a time, each in a process of its own
  int shard = 1, shards = 1; ///< this run's part: cases shard, shard + shards, ...
  fem_ref::LinearSolver solver = fem_ref::LinearSolver::automatic;
  LengthUnit unit = LengthUnit::metre; ///< of lengths in files for viewers
  int threads = 1;                     ///< of every method
};

/// What has been done so far, after every case.
using StudyProgress = std::function<void(int done, int of, double seconds_left)>;

struct StudyOutcome {
  std::vector<StudyRow> rows; ///< of the table, sorted
  int n_cases = 0;            ///< of this run's part
  int n_reused = 0;           ///< rows that --resume found
  int n_left_over = 0; ///< rows of the table found there that are not of this study; kept in STEM_older.jsonl
  bool is_interrupted = false;
  double seconds = 0;
  std::vector<std::filesystem::path> files;
};

/// The rows of one case by some of study.row_methods(); the reference runs in any case, once.
/// Faults of the scene and whatever a method throws become rows that say so; a file that cannot be written is
/// told in the message of its row, which stands.
/// @param hashes  one a method of `methods`; may be empty
/// Writes files for ParaView into options.out where the study wants them of this case.
/// @param body  of `coupled`, kept from case to case where seconds are not repeated; null: none is
/// @return in the order of `methods`; nothing where control asked to stop
std::vector<StudyRow> run_case(const StudyFile& study, const StudyCase& one,
                               const std::vector<std::string>& methods,
                               const std::vector<std::string>& hashes, const StudyOptions& options,
                               const Control& control = {}, deform::ElasticBody* body = nullptr);

/// Where the table of a run's part stands, without ending: OUT/NAME or OUT/NAME_2_of_8.
std::filesystem::path table_stem(const StudyFile& study, const StudyOptions& options);

/// @brief Runs every case of this part that the table lacks and appends its rows at once, synchronised to the
/// disk, so that being killed loses the cases in flight and nothing else.
///
/// Cases run in processes forked from this one, so that a crashed case still gives a row; call it before any
/// thread starts. With several jobs, or other load on the machine, rows mark their seconds as unreliable.
///
/// @throws FolderTaken where a table stands there and resume is not asked for, or another process holds it;
///         InputError where the table is faulty
/// Repeatable  rows are the same at any number of jobs and parts, seconds apart
StudyOutcome run_study(const StudyFile& study, const StudyOptions& options, const Control& control = {},
                       const StudyProgress& progress = {});

} // namespace maille::studies
