#pragma once
/// Columns of a result table, and formats derived from them: text, JSON, CSV, and reading.

#include "results/value.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Names, unit and meaning of a column.
struct FigureName {
  std::string csv;  ///< column in CSV; empty: not in CSV
  std::string json; ///< key in JSON, or group.key (nested); empty: not in JSON
  std::string unit, meaning;
};

/// Format in the text table.
struct Shown {
  std::string heading;
  int width = 0;                          ///< below 0: left-aligned; 0: width of the widest cell
  std::string (*words)(double) = nullptr; ///< formats its number; null: no formatting
  bool is_left_out = false;               ///< omit the column if no row has a value
};

class Columns;

/// One column of a table.
struct Column : FigureName {
  Shown shown{};           ///< without a heading: not in the text table
  int digits = 0;          ///< digits of numbers in CSV; 0: exact to the bit
  bool is_omitted = false; ///< omit it from JSON without a value, instead of null
  /// In CSV it becomes one column per key of its object; reading collects all unknown columns in it.
  bool is_open = false;
  const Columns* within = nullptr; ///< table of its rows, if it has rows of another table
  bool is_list = false;            ///< its value is a list of rows

  /// Reading; see read_value and expected_of.
  bool is_read = false, is_real = false, is_optional = false;
  std::string expected{};
};

/// Number format in CSV.
struct CsvNumbers {
  int digits = 0, digits_of_seconds = 0; ///< 0: exact to the bit
  bool are_only_finite = false;          ///< non-finite numbers give empty cells
};

using Values = std::vector<Value>; ///< one value per column of a row

class Columns {
public:
  explicit Columns(CsvNumbers numbers = {}) : numbers_(numbers) {}

  const std::vector<Column>& list() const { return list_; }
  /// Names in CSV, except the open column.
  std::vector<std::string> csv_names() const;
  /// Beginning of every CSV header of the table, up to the open column.
  std::string csv_head() const;

  nlohmann::ordered_json json_of(const Values& values) const;
  /// CSV header, including columns from the open column of `values`.
  std::string csv_header_of(const Values& values) const;
  std::string csv_line_of(const Values& values) const;
  /// Headings, and one line per row.
  std::string text_of(const std::vector<Values>& rows) const;

  /// Values of a JSON object; a missing key that may be missing gives a discarded value.
  Values values_of(const nlohmann::ordered_json& row) const;

protected:
  /// Keys of a group, such as error.rms, are omitted without a value.
  void append(FigureName name, Shown shown);
  Column& last() { return list_.back(); }
  /// Moves the last column after the one with that JSON key, or with that heading in the text.
  void move_in_json(const std::string& behind);
  void move_in_text(const std::string& behind);

private:
  std::vector<std::size_t> places_shown(const std::vector<Values>& rows) const;
  std::string in_words(std::size_t column, const Values& values, std::string_view absent) const;
  /// Width of a column; below 0 for text.
  int width_of(std::size_t column, const std::vector<Values>& rows) const;
  std::string csv_cell(const Value& value, int digits) const;

  CsvNumbers numbers_;
  std::vector<Column> list_;
  std::vector<std::size_t> json_order_, text_order_;
};

/// Upper bound of collected errors per file: in a file of another kind, every line is wrong.
inline constexpr std::size_t most_faults = 100;

/// `"TEXT"`, a number, or `nothing`.
std::string found_in_words(const Value& value);

} // namespace maille::studies
