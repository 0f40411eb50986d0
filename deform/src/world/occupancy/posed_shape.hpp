#pragma once
/// Cells that an object occupies at a pose.

#include "maille/deform/world/rigid_shape.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace maille::deform {

/// y = offset + sum over axes of column * index, in cells; the cell is the floor of y. Sums are evaluated in
/// this order and without fused operations, so that a voxel's cell is the same on every machine and in all
/// code of the world.
struct CellsFromIndices {
  std::array<std::array<double, 3>, 3> columns{}; ///< columns[axis of the lattice][axis of the world]
  std::array<double, 3> offset{};
};

/// Cells of n voxels.
void cells_from_indices(const CellsFromIndices& from, const std::int16_t* const index[3], std::int64_t n,
                        std::int32_t* const cells[3]);

/// A shape at a pose, over the cells of a world. If the lattice is aligned with the world's cells (no
/// rotation, same spacing), the cell is the index plus a shift, so that the object keeps its shape exactly.
class PosedShape {
public:
  PosedShape(const RigidShape& shape, const Pose& pose, const Vec3& cell_size);

  const RigidShape& shape() const { return *shape_; }
  bool is_aligned() const { return aligned_; }
  /// @pre is_aligned()
  Index3 cell_of_row(const RigidShape::Row& row) const {
    return {row.first[0] + shift_[0], row.first[1] + shift_[1], row.first[2] + shift_[2]};
  }
  /// Cells of n voxels from number `first` on, one array per axis.
  void cells(std::int32_t first, std::int32_t n, std::int32_t* const cells[3]) const;
  Index3 cell(std::int32_t voxel) const;

private:
  const RigidShape* shape_;
  CellsFromIndices from_;
  bool aligned_;
  Index3 shift_{};
};

/// Calls visit(first cell, size, first voxel) for boxes of cells whose voxels have consecutive numbers along
/// x, then y, then z: full blocks and rows if the shape is aligned, else single voxels.
template<class Visit>
void for_each_box(const PosedShape& posed, Visit&& visit);

/// Calls visit(first voxel, n, cells) for batches of voxels in the order of their numbers, until it returns
/// true. @return true if it did
template<class Visit>
bool any_cells_of(const PosedShape& posed, std::int32_t first, std::int32_t end, Visit&& visit) {
  std::array<std::int32_t, 256> x, y, z;
  std::int32_t* const cells[3] = {x.data(), y.data(), z.data()};
  for (std::int32_t n = 0; first < end; first += n) {
    n = std::min(end - first, static_cast<std::int32_t>(x.size()));
    posed.cells(first, n, cells);
    if (visit(first, n, cells))
      return true;
  }
  return false;
}

/// The same with visit(n, cells) for all voxels.
template<class Visit>
bool any_cells(const PosedShape& posed, Visit&& visit) {
  return any_cells_of(
      posed, 0, posed.shape().n_voxels(),
      [&](std::int32_t, std::int32_t n, const std::int32_t* const* cells) { return visit(n, cells); });
}

/// Calls visit(voxel, cell) for all voxels in the order of their numbers until it returns true.
/// @return whether it did
template<class Visit>
bool any_voxel(const PosedShape& posed, std::int32_t first, std::int32_t end, Visit&& visit) {
  return any_cells_of(posed, first, end,
                      [&](std::int32_t voxel, std::int32_t n, const std::int32_t* const* cells) {
                        for (std::int32_t i = 0; i < n; ++i)
                          if (visit(voxel + i, Index3{cells[0][i], cells[1][i], cells[2][i]}))
                            return true;
                        return false;
                      });
}

template<class Visit>
void for_each_box(const PosedShape& posed, Visit&& visit) {
  const RigidShape& shape = posed.shape();
  if (!posed.is_aligned()) {
    any_voxel(posed, 0, shape.n_voxels(), [&](std::int32_t voxel, const Index3& cell) {
      visit(cell, Index3{1, 1, 1}, voxel);
      return false;
    });
    return;
  }
  for (const RigidShape::Block& block : shape.blocks()) {
    const auto rows =
        shape.rows().subspan(block.first_row, static_cast<std::size_t>(block.end_row - block.first_row));
    if (block.is_full())
      visit(posed.cell_of_row(rows.front()), block.size, block.first);
    else
      for (const RigidShape::Row& row : rows)
        visit(posed.cell_of_row(row), Index3{row.n, 1, 1}, row.voxel);
  }
}

} // namespace maille::deform
