#pragma once
/// A regular grid of cells and the nodes at their corners, in one, two or three dimensions.
///
/// Cells hold matter, nodes unknowns; both are numbered x fastest, then y, then z. Unused axes have one cell
/// and one node, so that one loop serves every dimension.

#include <array>
#include <cstdint>

namespace maille {

using Index3 = std::array<int, 3>;
using Vec3 = std::array<double, 3>;

/// Directions of the axes of a file's world: ras (NIfTI): the patient's right, front (anterior), head
/// (superior); lps (files of ITK): left, back (posterior), head; `unknown`: not stated in the file.
enum class WorldAxes { unknown, ras, lps };

class Grid {
public:
  Grid() = default;
  /// @param dimension 1, 2 or 3; @param cells per axis, > 0; @param spacing per axis [m], > 0
  Grid(int dimension, Index3 cells, Vec3 spacing);

  int dimension() const { return dimension_; }
  const Index3& cells() const { return cells_; }
  const Index3& nodes() const { return nodes_; }
  const Vec3& spacing() const { return spacing_; }
  std::int64_t n_cells() const { return std::int64_t{1} * cells_[0] * cells_[1] * cells_[2]; }
  std::int64_t n_nodes() const { return std::int64_t{1} * nodes_[0] * nodes_[1] * nodes_[2]; }
  /// Corners of a cell: 2^dimension.
  int corners_per_cell() const { return 1 << dimension_; }

  std::int64_t cell(const Index3& at) const {
    return at[0] + cells_[0] * (at[1] + std::int64_t{1} * cells_[1] * at[2]);
  }
  std::int64_t node(const Index3& at) const {
    return at[0] + nodes_[0] * (at[1] + std::int64_t{1} * nodes_[1] * at[2]);
  }
  Index3 cell_at(std::int64_t cell) const;
  Index3 node_at(std::int64_t node) const;
  /// Distance in node numbers from a node to the next along `axis`.
  std::int64_t stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? nodes_[0] : std::int64_t{1} * nodes_[0] * nodes_[1];
  }
  bool has_cell(const Index3& at) const;
  bool has_node(const Index3& at) const;
  /// Corner `corner` (bit a set: upper side along axis a) of the cell at `cell`, as a node number.
  std::int64_t corner(const Index3& cell, int corner) const;

private:
  int dimension_ = 0;
  Index3 cells_{0, 0, 0};
  Index3 nodes_{0, 0, 0};
  Vec3 spacing_{0, 0, 0};
};

} // namespace maille
