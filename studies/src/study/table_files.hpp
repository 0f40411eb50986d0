#pragma once
/// Contents of a study row, also before its results exist, and the two files of a running study: rows are
/// appended whole and synchronised to disk; one process at a time.

#include "results/result_table.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"

namespace maille::studies {

template<>
struct Choices<Timing> {
  static constexpr std::array all{Timing::alone, Timing::busy, Timing::side_by_side};
};

const ResultTable<StudyRow>& columns_of_study();

/// Sets the study and case of a row.
void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one);
/// A row with all data known before the case runs.
StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options);

/// Appends to `stem.jsonl` and `stem.csv`; deletes files that are still empty at the end.
class TableAppender {
public:
  /// Continues existing files.
  explicit TableAppender(const std::filesystem::path& stem);
  ~TableAppender();
  TableAppender(const TableAppender&) = delete;
  TableAppender& operator=(const TableAppender&) = delete;
  /// Appends the rows of one case; they are on disk on return. @throws std::system_error
  void append(const std::vector<StudyRow>& rows);

private:
  std::filesystem::path stem_;
  int lines_ = -1, csv_ = -1;
  bool has_header_ = false;
};

} // namespace maille::studies
