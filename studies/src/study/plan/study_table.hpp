#pragma once
/// The rows of a study, and the two files that hold them: JSON lines, which are read again,
/// and CSV for everyone else.

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

/// Whether seconds may be believed.
enum class Timing {
  alone,        ///< one case at a time on a machine that had a processor for it
  busy,         ///< others wanted the processors: load average, or processor time short of wall time
  side_by_side, ///< other cases of the study ran beside it
};
std::string_view to_string(Timing timing);

/// What a row has in a column of a measure.
struct StudyMeasure {
  std::string name, unit;
  std::optional<double> value;
};

/// One method on one case.
struct StudyRow {
  std::string study, scene;
  int number = 0;                                                                    ///< of the case, from 1
  int n_cases = 0;                                                                   ///< of the whole study
  std::vector<std::pair<std::string, std::variant<double, std::string>>> parameters; ///< column, value
  std::string method;
  Status status = Status::done; ///< failed too where the scene with these values is faulty
  std::string message;
  bool cut_is_allowed = false;     ///< LimitSettings::cut_is_allowed
  std::optional<ErrorNorms> error; ///< none of the reference itself and without displacement
  Seconds seconds;                 ///< each the median over the repetitions
  double total_seconds = 0;        ///< median of the totals
  int repetitions = 1;
  Timing timing = Timing::alone;
  double processor_share = 0; ///< processor seconds over wall seconds while the case ran
  double load_average = 0;    ///< of one minute, as the case began
  std::int64_t bytes = 0, iterations = 0;
  std::optional<double> limit_violation; ///< see ComparisonRow
  std::optional<double> force;           ///< that the moves take, all together [N], in 2D per metre
  std::optional<double> strain_energy;   ///< [J], in 2D per metre
  std::optional<TestResult> test;        ///< of a scene with a [test]
  std::vector<StudyMeasure> measures;    ///< a column each, in every row of a table
  std::string reference;
  std::optional<ErrorNorms> reference_error; ///< see BestReference
  std::string algorithm;
  int dimension = 0; ///< 0 where the scene is faulty
  std::int64_t cells = 0, nodes = 0;
  int threads = 1;
  std::string maille; ///< version
  std::string hash;   ///< see CaseHashes
  std::string vtk;    ///< file, relative to the table's folder; empty: none
  /// Failed through the machine (a process that was killed, no memory, a file that could not be read or
  /// written). JSON alone holds it
  bool is_of_machine = false;
};

/// Whether the same case may end otherwise on another day: the row failed through the machine, or was refused
/// for want of memory. `--resume` does not take such a row as known.
bool may_end_otherwise(const StudyRow& row);

/// One line, without line break. Numbers read back to the bit; an infinite one is null.
std::string json_line(const StudyRow& row);
nlohmann::ordered_json json(const StudyRow& row);

/// Names of the columns that every table has; those of parameters stand between them.
std::vector<std::string> study_columns();
/// The header line of CSV, with the columns of the parameters of `row`.
std::string csv_header(const StudyRow& row);
std::string csv_line(const StudyRow& row);

/// A table that was read. Its writer may have been killed in a line: an incomplete last line is left out.
struct StudyTable {
  std::vector<StudyRow> rows;
  bool is_torn = false; ///< such a line was left out
};
/// Rows of JSON lines from text; `file` names it in faults. @throws InputError for a line, not the last, that
/// is no row
StudyTable parse_study_table(std::string_view text, const std::filesystem::path& file);
/// The same from a file.
StudyTable read_study_table(const std::filesystem::path& file);

/// By case, then in the order that methods have in the rows of the first case that has them.
void sort_rows(std::vector<StudyRow>& rows, const std::vector<std::string>& methods);

/// Both files whole, `stem.jsonl` and `stem.csv`, and `stem.pvd` over the rows that have a file for ParaView:
/// a time step a case, a part a method. Each is replaced at once.
/// @return the files
std::vector<std::filesystem::path> write_study_table(const std::vector<StudyRow>& rows,
                                                     const std::filesystem::path& stem);

/// What several tables come to together: one a study, the parts of `--shard`.
struct MergedTable {
  std::string study;
  std::vector<StudyRow> rows; ///< sorted
  int missing = 0;            ///< cases of the study that no row is of
};
/// Rows that stand in several tables are taken once.
/// @param files  tables of JSON lines; files for ParaView are named relative to `folder` afterwards
/// @throws InputError, also where two rows of one case and method are of different scenes
std::vector<MergedTable> merge_study_tables(const std::vector<std::filesystem::path>& files,
                                            const std::filesystem::path& folder);

/// The columns of numbers that say how cases came out: what a picture can be of, beside the columns of
/// measures.
std::vector<std::string> study_responses();

} // namespace maille::studies
