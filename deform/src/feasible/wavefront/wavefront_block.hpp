#pragma once
/// The bounds of one tile's links from the kinds of the cells around them, by vector code.

#include "feasible/wavefront/wavefront_kernel.hpp"

namespace maille::deform {

/// The cells around a tile's nodes, those of its lower neighbours' last links included: [z][y][x], cell
/// (0, 0,
/// 0) before node (0, 0, 0) along every axis. Kinds are counted from 1; 0 is no matter. Rows are padded so
/// that they are whole vectors.
struct CellBox {
  static constexpr int edge = tile_edge + 1;
  static constexpr int padded_edge = 12;
  using Row = std::array<std::int32_t, padded_edge>;
  std::array<std::array<Row, edge>, edge> kind;
};

/// What the kinds of cells grant, [axis][kind]; kind 0 grants -no_link and no_link, that is anything.
struct BoundsOfKinds {
  std::array<const std::int32_t*, 3> low{}, high{};
};

/// Fills a block (see BlockLayout): a link obeys the tightest of the up to four cells around it.
using FillBlock = void (*)(const CellBox& box, const BoundsOfKinds& of_kinds, int layers,
                           std::int32_t* block);
FillBlock best_fill_block();

} // namespace maille::deform
