#pragma once
/// What a row of a trade holds, in every form: `maille trade` writes it, `maille choose` reads it.

#include "maille/studies/trade.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

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

/// A lattice by its spacing over the scene's: 2, 1, 1/2.
std::string spacing_in_words(int halvings);

} // namespace maille::studies
