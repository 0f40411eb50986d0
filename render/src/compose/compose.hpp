#pragma once
/// Merges runs of several objects by depth, pixel by pixel. Private to render.

#include "prepare/prepared_object.hpp"

#include <span>

namespace maille::render {

/// Resizes the picture to the view and clears it.
void clear(Picture& picture, const View& view);

/// One object in a tile.
struct TileLayer {
  std::int32_t object;
  const TileRuns* runs;
  const PreparedObject* prepared;
};

struct ComposeCounts {
  std::int64_t rays = 0, pixels = 0;
};

/// Writes the pixels of a tile. If runs of two objects overlap in depth, their rays are cast again sample by
/// sample, and samples are merged.
ComposeCounts compose_tile(int tile, std::span<const TileLayer> layers, Picture& picture);

} // namespace maille::render
