#pragma once
/// Tables as CSV whose first row names the columns and their units: `x [mm]`, or `x` in SI units.
///
/// A reader declares its columns and walks through the rows; a cell is asked for by the name of its column.
/// Columns stand in any order. Every fault goes to a FaultList, with its line and column. Blank lines and
/// comments are passed over.

#include "maille/base/csv.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/materials/toml_reader.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

struct CsvColumn {
  std::string_view name;
  std::optional<Dimension> dimension; ///< nothing: texts and whole numbers, which have no unit
  bool is_needed = true;
};

class CsvTable {
public:
  /// Reads the first row. Faults: an unknown, repeated or missing column, a unit of another kind.
  /// @param text outlives this, as `faults` does @param carries_units `x [mm], y, z`: a unit counts for
  ///        columns of the same kind that are declared behind it, until another one is stated
  CsvTable(std::string_view text, CsvComments comments, std::vector<CsvColumn> columns, FaultList& faults,
           bool carries_units = false);

  bool has(std::string_view column) const { return at(column).place.has_value(); }
  /// Empty: SI. @pre it has numbers
  const std::string& unit(std::string_view column) const { return at(column).unit; }
  /// In which the first row stands.
  int line_of_header() const { return header_line_; }

  /// Goes to the next row that has as many cells as the first; others are faults.
  /// @return false at the end, and where the first row has faults: every other row would then be one
  bool next();
  int line() const { return records_.line(); }
  /// Empty where there is no such column, or nothing in it.
  std::string_view text(std::string_view column) const;
  /// In SI units; nothing where there is no such column, nothing and a fault where it holds no number.
  std::optional<double> number(std::string_view column);
  bool has_any(std::initializer_list<std::string_view> columns) const;
  /// A fault of the present row.
  void fault(std::string_view column, std::string expected, std::string found);

private:
  struct Column : CsvColumn {
    std::optional<std::size_t> place;
    std::string unit;
  };
  const Column& at(std::string_view column) const;
  bool next_record();
  void read_header();
  void read_column(std::string_view cell, std::size_t place);
  std::string names() const;

  CsvRecords records_;
  FaultList& faults_;
  std::vector<Column> columns_;
  std::size_t n_cells_ = 0;
  int header_line_ = 0;
  bool is_readable_ = false;
};

} // namespace maille
