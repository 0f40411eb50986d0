#pragma once
/// What a row of a study holds, also before there are figures, and the two files of a running study: rows are
/// appended whole and synchronised; one process at a time.

#include "results/result_table.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"

namespace maille::studies {

template<>
struct Choices<Timing> {
  static constexpr std::array all{Timing::alone, Timing::busy, Timing::side_by_side};
};

const ResultTable<StudyRow>& columns_of_study();

/// Says which case of which study a row is of.
void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one);
/// A row with everything that is known before the case runs.
StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options);

/// Appends to `stem.jsonl` and `stem.csv`; at its end a file that is still empty goes.
class TableAppender {
public:
  /// Files that are there are gone on with.
  explicit TableAppender(const std::filesystem::path& stem);
  ~TableAppender();
  TableAppender(const TableAppender&) = delete;
  TableAppender& operator=(const TableAppender&) = delete;
  /// The rows of one case; they are on the disk when it returns. @throws std::system_error
  void append(const std::vector<StudyRow>& rows);

private:
  std::filesystem::path stem_;
  int lines_ = -1, csv_ = -1;
  bool has_header_ = false;
};

} // namespace maille::studies
