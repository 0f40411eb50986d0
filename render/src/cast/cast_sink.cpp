#include "cast/cast_task.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace maille::render {

void RunSink::take(TileRuns& tile) {
  tile.first.clear();
  tile.runs.clear();
  if (runs.empty()) {
    tile.first.shrink_to_fit();
    tile.runs.shrink_to_fit();
    return;
  }
  tile.first.assign(tile_pixels + 1, 0);
  for (const auto& [pixel, run] : runs)
    ++tile.first[static_cast<std::size_t>(pixel) + 1];
  for (std::size_t p = 0; p < tile_pixels; ++p)
    tile.first[p + 1] += tile.first[p];
  std::array<std::uint32_t, tile_pixels> place{};
  std::copy_n(tile.first.begin(), tile_pixels, place.begin());
  tile.runs.resize(runs.size());
  for (const auto& [pixel, run] : runs)
    tile.runs[place[pixel]++] = run;
}

} // namespace maille::render
