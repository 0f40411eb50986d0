#include "world/occupancy/posed_shape.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Coordinate of a cell, clamped to the range of int far outside any world.
int cell_below(double y) {
  return static_cast<int>(std::floor(std::clamp(y, -furthest_cell, furthest_cell)));
}

} // namespace

PosedShape::PosedShape(const RigidShape& shape, const Pose& pose, const Vec3& cell_size)
    : shape_(&shape), aligned_(pose.rotation == Eigen::Matrix3d::Identity() && shape.spacing() == cell_size) {
  for (std::size_t b = 0; b < 3; ++b) {
    const auto row = static_cast<Eigen::Index>(b);
    double sum = pose.position[row];
    for (std::size_t a = 0; a < 3; ++a) {
      const double column = pose.rotation(row, static_cast<Eigen::Index>(a)) * shape.spacing()[a];
      from_.columns[a][b] = column / cell_size[b];
      sum += 0.5 * column;
    }
    from_.offset[b] = sum / cell_size[b];
    if (aligned_)
      shift_[b] = cell_below(from_.offset[b]);
  }
}

void PosedShape::cells(std::int32_t first, std::int32_t n, std::int32_t* const cells[3]) const {
  const std::int16_t* const index[3] = {shape_->index(0).data() + first, shape_->index(1).data() + first,
                                        shape_->index(2).data() + first};
  if (!aligned_)
    return cells_from_indices(from_, index, n, cells);
  for (std::size_t a = 0; a < 3; ++a)
    std::transform(index[a], index[a] + n, cells[a], [&](std::int16_t i) { return i + shift_[a]; });
}

Index3 PosedShape::cell(std::int32_t voxel) const {
  Index3 at;
  std::int32_t* const cells_of_one[3] = {&at[0], &at[1], &at[2]};
  cells(voxel, 1, cells_of_one);
  return at;
}

} // namespace maille::deform
