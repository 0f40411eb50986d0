#pragma once
/// Converts between places of a body and an image's voxel indices. Private to scene.

#include "maille/images/image.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille::warping {

inline Eigen::Vector3d eigen(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// An affine map; `of(x)` = linear x + shift.
struct Affine3 {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  Eigen::Vector3d of(const Eigen::Vector3d& x) const { return linear * x + shift; }
  Affine3 inverse() const {
    const Eigen::Matrix3d back = linear.inverse();
    return {back, -(back * shift)};
  }
};

/// From voxel indices, whole numbers at centres, to the image's world [m].
Affine3 voxels_to_world(const ImageInfo& grid);
/// From a body's frame [m] to the image's world [m]; converts between RAS and LPS.
Affine3 body_to_world(const ImageInfo& grid, const Placement& placement);
/// From a body's frame [m] to voxel indices.
Affine3 body_to_voxels(const ImageInfo& grid, const Placement& placement);

/// Finds the cell of a body that contains a place at rest.
class RestCells {
public:
  RestCells(const ImageInfo& grid, const Specimen& body)
      : body_(body), to_cells_(body_to_voxels(grid, body.placement).inverse()) {
    const Eigen::Vector3d per_cell = eigen(body.grid.spacing()).cwiseInverse();
    to_cells_ = {per_cell.asDiagonal() * to_cells_.linear,
                 per_cell.asDiagonal() * (to_cells_.shift - eigen(body.origin))};
  }
  /// Place in units of cells from node 0.
  Eigen::Vector3d place(const Eigen::Vector3d& voxel) const { return to_cells_.of(voxel); }
  /// The cell of matter at a place, or -1.
  std::int64_t cell_at(const Eigen::Vector3d& voxel) const {
    const Eigen::Vector3d at = place(voxel);
    const Index3& cells = body_.grid.cells();
    Index3 cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double x = at[static_cast<Eigen::Index>(a)];
      if (!(x >= 0 && x < cells[a]))
        return -1;
      cell[a] = static_cast<int>(x);
    }
    const std::int64_t number = body_.grid.cell(cell);
    return body_.is_matter(number) ? number : -1;
  }

  /// Marks the voxels (0 to row.size() - 1, j, k) whose centre is in matter.
  void mark(int j, int k, std::vector<char>& row) const {
    const Index3& cells = body_.grid.cells();
    const auto along = [&](std::size_t axis, int i) {
      const auto a = static_cast<Eigen::Index>(axis);
      return to_cells_.linear(a, 0) * i + to_cells_.linear(a, 1) * j + to_cells_.linear(a, 2) * k +
             to_cells_.shift[a];
    };
    // Along a row places are monotone, also after rounding: those within the grid are consecutive.
    int first = 0, last = static_cast<int>(row.size());
    for (std::size_t a = 0; a < 3; ++a) {
      const bool is_up = to_cells_.linear(static_cast<Eigen::Index>(a), 0) >= 0;
      const auto before = [&](int i) { return is_up ? !(along(a, i) >= 0) : !(along(a, i) < cells[a]); };
      const auto within = [&](int i) { return is_up ? along(a, i) < cells[a] : along(a, i) >= 0; };
      first = first_without(first, last, before);
      last = first_without(first, last, within);
    }
    if (body_.material_id.empty())
      return std::fill(row.begin() + first, row.begin() + last, char{1});
    for (int i = first; i < last; ++i)
      if (body_.is_matter(body_.grid.cell(
              {static_cast<int>(along(0, i)), static_cast<int>(along(1, i)), static_cast<int>(along(2, i))})))
        row[i] = 1;
  }

private:
  /// First number in [first, last) without the property `has`, which holds for a leading part; `last` if
  /// none exists.
  template<class Has>
  static int first_without(int first, int last, const Has& has) {
    while (first < last) {
      const int middle = first + (last - first) / 2;
      if (has(middle))
        first = middle + 1;
      else
        last = middle;
    }
    return first;
  }

  const Specimen& body_;
  Affine3 to_cells_;
};

/// Calls visit(voxel number, indices) for every voxel of the image.
template<class Visit>
void for_each_voxel(const ImageInfo& grid, Visit&& visit) {
  std::size_t voxel = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++voxel)
        visit(voxel, Eigen::Vector3d(i, j, k));
}

} // namespace maille::warping
