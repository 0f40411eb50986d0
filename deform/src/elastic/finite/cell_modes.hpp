#pragma once
/// The displacements of a cell's corners as Walsh functions: a mean, a mean gradient, and the rest.
///
/// Column m of `modes` is the part that is odd along the axes of the bits of m. Column 0 is the mean, those
/// of one bit are the mean gradient H (times half a spacing), the others lie beyond it: bending and twist.
/// Rows beyond the dimension are zero. The transform is exact, and its own inverse but for signs and a
/// factor.

#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/answer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace maille::deform {

template<int dimension>
struct CellModes {
  static constexpr int n = corners_of_cell<dimension>;
  static constexpr int n_beyond = std::max(1, n - 1 - dimension); ///< in 1D the mean, at which nothing pulls
  static constexpr std::array<int, 4> beyond_modes =
      dimension == 3 ? std::array{3, 5, 6, 7} : std::array{dimension == 2 ? 3 : 0, 0, 0, 0};
  using Modes = Eigen::Matrix<double, 3, n>;
  using Beyond = Eigen::Matrix<double, 3, n_beyond>;

  Modes modes, force; ///< [m]; of the energy by `modes` [N]
  Vec3 spacing;

  explicit CellModes(const Vec3& of_grid) : spacing(of_grid) {
    modes.setZero();
    force.setZero();
  }
  static void transform(double* values) {
    for (int half = 1; half < n; half *= 2)
      for (int i = 0; i < n; ++i)
        if ((i & half) == 0) {
          const double low = values[i], high = values[i | half];
          values[i] = high + low;
          values[i | half] = high - low;
        }
  }
  /// From the first corner on: a body carried far away keeps its digits.
  void gather(const Displacement& of_all, std::int64_t node, const std::array<std::int64_t, 8>& offset) {
    for (int b = 0; b < dimension; ++b) {
      const double* const from = of_all.component(b).data() + node;
      std::array<double, n> values;
      for (int corner = 0; corner < n; ++corner)
        values[corner] = from[offset[corner]] - from[0];
      transform(values.data());
      for (int m = 0; m < n; ++m)
        modes(b, m) = values[m] / n;
    }
  }
  /// Corner i is odd in mode m if an odd number of the bits of m are not in i; transform() uses that sign.
  void scatter(Displacement& of_all, std::int64_t node, const std::array<std::int64_t, 8>& offset) const {
    for (int b = 0; b < dimension; ++b) {
      double* const to = of_all.component(b).data() + node;
      std::array<double, n> values;
      for (int m = 0; m < n; ++m) // a mode's sign at a corner is that of the corner's transform in the mode
        values[m] = (std::popcount(static_cast<unsigned>(m)) % 2 != 0 ? -1 : 1) * force(b, m) / n;
      transform(values.data());
      for (int corner = 0; corner < n; ++corner)
        to[offset[corner]] +=
            (std::popcount(static_cast<unsigned>(corner)) % 2 != 0 ? -1 : 1) * values[corner];
    }
  }
  Eigen::Matrix3d mean_gradient() const {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (int a = 0; a < dimension; ++a)
      H.col(a) = 2 / spacing[a] * modes.col(1 << a);
    return H;
  }
  Beyond beyond() const {
    Beyond h;
    for (int k = 0; k < n_beyond; ++k)
      h.col(k) = modes.col(beyond_modes[k]);
    return h;
  }
  /// @param P of the energy by the mean gradient [N m]
  void set_force(const Eigen::Matrix3d& P, const Beyond& f) {
    for (int a = 0; a < dimension; ++a)
      force.col(1 << a) = 2 / spacing[a] * P.col(a);
    for (int k = 0; k < n_beyond; ++k)
      force.col(beyond_modes[k]) = f.col(k);
  }
};

} // namespace maille::deform
