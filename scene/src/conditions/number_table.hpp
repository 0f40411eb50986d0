#pragma once
/// Tables of numbers in CSV; the first row names the columns and their units.

#include "maille/materials/csv_table.hpp"

#include <filesystem>
#include <vector>

namespace maille::reader {

struct NumberRow {
  int line = 0;
  std::vector<double> values; ///< SI, one per requested column; 0 if the file lacks it
};

struct NumberTable {
  std::vector<NumberRow> rows;
  std::vector<bool> has; ///< by column
};

/// Columns may have any order: `name [unit]`, or `name` in SI units; lines that begin with `#` are skipped.
/// The key `units` of a scene does not apply to its tables: if it is set, lengths and angles in tables need a
/// unit.
/// @param scene of the scene that names the file
/// @throws InputError with every fault: a missing file, an unknown, repeated or missing column,
///         cells that are no number in that unit, no rows
NumberTable read_number_table(const std::filesystem::path& file, const std::vector<CsvColumn>& columns,
                              const FileUnits& scene = {});

} // namespace maille::reader
