#include "elastic/box/box_kernel.hpp"

#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/model/thin_cells.hpp"

#include <Eigen/LU>

#include <cmath>

namespace maille::deform {

namespace {

/// Place in the order 11 22 33 23 13 12 of the strain that holds the derivative of component i along a.
constexpr int row_of(int i, int a) {
  return i == a ? i : 6 - i - a;
}

bool couples_shears(const Eigen::Matrix<double, 6, 6>& C) {
  const double rounding = 1e-12 * C.cwiseAbs().maxCoeff();
  for (int p = 0; p < 6; ++p)
    for (int q = 3; q < 6; ++q)
      if (p != q && std::abs(C(p, q)) > rounding)
        return true;
  return false;
}

} // namespace

BoxCoefficients::BoxCoefficients(const Eigen::Matrix<double, 6, 6>& C, const Vec3& spacing, double unit,
                                 std::uint8_t thin)
    : is_aligned(!couples_shears(C)) {
  const auto h = [&](int a) { return spacing[a]; };
  const Eigen::Matrix<double, 6, 6> S = C.inverse();
  const double volume = h(0) * h(1) * h(2) / unit;
  Eigen::Matrix<double, 6, 6> mean = volume / 16 * C; // a mean of four edges, twice
  for (int a = 0; a < 3; ++a) {
    mean(a, a) -= LatticeElasticity::alpha * volume / 16 / S(a, a);
    edge[a] = LatticeElasticity::alpha * volume / S(a, a) / (h(a) * h(a)); // E holds the 1 / 4
  }
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      for (int j = 0; j < 3; ++j)
        for (int b = 0; b < 3; ++b)
          strain[i][a][j][b] = mean(row_of(i, a), row_of(j, b)) / (h(a) * h(b));
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const double twist = volume / 48 / S(3 + c, 3 + c); // 1 / 12, and two means of two
    twist_self[a] += twist / (h(b) * h(b));
    twist_self[b] += twist / (h(a) * h(a));
    twist_pair[c] = twist / (h(a) * h(b));
    bends[c] = (thin >> c & 1) != 0;
    if (!bends[c])
      continue;
    const Eigen::Matrix3d beyond = volume / 48 * bending_beyond_links(S, c);
    const auto row = [a](int i, int p) { return i != p ? 2 : i == a ? 0 : 1; }; // aa, bb, ab
    for (const int i : {a, b})
      for (const int p : {a, b})
        for (const int j : {a, b})
          for (const int q : {a, b})
            bending[c][i][p][j][q] = beyond(row(i, p), row(j, q)) / (h(p) * h(q));
  }
}

} // namespace maille::deform
