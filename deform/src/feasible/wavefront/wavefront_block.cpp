#include "feasible/wavefront/wavefront_kernel.hpp"

#ifndef HWY_DISABLED_TARGETS // cmake/compile_options.cmake, on x86
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/wavefront/wavefront_block.cpp" // NOLINT
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace maille::deform::HWY_NAMESPACE {
namespace {

// Plain loops over whole rows, compiled once for every set of instructions.

constexpr int edge = CellBox::edge, padded = CellBox::padded_edge;
using Values = std::int32_t[edge][edge][padded];

template<bool larger>
HWY_INLINE std::int32_t tighter(std::int32_t a, std::int32_t b) {
  return larger ? (a > b ? a : b) : (a < b ? a : b);
}

/// row = the tighter of row and next, number by number.
template<bool larger>
HWY_INLINE void join(std::int32_t* row, const std::int32_t* next, int n) {
  for (int x = 0; x < n; ++x)
    row[x] = tighter<larger>(row[x], next[x]);
}

/// Afterwards the link along `axis` of the tile's node i has the value at i, + 1 along `axis`.
template<int axis, bool larger>
HWY_INLINE void join_cells(const CellBox& box, const std::int32_t* of_kind, Values& values) {
  for (std::size_t z = 0; z < edge; ++z)
    for (std::size_t y = 0; y < edge; ++y)
      for (std::size_t x = 0; x < padded; ++x)
        values[z][y][x] = of_kind[box.kind[z][y][x]];
  // Along the two other axes, the cell before a node and the one after it. In place, from the front.
  if constexpr (axis != 2)
    join<larger>(values[0][0], values[1][0], (edge - 1) * edge * padded);
  if constexpr (axis != 1)
    for (int z = 0; z < edge; ++z)
      join<larger>(values[z][0], values[z][1], (edge - 1) * padded);
  if constexpr (axis != 0) // the last number of each row has no neighbour, and is padding
    join<larger>(values[0][0], values[0][0] + 1, edge * edge * padded - 1);
}

/// The tile's own links along `axis` go to `own`, the last ones of its lower neighbour to `face`.
template<int axis>
HWY_INLINE void write(const Values& values, int layers, std::int32_t* own, std::int32_t* face) {
  for (int z = 0; z < layers; ++z)
    for (int i = 0; i < tile_edge; ++i)
      for (int k = 0; k < tile_edge; ++k) // along x the block is [z][x][y]
        own[tile_layer * z + tile_edge * i + k] = axis == 0   ? values[z][k][i + 1]
                                                  : axis == 1 ? values[z][i + 1][k]
                                                              : values[z + 1][i][k];
  const int rows = axis == 2 ? tile_edge : layers;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < tile_edge; ++i)
      face[tile_edge * j + i] = axis == 0 ? values[j][i][0] : axis == 1 ? values[j][0][i] : values[0][j][i];
}

template<int axis>
void fill_axis(const CellBox& box, const LinkIntervals<const std::int32_t*>& of_kinds, int layers,
               std::int32_t* block) {
  const BlockLayout layout{layers * tile_layer};
  alignas(64) Values values;
  join_cells<axis, true>(box, of_kinds.low[axis], values);
  write<axis>(values, layers, block + layout.low(axis), block + layout.face_low(axis));
  join_cells<axis, false>(box, of_kinds.high[axis], values);
  write<axis>(values, layers, block + layout.high(axis), block + layout.face_high(axis));
}

void fill_block(const CellBox& box, const LinkIntervals<const std::int32_t*>& of_kinds, int layers,
                std::int32_t* block) {
  fill_axis<0>(box, of_kinds, layers, block);
  fill_axis<1>(box, of_kinds, layers, block);
  fill_axis<2>(box, of_kinds, layers, block);
}

} // namespace
} // namespace maille::deform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

namespace {
HWY_EXPORT(fill_block);
}

FillBlock best_fill_block() {
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return HWY_DYNAMIC_DISPATCH(fill_block);
}

} // namespace maille::deform
#endif
