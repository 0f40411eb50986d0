#pragma once
/// Merges runs of several objects by depth, pixel by pixel. Private to render.
///
/// Scheme: each object is cast alone, tile by tile, into runs: gapless parts along a ray, already
/// composited. The runs of a pixel are sorted by depth, for equal depth by the object's number, and blended
/// from the eye on.
///
/// Exact: runs that do not overlap in depth. Where runs of two objects do, both rays are cast again with
/// every sample as a run of its own, so that samples of both alternate. Tiles are independent of each other.

#include "prepare/prepared_object.hpp"

#include <functional>
#include <utility>
#include <vector>

namespace maille::render {

/// Resizes the picture and clears it.
void clear(Picture& picture, int width, int height);

/// One object in a tile.
struct TileLayer {
  std::int32_t object;
  const TileRuns* runs;
  const PreparedObject* prepared;
};

/// A tile's number and what lies in it.
using TileLayers = std::pair<int, std::vector<TileLayer>>;

/// Writes the pixels of `n` different tiles and counts the work.
/// @param layers_of called once for every item, by any thread
void compose_tiles(int n, const std::function<TileLayers(int)>& layers_of, int threads, Picture& picture,
                   Counters& counters);

} // namespace maille::render
