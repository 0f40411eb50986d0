#pragma once
/// One answer of one way, measured, and the row of `maille study trade` that it makes.

#include "results/result_table.hpp"
#include "trade/trade.hpp"

namespace maille::studies {

/// True if a method ends when an estimate of its error is below a tolerance.
bool has_tolerance(std::string_view method);
bool is_finite_elements(std::string_view method);

/// A copy of `scene` whose relaxation has that tolerance.
Scene with_tolerance(const Scene& scene, std::optional<double> tolerance);

struct Measured {
  Answer answer;           ///< its seconds: the smaller of wall-clock and processor time
  double wall_seconds = 0; ///< set-up and solve
};

/// Answers the scene once, with nothing kept from before.
/// @param tolerance  see Way
Measured measure(const Scene& scene, const std::string& method, std::optional<double> tolerance,
                 const Control& control);

/// The middle one, or the lower of the middle two. @pre not empty
double median(std::vector<double> values);

/// One row with what it shares with the others of its table.
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
