#pragma once
/// Tables of numbers as CSV, whose first row names the columns and their units.

#include "maille/materials/csv_table.hpp"

#include <filesystem>
#include <vector>

namespace maille::reader {

struct NumberRow {
  int line = 0;
  std::vector<double> values; ///< SI, one a column that was asked for; 0 where the file has no such column
};

struct NumberTable {
  std::vector<NumberRow> rows;
  std::vector<bool> has; ///< by column
};

/// Columns stand in any order, `name [unit]`, or `name` in SI units; lines that begin with `#` are passed
/// over. A scene with `units` of its own does not say those of the table: its lengths and angles then need
/// a unit.
/// @param scene of the scene that names the file
/// @throws InputError with every fault: a missing file, an unknown, repeated or missing column, cells without
/// a number of that unit, no rows
NumberTable read_number_table(const std::filesystem::path& file, const std::vector<CsvColumn>& columns,
                              const FileUnits& scene = {});

} // namespace maille::reader
