#include "elastic/masked/matter_cell.hpp"

namespace maille::deform {

namespace {

/// The two axes of a shear, in the order yz xz xy.
constexpr int pairs[3][2] = {{1, 2}, {0, 2}, {0, 1}};

} // namespace

CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind, const Vec3& spacing, const Vec3& scale,
                                 double unit) {
  double length[6]; // a strain is a sum of differences over 4 of it
  for (std::size_t a = 0; a < 3; ++a) {
    length[a] = spacing[a] * scale[a];
    const auto b = static_cast<std::size_t>(pairs[a][0]), c = static_cast<std::size_t>(pairs[a][1]);
    length[3 + a] = spacing[b] * scale[c];
  }
  CellCoefficients coefficients{};
  for (int p = 0; p < 6; ++p)
    for (int q = p; q < 6; ++q)
      coefficients[static_cast<std::size_t>(mean_coefficient(p, q))] =
          kind.mean(p, q) / (16 * length[p] * length[q] * unit);
  for (std::size_t a = 0; a < 3; ++a) {
    coefficients[MatterOperator::twist + a] = kind.shear[a] / (4 * length[3 + a] * length[3 + a] * unit);
    coefficients[MatterOperator::edge + a] = kind.edge[a] / (scale[a] * scale[a] * unit);
  }
  return coefficients;
}

CellMatrix cell_matrix(const CellCoefficients& c) {
  Eigen::Matrix<double, 9, 24> B = Eigen::Matrix<double, 9, 24>::Zero(); // strains and twists
  for (int corner = 0; corner < 8; ++corner) {
    const double side[3] = {corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0};
    for (int a = 0; a < 3; ++a) {
      const int i = pairs[a][0], j = pairs[a][1];
      B(a, 3 * corner + a) = side[a];
      B(3 + a, 3 * corner + i) = side[j];
      B(3 + a, 3 * corner + j) = side[i];
      B(6 + a, 3 * corner + i) = side[j] * side[a];
      B(6 + a, 3 * corner + j) = side[i] * side[a];
    }
  }
  Eigen::Matrix<double, 9, 9> C = Eigen::Matrix<double, 9, 9>::Zero();
  for (int p = 0; p < 6; ++p)
    for (int q = 0; q < 6; ++q)
      C(p, q) = c[static_cast<std::size_t>(mean_coefficient(p, q))];
  for (int a = 0; a < 3; ++a)
    C(6 + a, 6 + a) = c[static_cast<std::size_t>(MatterOperator::twist + a)];
  CellMatrix K = B.transpose() * (C * B).eval();
  for (int a = 0; a < 3; ++a)
    for (int corner = 0; corner < 8; ++corner)
      if (!(corner & 1 << a)) {
        const int i = 3 * corner + a, j = 3 * (corner | 1 << a) + a;
        const double edge = c[static_cast<std::size_t>(MatterOperator::edge + a)];
        K(i, i) += edge;
        K(j, j) += edge;
        K(i, j) -= edge;
        K(j, i) -= edge;
      }
  return K;
}

} // namespace maille::deform
