#pragma once
/// Inner loops of the wavefront: bounds of the links of a tile from the kinds of its cells, and relaxation of
/// the tile to its fixpoint, in integers.

#include "maille/scene/link_intervals.hpp"

#include <array>
#include <cstdint>

namespace maille::deform {

/// A tile holds 8 x 8 x 8 nodes, or 8 x 8 x 4, 2 or 1 where the grid is no thicker along z, x fastest, so a
/// row is one 256-bit vector.
inline constexpr int tile_edge = 8;
inline constexpr int tile_layer = tile_edge * tile_edge;

/// The bound of a link that does not exist. Values stay within half of it, so it never binds, and sums with
/// it do not overflow.
inline constexpr std::int32_t no_link = 1 << 30;
/// Values of nodes lie in [-largest_value, largest_value].
inline constexpr std::int32_t largest_value = no_link / 2;

/// Direction of change of the values of a tile.
enum class Way { raise, lower };

/// Where the bounds of a tile's links lie within its block of 6 * volume + 6 * tile_layer numbers. The links
/// owned by a node are those to its next nodes; the face blocks repeat those of the lower neighbours that end
/// in this tile, so that a visit reads no other block.
struct BlockLayout {
  int volume = 0; ///< nodes of a tile: tile_layer * layers
  /// Along x as [z][x][y], along y and z as [z][y][x].
  int low(int axis) const { return axis * volume; }
  int high(int axis) const { return (3 + axis) * volume; }
  /// x face [z][y], y face [z][x], z face [y][x].
  int face_low(int axis) const { return 6 * volume + axis * tile_layer; }
  int face_high(int axis) const { return 6 * volume + (3 + axis) * tile_layer; }
  int size() const { return 6 * volume + 6 * tile_layer; }
};

/// One visit of a tile. Pointers are aligned to 64 bytes.
struct Visit {
  Way way = Way::raise;
  int layers = tile_edge;                    ///< along z: 8, or 4, 2, 1 where the grid has one tile along z
  std::int32_t* values = nullptr;            ///< of the tile's nodes
  const std::int32_t* bounds = nullptr;      ///< its block; null: all its links exist and have `even`
  LinkIntervals<std::int32_t> even;          ///< by axis, in quanta, where `bounds` is null
  std::array<std::int32_t*, 6> neighbours{}; ///< values of the tiles at -x +x -y +y -z +z; null: none
  std::array<std::int32_t, 6> violations{};  ///< out: the largest change that each neighbour was given
};

/// Brings the tile to its fixpoint, hands the values of its faces on to the neighbours' nearest layers, and
/// says by how much those changed.
///
/// With Way::raise, the least x' >= x with x'_next >= x'_node + low and x'_node >= x'_next - high on all
/// links within the tile; with Way::lower the greatest x' <= x with x'_next <= x'_node + high and x'_node <=
/// x'_next
/// - low. Lines along each axis in turn, each brought to its own fixpoint by one step forth and one back
/// (exact since low <= high), until every axis has been passed since the last change.
using VisitTile = void (*)(Visit&);

/// The version of the kernel for the best vector instructions of this machine (or of those that
/// hwy::SetSupportedTargetsForTest leaves). Whole numbers: every version gives the same bits.
VisitTile best_visit_tile();

/// The cells around a tile's nodes, those of its lower neighbours' last links included: [z][y][x], cell (0,
/// 0, 0) before node (0, 0, 0) along every axis. Kinds are counted from 1; 0 is no matter. Rows are padded so
/// that they are whole vectors.
struct CellBox {
  static constexpr int edge = tile_edge + 1;
  static constexpr int padded_edge = tile_edge + tile_edge / 2;
  using Row = std::array<std::int32_t, padded_edge>;
  std::array<std::array<Row, edge>, edge> kind;
};

/// Fills a block (see BlockLayout): a link obeys the tightest of the up to four cells around it.
/// @param of_kinds what the kinds of cells grant, [axis][kind]; kind 0 grants -no_link and no_link, anything
using FillBlock = void (*)(const CellBox& box, const LinkIntervals<const std::int32_t*>& of_kinds, int layers,
                           std::int32_t* block);
FillBlock best_fill_block();

} // namespace maille::deform
