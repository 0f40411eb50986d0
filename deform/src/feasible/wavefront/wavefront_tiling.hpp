#pragma once
/// Tiles of nodes of a body.

#include "feasible/wavefront/wavefront_kernel.hpp"
#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>

namespace maille::deform {

/// A node's tile and its place in it.
struct TilePlace {
  std::int32_t tile = 0;
  int slot = 0; ///< x + 8 (y + 8 z) within the tile
};

/// The tiles that hold nodes of matter, numbered in grid order; their neighbours; which of their slots are
/// nodes.
class Tiling {
public:
  explicit Tiling(const Specimen& specimen);

  const Specimen& specimen() const { return *specimen_; }
  int layers() const { return layers_; }
  static int volume_for(const Specimen& specimen);
  int volume() const { return layers_ * tile_layer; } ///< slots of a tile
  std::int32_t n_tiles() const { return static_cast<std::int32_t>(base_.size()); }
  /// The node at slot 0.
  const Index3& base(std::int32_t tile) const { return base_[tile]; }
  /// Tiles at -x +x -y +y -z +z, or -1.
  const std::array<std::int32_t, 6>& neighbours(std::int32_t tile) const { return neighbours_[tile]; }
  /// One bit a slot in each layer.
  std::uint64_t node_bits(std::int32_t tile, int layer) const { return node_bits_[tile * layers_ + layer]; }
  bool is_node(const TilePlace& place) const {
    return node_bits(place.tile, place.slot / tile_layer) >> (place.slot % tile_layer) & 1;
  }
  /// @pre `node` is a node of the body
  TilePlace place(std::int64_t node) const;
  /// True if a grid point is a node of the body.
  bool has(std::int64_t node) const;

  /// Calls visit(tile, slot, node) for every node of a tile.
  template<class Visit>
  void for_each_node(std::int32_t tile, const Visit& visit) const;

  /// The number of tiles, without making them. Cost: O(cells) where the body does not
  /// fill its grid
  static std::int64_t n_tiles_of(const Specimen& specimen);
  /// Tiles of the grid, with matter or without.
  static std::int64_t n_places(const Specimen& specimen);

private:
  bool find_nodes(const Index3& base);

  const Specimen* specimen_;
  int layers_ = tile_edge;
  Index3 n_along_{};           ///< tiles of the grid along each axis
  List<std::int32_t> tile_at_; ///< of the grid's tiles; -1: no matter
  List<Index3> base_;
  List<std::array<std::int32_t, 6>> neighbours_;
  List<std::uint64_t> node_bits_; ///< [tile][layer]
};

template<class Visit>
void Tiling::for_each_node(std::int32_t tile, const Visit& visit) const {
  const Grid& grid = specimen_->grid;
  const std::int64_t corner = grid.node(base(tile));
  for (int layer = 0; layer < layers_; ++layer)
    for (std::uint64_t bits = node_bits(tile, layer); bits != 0; bits &= bits - 1) {
      const int at = __builtin_ctzll(bits);
      visit(tile, layer * tile_layer + at,
            corner + at % tile_edge + at / tile_edge * grid.stride(1) + layer * grid.stride(2));
    }
}

} // namespace maille::deform
