// Distances over which rays may skip invisible bricks.

#include "cast/cast_task.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace maille::render {

namespace {

/// One pass of the distance transform: every brick takes the minimum of its neighbours in half of all
/// directions, plus one. @param order 1: from the first brick to the last; -1: backwards
void pass(std::vector<std::uint8_t>& distance, const Index3& n, int order) {
  const std::int64_t n_bricks = std::int64_t{n[0]} * n[1] * n[2];
  for (std::int64_t step = 0; step < n_bricks; ++step) {
    const std::int64_t brick = order > 0 ? step : n_bricks - 1 - step;
    const int i = static_cast<int>(brick % n[0]), j = static_cast<int>(brick / n[0] % n[1]),
              k = static_cast<int>(brick / (std::int64_t{n[0]} * n[1]));
    int least = distance[brick];
    for (int dk = -1; dk <= 1; ++dk)
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          const int before = di + 3 * (dj + 3 * dk); // < 0: earlier in the order of bricks
          const int x = i + di, y = j + dj, z = k + dk;
          if (before * order >= 0 || x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2])
            continue;
          const std::size_t other = x + std::int64_t{n[0]} * (y + std::int64_t{n[1]} * z);
          least = std::min(least, distance[other] + 1);
        }
    distance[brick] = static_cast<std::uint8_t>(least);
  }
}

} // namespace

std::vector<std::uint8_t> brick_distances(const Volume& volume, const TransferTable& table,
                                          const Look& look) {
  std::vector<std::uint8_t> distance;
  distance.reserve(volume.brick_ranges().size());
  for (const Volume::Range& range : volume.brick_ranges())
    distance.push_back(is_visible(range, table, look, volume) ? 0 : 255);
  pass(distance, volume.bricks(), 1);
  pass(distance, volume.bricks(), -1);
  return distance;
}

} // namespace maille::render
