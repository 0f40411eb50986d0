/// Tables of trades, which `maille choose --table` reads.

#include "fuzzing.hpp"
#include "maille/studies/choose.hpp"

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille;
  return fuzzing::tried([&] {
    for (const studies::StoredRow& row :
         studies::parse_trade_table(fuzzing::text_of(data, size), "table.csv"))
      fuzzing::require(std::isfinite(row.error) && row.error > 0 && std::isfinite(row.seconds) &&
                           row.seconds > 0,
                       "rows with figures that count");
  });
}
