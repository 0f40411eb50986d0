#pragma once
/// Iterates over the cells of deformed bodies, with corners in an image's voxel indices. Private to scene.

#include "maille/scene/warp/warp.hpp"
#include "warp/cell_map.hpp"
#include "warp/voxel_frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::warping {

/// Depth limit of the inside: two cells that do not overlap cannot both contain such a place.
constexpr double surely_inside = 0.5 - 1e-4;
/// Places in cells are clamped to this depth, so that rounding does not move them to the next voxel.
constexpr double within_cell = 0.5 - 1e-6;

/// Cells at rest, in indices of an image's voxels.
class CellsAtRest {
public:
  CellsAtRest(const ImageInfo& image, const Specimen& body) {
    const Affine3 to_voxels = body_to_voxels(image, body.placement);
    orientation_ = to_voxels.linear.determinant() > 0 ? 1 : -1;
    per_cell_ = to_voxels.linear * eigen(body.grid.spacing()).asDiagonal();
    first_middle_ = to_voxels.of(eigen(body.origin)) + per_cell_ * Eigen::Vector3d(0.5, 0.5, 0.5);
  }
  Eigen::Vector3d middle(const Index3& cell) const {
    return first_middle_ + per_cell_ * Eigen::Vector3d(cell[0], cell[1], cell[2]);
  }
  /// @param s in the cell, -1/2 to 1/2; moved off its faces
  Eigen::Vector3d place(const Index3& cell, const Eigen::Vector3d& s) const { return place(middle(cell), s); }
  /// @param middle of the cell
  Eigen::Vector3d place(const Eigen::Vector3d& middle, const Eigen::Vector3d& s) const {
    return middle + per_cell_ * s.cwiseMin(within_cell).cwiseMax(-within_cell);
  }
  /// The same for take_to_rest, for a cell centred at 0.
  RestMap map(const Index3& size) const {
    RestMap map{};
    map.within = within_cell;
    for (std::size_t a = 0; a < 3; ++a) {
      map.size[a] = size[a];
      for (std::size_t b = 0; b < 3; ++b)
        map.linear[3 * a + b] = per_cell_(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
    return map;
  }
  /// Half size of the bounding box of a cell.
  Eigen::Vector3d half() const { return per_cell_.cwiseAbs().rowwise().sum() / 2; }
  /// 1, or -1 if the image's axes have the opposite handedness.
  double orientation() const { return orientation_; }

private:
  double orientation_ = 1;
  Eigen::Matrix3d per_cell_; ///< of voxels along the axes of the body's cells
  Eigen::Vector3d first_middle_;
};

/// Voxels from `first` to `last`; none if a last index is smaller.
struct VoxelBox {
  Index3 first{}, last{-1, -1, -1};

  /// Voxels of an image whose centres are at most `reach` [voxels] from the bounding box of a cell's corners,
  /// which contains the cell's trilinear image.
  VoxelBox(const Corners& corners, const Index3& size, double reach) {
    Eigen::Vector3d low = corners[0], high = corners[0];
    for (const Eigen::Vector3d& corner : corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const double slack = reach + 1e-5 * (high[axis] - low[axis]);
      if (!(high[axis] + slack >= 0 && low[axis] - slack <= size[a] - 1)) {
        last = {-1, -1, -1};
        return;
      }
      const double from = std::max(0.0, low[axis] - slack); // not negative: conversion rounds down
      first[a] = static_cast<int>(from) + (static_cast<int>(from) < from ? 1 : 0);
      last[a] = static_cast<int>(std::min(size[a] - 1.0, high[axis] + slack));
    }
  }
  /// Calls visit(voxel number, indices).
  template<class Visit>
  void for_each(const Index3& size, Visit&& visit) const {
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          visit(static_cast<std::size_t>(i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k)),
                Index3{i, j, k});
  }
};

/// The voxel that contains a place, or -1 outside the image.
inline std::int64_t voxel_at(const Index3& size, const Eigen::Vector3d& place) {
  std::int64_t voxel = 0;
  for (std::size_t a = 3; a-- > 0;) {
    const double index = place[static_cast<Eigen::Index>(a)] + 0.5;
    if (!(index >= 0 && index < size[a]))
      return -1;
    voxel = voxel * size[a] + static_cast<std::int64_t>(index); // rounds down
  }
  return voxel;
}

inline Corners corners_of(const CellMap& map) {
  Corners corners;
  for (unsigned c = 0; c < 8; ++c)
    corners[c] = map.of({c & 1U ? 0.5 : -0.5, c & 2U ? 0.5 : -0.5, c & 4U ? 0.5 : -0.5});
  return corners;
}

/// Throws if the body is not three-dimensional or has no displacement of its nodes.
inline void check(const DeformedBody& body) {
  if (!body.specimen || !body.displacement || body.specimen->grid.dimension() != 3 ||
      body.displacement->n_components() != 3 ||
      static_cast<std::int64_t>(body.displacement->n_nodes()) != body.specimen->grid.n_nodes())
    throw std::invalid_argument("expected a body of three dimensions and a displacement of its nodes");
}

/// Calls visit(cell, grid position, corners in voxel indices) for every cell of matter. Nodes are placed one
/// layer at a time.
template<class Visit>
void for_each_deformed_cell(const ImageInfo& image, const DeformedBody& body, Visit&& visit) {
  check(body);
  const Specimen& specimen = *body.specimen;
  const Displacement& u = *body.displacement;
  const Grid& grid = specimen.grid;
  const Affine3 to_voxels = body_to_voxels(image, specimen.placement);
  const auto in_layer = static_cast<std::size_t>(grid.nodes()[0]) * static_cast<std::size_t>(grid.nodes()[1]);
  std::vector<Eigen::Vector3d> lower(in_layer), upper(in_layer);
  const auto place_layer = [&](int k, std::vector<Eigen::Vector3d>& layer) {
    std::size_t at = 0;
    for (int j = 0; j < grid.nodes()[1]; ++j)
      for (int i = 0; i < grid.nodes()[0]; ++i, ++at) {
        const std::int64_t node = grid.node({i, j, k});
        const Vec3 x = specimen.position({i, j, k});
        layer[at] = to_voxels.of({x[0] + u(0, node), x[1] + u(1, node), x[2] + u(2, node)});
      }
  };
  place_layer(0, upper);
  const auto row = static_cast<std::size_t>(grid.nodes()[0]);
  for (int k = 0; k < grid.cells()[2]; ++k) {
    std::swap(lower, upper);
    place_layer(k + 1, upper);
    for (int j = 0; j < grid.cells()[1]; ++j)
      for (int i = 0; i < grid.cells()[0]; ++i) {
        const std::int64_t cell = grid.cell({i, j, k});
        if (!specimen.is_matter(cell))
          continue;
        const std::size_t first = static_cast<std::size_t>(i) + row * static_cast<std::size_t>(j);
        const Corners corners{lower[first], lower[first + 1], lower[first + row], lower[first + row + 1],
                              upper[first], upper[first + 1], upper[first + row], upper[first + row + 1]};
        visit(cell, Index3{i, j, k}, corners);
      }
  }
}

/// The same, in order of priority for overlapping cells: first cells that are not folded, in grid order, then
/// the folded ones. Calls visit(grid position, corners in voxel indices, map).
/// @return number of folded cells
template<class Visit>
std::int64_t for_each_cell_in_turn(const ImageInfo& image, const DeformedBody& body, Visit&& visit) {
  const double orientation = CellsAtRest(image, *body.specimen).orientation();
  std::vector<std::pair<Index3, CellMap>> folded;
  for_each_deformed_cell(image, body, [&](std::int64_t, const Index3& at, const Corners& corners) {
    const CellMap map(corners);
    if (!map.is_folded(orientation))
      visit(at, corners, map);
    else
      folded.emplace_back(at, map);
  });
  for (const auto& [at, map] : folded)
    visit(at, corners_of(map), map);
  return static_cast<std::int64_t>(folded.size());
}

} // namespace maille::warping
