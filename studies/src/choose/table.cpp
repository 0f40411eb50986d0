#include "choose/choose.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

constexpr std::int64_t largest_table = std::int64_t{1} << 28; // some 500,000 rows
constexpr int most_halvings = 10;                             // what `maille study trade --spacings` takes

/// Lattices by which probes were finer than at twice the spacing.
int shift_of_probes(const RawPrediction& predicted) {
  return predicted.probe_halvings >= 0 && predicted.probe_halvings <= most_halvings
             ? predicted.probe_halvings + 1
             : 0;
}

/// Nothing of a row without measurement, prediction, or the reference's own error.
std::optional<StoredRow> stored(const TradeRecord& record) {
  const TradeRow& row = record.row;
  if (!is_converged(row.status) || !row.error || !row.predicted.error || !row.predicted.seconds ||
      !record.reference_l2)
    return std::nullopt;
  StoredRow result;
  result.scene = fmt::format("{} {}", record.scene, row.nodes);
  result.way = row.way;
  result.way.halvings -= shift_of_probes(row.predicted);
  // What the reference cannot tell apart from itself may be off by as much as the reference is.
  result.error = std::max(row.error->relative_l2, *record.reference_l2);
  result.seconds = row.seconds.total();
  result.predicted_error = *row.predicted.error;
  result.predicted_seconds = *row.predicted.seconds;
  const auto counts = [](double value) { return value > 0 && std::isfinite(value); };
  return counts(result.error) && counts(result.seconds) && counts(result.predicted_error) &&
                 counts(result.predicted_seconds)
             ? std::optional(std::move(result))
             : std::nullopt;
}

} // namespace

std::vector<StoredRow> parse_trade_table(std::string_view text, const std::string& name) {
  auto read = columns_of_trade().read_csv(
      text, {name,
             {"method", "halvings", "tolerance", "status", "relative_l2", "total_s", "predicted_error",
              "predicted_s", "reference_l2", "scene", "nodes"}});
  std::vector<StoredRow> rows;
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    const int halvings = read.rows[i].row.way.halvings;
    if (halvings < -most_halvings || halvings > most_halvings)
      read.faults.push_back({name, read.lines[i], "halvings",
                             fmt::format("a whole number from -{0} to {0}", most_halvings),
                             fmt::format("{}", halvings)});
    if (auto row = stored(read.rows[i]))
      rows.push_back(std::move(*row));
  }
  std::ranges::stable_sort(read.faults, {}, &Fault::line);
  if (!read.faults.empty())
    throw InputError(std::move(read.faults));
  return rows;
}

std::vector<StoredRow> read_trade_table(const std::filesystem::path& file) {
  return parse_trade_table(read_text_file(file, "a table", largest_table), file.string());
}

std::vector<StoredRow> built_in_trade_table() {
  return parse_trade_table(table_csv(), "studies/trade/table.csv");
}

} // namespace maille::studies
