#pragma once
/// Records of CSV (RFC 4180): the one tokeniser of every reader, and the one writer of texts.

#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Where `#` begins a comment that goes on to the end of its line; never between quotes.
enum class CsvComments {
  none,
  lines,    ///< as the first character of a line that is not blank
  anywhere, ///< in every line of numbers
};

/// Walks through the records of a text. Cells between quotes may hold commas, ends of lines and doubled
/// quotes; carriage returns elsewhere are left out, and so is the byte order mark of spreadsheets.
class CsvRecords {
public:
  /// @param text outlives this
  explicit CsvRecords(std::string_view text, CsvComments comments = CsvComments::none);

  /// Reads the next record. @return false at the end
  bool next();
  /// Cells of the present record, without quotes; a blank or comment line has one empty cell.
  const std::vector<std::string>& cells() const { return cells_; }
  /// In which that record begins, from 1.
  int line() const { return line_; }
  /// True where the text ends between quotes.
  bool is_open() const { return is_open_; }

private:
  bool begins_comment() const;
  void take(char c);

  std::string_view text_;
  CsvComments comments_;
  std::size_t at_ = 0;
  int line_ = 0, next_line_ = 1;
  bool is_open_ = false;
  std::vector<std::string> cells_;
};

/// A cell that holds a text; quoted where it must be, and behind an apostrophe where a spreadsheet would take
/// it for a formula.
std::string csv_text(const std::string& text);
/// A text that csv_text has written, from the cell that CsvRecords reads.
std::string without_guard(std::string cell);

} // namespace maille
