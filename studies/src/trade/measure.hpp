#pragma once
/// Measurement of one answer, and its row in `maille study trade`.

#include "results/result_table.hpp"
#include "trade/trade.hpp"

namespace maille::studies {

/// True if a method stops at an error estimate below a tolerance.
bool has_tolerance(std::string_view method);
bool is_finite_elements(std::string_view method);

/// A copy of `scene` with that relaxation tolerance.
Scene with_tolerance(const Scene& scene, std::optional<double> tolerance);

struct Measured {
  Answer answer;           ///< its seconds: the smaller of wall-clock and processor time
  double wall_seconds = 0; ///< set-up and solve
};

/// Solves the scene once, without cached data.
/// @param tolerance  see Way
Measured measure(const Scene& scene, const std::string& method, std::optional<double> tolerance,
                 const Control& control);

/// Median, or the lower of the two middle values. @pre not empty
double median(std::vector<double> values);

/// One row with the common data of its table.
struct TradeRecord {
  std::string scene, reference;
  std::optional<double> reference_l2; ///< the reference's own error
  TradeRow row;
  int dimension = 3;
};

/// All rows of a trade.
std::vector<TradeRecord> records_of(const Scene& scene, const Trade& trade);

const ResultTable<TradeRecord>& columns_of_trade();

} // namespace maille::studies
