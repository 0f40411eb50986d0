#pragma once
/// Memory layout of the nodes and cells of a body of any shape: rows along x where there is matter.

#include "lattice/field_memory.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

namespace maille::deform {

/// Nodes along x that follow one another. Nodes have slots in the order of rows.
struct NodeRow {
  Index3 first{};        ///< node
  std::int32_t slot = 0; ///< of the first node
  int nodes = 0;
};

/// Consecutive cells along x, processed in blocks; the last block may reach beyond them.
struct CellRun {
  static constexpr int block = line_of_floats / 2;

  Index3 first{}; ///< cell
  std::int32_t node_slot[4] =
      {}; ///< of the first node of its four rows of nodes: (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)
  /// Number of the first cell, a multiple of the block. Where cells have coefficients of their own: the
  /// number of its first block.
  std::int32_t cell_slot = 0;
  int cells = 0;
  bool bends = false; ///< some of the cells are thin

  int blocks() const { return (cells + block - 1) / block; }
  int node_blocks() const { return (cells + block) / block; } ///< of the nodes at their corners
};

/// Memory and work follow the body, not its bounding box. In a row the next node along x is the next in
/// memory, so loops run in vectors without neighbour tables. A loop over the blocks of a run may read and
/// write up to a block beyond its nodes and adds zero there: to the next rows, or to unused slots between
/// slabs of planes. So slabs that run in parallel (every second one) share no slot.
class MaskedRows {
public:
  static constexpr int block = CellRun::block;
  static constexpr int planes_per_slab = 3;

  /// @param body in 3D; must outlive this
  explicit MaskedRows(const Specimen& body);
  /// Rows of some layers; planes at their ends have the rows that these layers touch.
  MaskedRows(const Specimen& body, LayerRange layers);

  std::span<const NodeRow> rows_of_planes(PlaneRange planes) const {
    const auto before = [&](int plane) {
      return std::ranges::lower_bound(node_rows_, plane, {}, [](const NodeRow& row) { return row.first[2]; });
    };
    return {before(planes.first), before(planes.end)};
  }
  /// Runs of layer z of cells.
  std::span<const CellRun> runs_of_layer(int z) const { return runs_of_layers(z, z + 1); }
  std::span<const CellRun> runs_of_layers(int first, int end) const {
    return std::span(runs_).subspan(first_run(first), first_run(end) - first_run(first));
  }
  std::span<CellRun> runs_of_layers(int first, int end) {
    return std::span(runs_).subspan(first_run(first), first_run(end) - first_run(first));
  }
  LayerRange layers() const { return layers_; }
  std::int32_t n_slots() const { return n_slots_; } ///< a multiple of the block
  /// Number of slots for rows with n nodes: the last run reaches beyond its nodes.
  static constexpr std::int64_t n_slots_for(std::int64_t n) { return (n + 2 * block - 1) / block * block; }
  std::int32_t n_slots_of_rows() const { return n_slots_of_rows_; }
  /// First slot of plane z of nodes, or the end; slots between planes belong to the plane before.
  std::int32_t first_slot(int z) const { return first_slot_[z - layers_.first]; }
  std::int32_t n_cell_slots() const { return n_cell_slots_; }
  /// @pre the node is in a stored row, as every node of matter between stored layers is
  std::int32_t slot(const Index3& node) const;

private:
  std::size_t first_run(int layer) const {
    return static_cast<std::size_t>(first_run_[layer - layers_.first]);
  }
  void place_cells(const Specimen& body);
  void place_nodes(const Grid& grid);

  LayerRange layers_;
  int rows_in_plane_ = 0;
  List<NodeRow> node_rows_;
  List<std::int32_t> first_row_; ///< per y and z of nodes: into node_rows_
  List<CellRun> runs_;
  List<std::int32_t> first_run_;  ///< per layer
  List<std::int32_t> first_slot_; ///< per plane of nodes
  std::int32_t n_slots_ = 0, n_slots_of_rows_ = 0, n_cell_slots_ = 0;
};

} // namespace maille::deform
