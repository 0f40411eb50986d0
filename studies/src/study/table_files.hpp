#pragma once
/// The two files of a running study: rows are appended whole and synchronised; one process at a time.

#include "maille/studies/study_table.hpp"

namespace maille::studies {

/// Holds a lock beside the table for as long as it lives; the system drops it when the process dies.
class TableLock {
public:
  /// @throws TableTaken where another process holds it
  explicit TableLock(const std::filesystem::path& stem);
  ~TableLock();
  TableLock(const TableLock&) = delete;
  TableLock& operator=(const TableLock&) = delete;

private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// Appends to `stem.jsonl` and `stem.csv`.
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
  int lines_ = -1, csv_ = -1;
  bool has_header_ = false;
};

} // namespace maille::studies
