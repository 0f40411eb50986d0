#pragma once
/// What casting an object leaves of it: runs of matter along the rays of pixels. Private to render.

#include <array>
#include <cstdint>
#include <vector>

namespace maille::render {

/// Matter of one object that a ray meets without a gap.
struct Run {
  float begin = 0, end = 0;                    ///< along the ray [m]
  float half = 0;                              ///< where half of its light is spent [m]
  std::array<float, 4> rgba{};                 ///< premultiplied
  float middle() const { return begin + end; } ///< twice; orders what does not overlap
};

/// Edge of the squares of pixels that are cast by one thread at a time.
inline constexpr int tile_edge = 16;
inline constexpr int tile_pixels = tile_edge * tile_edge;
/// Number of tiles along a number of pixels.
constexpr int tiles_along(int pixels) {
  return (pixels + tile_edge - 1) / tile_edge;
}

/// The runs of one object in one tile; pixel p's are runs[first[p]] to runs[first[p + 1]] in order of depth.
/// No numbers in `first`: the object is not in the tile.
struct TileRuns {
  std::vector<std::uint32_t> first;
  std::vector<Run> runs;

  bool empty() const { return runs.empty(); }
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(first.capacity() * sizeof(std::uint32_t) +
                                     runs.capacity() * sizeof(Run));
  }
};

} // namespace maille::render
