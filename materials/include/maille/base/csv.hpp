#pragma once
/// Records of CSV (RFC 4180): the tokeniser of all readers and the writer of texts.

#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Places where `#` begins a comment to the end of the line; never between quotes.
enum class CsvComments {
  none,
  lines,    ///< as the first character of a line that is not blank
  anywhere, ///< in every line of numbers
};

/// Iterates over the records of a text. Quoted cells may contain commas, line ends and doubled quotes;
/// carriage returns elsewhere and the byte order mark of spreadsheets are skipped.
class CsvRecords {
public:
  /// @param text outlives this
  explicit CsvRecords(std::string_view text, CsvComments comments = CsvComments::none);

  /// Reads the next record. @return false at the end
  bool next();
  /// Cells of the current record, without quotes; a blank or comment line has one empty cell.
  const std::vector<std::string>& cells() const { return cells_; }
  /// First line of the current record, from 1.
  int line() const { return line_; }
  /// True if the text ends inside quotes.
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

/// A text as a cell; quoted if necessary, with a leading apostrophe if a spreadsheet would read a formula.
std::string csv_text(const std::string& text);
/// Inverse of csv_text, for a cell from CsvRecords.
std::string without_guard(std::string cell);

} // namespace maille
