#pragma once
/// Rows of a study, and its two files: JSON lines, which can be read back, and CSV for other programs.

#include "maille/scene/answer.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "study/plan/study.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace maille::studies {

/// Reliability of measured seconds.
enum class Timing {
  alone,        ///< one case at a time, with a free processor
  busy,         ///< other load: by load average, or processor time below wall time
  side_by_side, ///< other cases of the study ran at the same time
};
std::string_view to_string(Timing timing);

/// Value of a measure column in a row.
struct StudyMeasure {
  std::string name, unit;
  std::optional<double> value;
};

/// Row of one method on one case.
struct StudyRow {
  std::string study, scene;
  int number = 0;  ///< number of the case, from 1
  int n_cases = 0; ///< of the whole study
  std::vector<std::pair<std::string, std::variant<double, std::string>>> parameters; ///< column, value
  std::string method;
  Status status = Status::done; ///< failed also if the scene with these values is invalid
  std::string message;
  bool cut_is_allowed = false;     ///< LimitSettings::cut_is_allowed
  std::optional<ErrorNorms> error; ///< none for the reference itself and without displacement
  Seconds seconds;                 ///< medians over the repetitions
  double total_seconds = 0;        ///< median of the totals
  int repetitions = 1;
  Timing timing = Timing::alone;
  double processor_share = 0; ///< processor seconds over wall seconds while the case ran
  double load_average = 0;    ///< of one minute, at the start of the case
  std::int64_t bytes = 0, iterations = 0;
  std::optional<double> limit_violation; ///< see ComparisonRow
  std::optional<double> force;           ///< total force of the moves [N], in 2D per metre
  std::optional<double> strain_energy;   ///< [J], in 2D per metre
  std::optional<TestResult> test;        ///< for scenes with a [test]
  std::vector<StudyMeasure> measures;    ///< one per measure column, in every row of a table
  std::string reference;
  std::optional<ErrorNorms> reference_error; ///< see BestReference
  std::string algorithm;
  int dimension = 0; ///< 0 if the scene is invalid
  std::int64_t cells = 0, nodes = 0;
  int threads = 1;
  std::string maille; ///< version
  std::string hash;   ///< see CaseHashes
  std::string vtk;    ///< file, relative to the table's folder; empty: none
  /// Failed because of the machine (killed process, insufficient memory, unreadable or unwritable file). Only
  /// in JSON
  bool is_of_machine = false;
};

/// True if a repetition may end differently: the row failed because of the machine, or was refused for
/// insufficient memory. `--resume` runs such rows again.
bool may_end_otherwise(const StudyRow& row);

/// One line, without line break. Numbers are exact to the bit; an infinite one becomes null.
std::string json_line(const StudyRow& row);
nlohmann::ordered_json json(const StudyRow& row);

/// Names of the columns of every table; parameter columns stand between them.
std::vector<std::string> study_columns();

/// A table from a file. An incomplete last line (killed writer) is skipped.
struct StudyTable {
  std::vector<StudyRow> rows;
  bool is_torn = false; ///< an incomplete last line was skipped
};
/// Reads rows of JSON lines from text; `file` is the name in messages. @throws InputError for an invalid
/// line, except the last
StudyTable parse_study_table(std::string_view text, const std::filesystem::path& file);
/// The same from a file.
StudyTable read_study_table(const std::filesystem::path& file);

/// Sorts by case, then by the order of methods in the first case that has them.
void sort_rows(std::vector<StudyRow>& rows, const std::vector<std::string>& methods);

/// Writes `stem.jsonl` and `stem.csv`, and `stem.pvd` for rows with a file for ParaView: one time step per
/// case, one part per method. Each file is replaced atomically.
/// @return the files
std::vector<std::filesystem::path> write_study_table(const std::vector<StudyRow>& rows,
                                                     const std::filesystem::path& stem);

/// Merged tables (parts of `--shard`), one per study.
struct MergedTable {
  std::string study;
  std::vector<StudyRow> rows; ///< sorted
  int missing = 0;            ///< number of cases without a row
};
/// Merges tables; duplicate rows are taken once.
/// @param files  tables of JSON lines; paths of files for ParaView become relative to `folder`
/// @throws InputError, also if two rows of the same case and method have different scenes
std::vector<MergedTable> merge_study_tables(const std::vector<std::filesystem::path>& files,
                                            const std::filesystem::path& folder);

/// Numeric result columns, which a picture can show, in addition to measure columns.
std::vector<std::string> study_responses();

} // namespace maille::studies
