#pragma once
/// How a three-dimensional array of voxels lies in memory, and in the world.

#include "maille/scene/grid.hpp"

#include <optional>

namespace maille {

/// Voxel (i, j, k) is element first + i stride[0] + j stride[1] + k stride[2] of the array. i, j, k run along
/// the array's axes x, y, z, whatever the order in memory; a stride may be negative (an axis that is flipped)
/// or larger than the array needs (a part of one).
struct ArrayLayout {
  Index3 size{0, 0, 0}; ///< voxels along x, y, z, > 0; one along z: a scene of two dimensions
  std::array<std::int64_t, 3> stride{0, 0, 0}; ///< in elements, not bytes
  std::int64_t first = 0;                      ///< element of voxel (0, 0, 0)

  /// x fastest: Fortran order of array(x, y, z), C order of array[z][y][x]; NIfTI, VTK, ITK.
  static ArrayLayout x_fastest(const Index3& size);
  /// z fastest: C order of array[x][y][z]; numpy's default.
  static ArrayLayout z_fastest(const Index3& size);

  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
  std::int64_t element(const Index3& at) const {
    return first + at[0] * stride[0] + at[1] * stride[1] + at[2] * stride[2];
  }
  /// True if sizes are > 0 and every voxel is an element of an array of so many, no fewer than voxels.
  bool fits(std::int64_t n_elements) const;
};

/// Rows of the 4 x 4 matrix that takes (i, j, k, 1), the indices of a voxel, to the middle of the voxel in
/// the world [m], as NIfTI's affine does (in m, not mm). Columns 0 to 2 are perpendicular to 1e-3, of any
/// lengths (the spacing) and either handedness.
using Affine = std::array<std::array<double, 4>, 4>;

/// The affine of a grid of voxels.
/// @param spacing of voxels along each axis of the array [m]
/// @param origin middle of voxel (0, 0, 0) in the world [m]
/// @param direction rows of the 3 x 3 matrix from the array's axes to the world; columns of length 1
Affine affine_of(const Vec3& spacing, const Vec3& origin = {0, 0, 0},
                 const std::array<Vec3, 3>& direction = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});

} // namespace maille
