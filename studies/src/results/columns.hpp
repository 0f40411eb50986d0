#pragma once
/// The columns of a table of results, and what follows from them: text, JSON, CSV, and the way back.

#include "results/value.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// What a figure is called and means.
struct FigureName {
  std::string csv;  ///< its column in CSV; empty: that has none
  std::string json; ///< its key in JSON, or group.key, or in groups of groups; empty: that has none
  std::string unit, meaning;
};

/// How the table for people has it.
struct Shown {
  std::string heading;
  int width = 0;                          ///< below 0: to the left; 0: that of the widest cell
  std::string (*words)(double) = nullptr; ///< of its number; nothing: as it is
  bool is_left_out = false;               ///< where no row has it
};

class Columns;

/// One figure of a table.
struct Column : FigureName {
  Shown shown{};           ///< without a heading it is not
  int digits = 0;          ///< of numbers in CSV; 0: as many as read back to the bit
  bool is_omitted = false; ///< from JSON if it has no value, instead of null
  /// It stands for as many columns of CSV as its object has keys.
  bool is_open = false;
  const Columns* within = nullptr; ///< where its value is rows of another table, or one row: that one
  bool is_list = false;            ///< rows

  /// How it is read back; see read_value and expected_of.
  bool is_read = false, is_real = false, is_optional = false;
  std::string expected{};
};

/// How numbers stand in CSV.
struct CsvNumbers {
  int digits = 0, digits_of_seconds = 0; ///< 0: as many as read back to the bit
  bool are_only_finite = false;          ///< the cell of another one is empty
};

using Values = std::vector<Value>; ///< of one row, a value a column

class Columns {
public:
  explicit Columns(CsvNumbers numbers = {}) : numbers_(numbers) {}

  const std::vector<Column>& list() const { return list_; }
  /// Names in CSV, but for the open column's.
  std::vector<std::string> csv_names() const;

  nlohmann::ordered_json json_of(const Values& values) const;
  /// With the columns that the open one of `values` stands for.
  std::string csv_header_of(const Values& values) const;
  std::string csv_line_of(const Values& values) const;
  /// The headings, and a line a row.
  std::string text_of(const std::vector<Values>& rows) const;

  /// What an object of JSON says; discarded where it has no such key and need not have it.
  Values values_of(const nlohmann::ordered_json& row) const;

protected:
  /// Keys of a group, such as error.rms, are omitted without a value.
  void append(FigureName name, Shown shown);
  Column& last() { return list_.back(); }
  /// Moves the last column behind the one of that key in JSON, or of that heading in the text.
  void move_in_json(const std::string& behind);
  void move_in_text(const std::string& behind);

private:
  std::vector<std::size_t> places_shown(const std::vector<Values>& rows) const;
  std::string in_words(std::size_t column, const Values& values, std::string_view absent) const;
  /// Below 0 where the cells are texts.
  int width_of(std::size_t column, const std::vector<Values>& rows) const;
  std::string csv_cell(const Value& value, int digits) const;

  CsvNumbers numbers_;
  std::vector<Column> list_;
  std::vector<std::size_t> json_order_, text_order_;
};

/// Faults of one file that are collected at most: of a file that is something else, every line has some.
inline constexpr std::size_t most_faults = 100;

/// `"TEXT"`, a number, or `nothing`.
std::string found_in_words(const Value& value);

} // namespace maille::studies
