#pragma once
/// Volume ratio of a deformed cell.

#include "maille/scene/answer.hpp"

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace maille {

/// Volume of a deformed cell over its volume at rest: the mean of det F by Gauss quadrature with two points
/// per axis, which is exact for multilinear hexahedra.
class VolumeRatio {
public:
  explicit VolumeRatio(const Grid& grid) : grid_(grid) {
    const int d = grid.dimension(), n = grid.corners_per_cell();
    const double near = (1 + 1 / std::sqrt(3.0)) / 2; // weight of the nearer end of an edge
    for (int point = 0; point < n; ++point) {
      auto& gradient = of_shape_[point];
      for (int corner = 0; corner < n; ++corner)
        for (int a = 0; a < d; ++a) {
          double slope = (corner >> a & 1 ? 1 : -1) / grid.spacing()[a];
          for (int b = 0; b < d; ++b)
            slope *= b == a ? 1 : (corner ^ point) >> b & 1 ? 1 - near : near;
          gradient(corner, a) = slope;
        }
    }
  }

  /// @param u  displacement of a cell's corners: `Vec3 u(node, cell)`
  template<class Corners>
  requires std::is_invocable_r_v<Vec3, const Corners&, std::int64_t, std::int64_t>
  double operator()(const Corners& u, std::int64_t cell) const {
    const int d = grid_.dimension(), n = grid_.corners_per_cell();
    const Index3 at = grid_.cell_at(cell);
    Eigen::Matrix<double, 3, 8> of_corners = Eigen::Matrix<double, 3, 8>::Zero();
    const Vec3 first = u(grid_.corner(at, 0), cell);
    for (int corner = 1; corner < n; ++corner) {
      const Vec3 of = u(grid_.corner(at, corner), cell);
      for (std::size_t b = 0; b < static_cast<std::size_t>(d); ++b)
        of_corners(static_cast<int>(b), corner) = of[b] - first[b];
    }
    double sum = 0;
    for (int point = 0; point < n; ++point)
      sum += (Eigen::Matrix3d::Identity() + of_corners * of_shape_[point]).determinant();
    return sum / n;
  }

private:
  using Gradients = Eigen::Matrix<double, 8, 3>;

  const Grid& grid_;
  std::array<Gradients, 8> of_shape_ = [] {
    std::array<Gradients, 8> zeros;
    zeros.fill(Gradients::Zero());
    return zeros;
  }();
};

} // namespace maille
