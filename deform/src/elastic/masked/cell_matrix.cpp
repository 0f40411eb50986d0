#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace maille::deform {

namespace {

/// The two axes of a shear, in the order yz xz xy.
constexpr int pairs[3][2] = {{1, 2}, {0, 2}, {0, 1}};

/// Place of a pair of a plate's three curvatures across axis a. @pre p <= q
constexpr std::size_t bending_coefficient(std::size_t a, int p, int q) {
  return MaskedOperator::bending + 6 * a + static_cast<std::size_t>(p * 3 - p * (p - 1) / 2 + q - p);
}

} // namespace

CellCoefficients coefficient_factors(const Vec3& spacing, const Vec3& scale, double unit) {
  double length[6]; // a strain is a sum of differences over 4 of it
  for (std::size_t a = 0; a < 3; ++a) {
    length[a] = spacing[a] * scale[a];
    const auto b = static_cast<std::size_t>(pairs[a][0]), c = static_cast<std::size_t>(pairs[a][1]);
    length[3 + a] = spacing[b] * scale[c];
  }
  CellCoefficients factors{};
  for (int p = 0; p < 6; ++p)
    for (int q = p; q < 6; ++q)
      factors[mean_coefficient(p, q)] = 1 / (16 * length[p] * length[q] * unit);
  for (std::size_t a = 0; a < 3; ++a) {
    factors[MaskedOperator::twist + a] = 1 / (4 * length[3 + a] * length[3 + a] * unit);
    factors[MaskedOperator::edge + a] = 1 / (scale[a] * scale[a] * unit);
    const double along[3] = {length[(a + 1) % 3], length[(a + 2) % 3], length[3 + a]};
    for (int p = 0; p < 3; ++p)
      for (int q = p; q < 3; ++q)
        factors[bending_coefficient(a, p, q)] = 1 / (4 * along[p] * along[q] * unit);
  }
  return factors;
}

CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind, const CellCoefficients& factors) {
  CellCoefficients coefficients{};
  const auto set = [&](std::size_t at, double value) { coefficients[at] = factors[at] * value; };
  for (std::size_t k = 0; k < kind.mean.size(); ++k)
    set(MaskedOperator::mean + k, kind.mean[k]);
  for (std::size_t a = 0; a < 3; ++a) {
    set(MaskedOperator::twist + a, kind.shear[a]);
    set(MaskedOperator::edge + a, kind.edge[a]);
    for (int p = 0; p < 3 && kind.thin != 0; ++p)
      for (int q = p; q < 3; ++q)
        set(bending_coefficient(a, p, q), kind.bending[a](p, q));
  }
  return coefficients;
}

namespace {

/// The differences that one column (corner and component) of a cell contributes to, and their signs: its
/// normal strain, two shears, two twists, and the face differences across both other axes.
struct CellColumn {
  std::array<int, 3> strain{};
  std::array<double, 3> of_strain{};
  std::array<int, 2> across{}; ///< the other axes
  std::array<double, 2> of_twist{}, of_face{};
  std::array<int, 2>
      face{}; ///< its place among the three differences of that pair of faces; the twist is third
};

CellColumn cell_column(int corner, int component) {
  const auto side = [&](int axis) { return (corner >> axis & 1) != 0 ? 1.0 : -1.0; };
  CellColumn column;
  column.strain[0] = component;
  column.of_strain[0] = side(component);
  for (int i = 0; i < 2; ++i) {
    const int across = (component + 1 + i) % 3, other = 3 - component - across;
    const auto k = static_cast<std::size_t>(i);
    column.strain[k + 1] = 3 + across; // of the component and the other axis
    column.of_strain[k + 1] = side(other);
    column.across[k] = across;
    column.of_twist[k] = side(other) * side(across);
    column.of_face[k] = side(component) * side(across);
    column.face[k] = (across + 1) % 3 == component ? 0 : 1;
  }
  return column;
}

/// Generalised stresses of a unit displacement of one column, without edges.
struct CellPull {
  std::array<double, 6> strain{};
  std::array<double, 3> twist{};
  std::array<std::array<double, 2>, 3> face{};

  CellPull(const CellCoefficients& c, const CellColumn& column) {
    for (int p = 0; p < 6; ++p)
      for (std::size_t q = 0; q < 3; ++q)
        strain[p] += c[mean_coefficient(p, column.strain[q])] * column.of_strain[q];
    for (std::size_t q = 0; q < 2; ++q) {
      const auto a = static_cast<std::size_t>(column.across[q]);
      const int own = column.face[q];
      const double twist_of_face = c[bending_coefficient(a, own, 2)];
      twist[a] = (c[MaskedOperator::twist + a] + c[bending_coefficient(a, 2, 2)]) * column.of_twist[q] +
                 twist_of_face * column.of_face[q];
      for (int f = 0; f < 2; ++f)
        face[a][f] = c[bending_coefficient(a, std::min(f, own), std::max(f, own))] * column.of_face[q] +
                     c[bending_coefficient(a, f, 2)] * column.of_twist[q];
    }
  }
  /// The entry of the cell matrix for the other column.
  double at(const CellColumn& other) const {
    double sum = 0;
    for (std::size_t p = 0; p < 3; ++p)
      sum += other.of_strain[p] * strain[other.strain[p]];
    for (std::size_t p = 0; p < 2; ++p) {
      const auto a = static_cast<std::size_t>(other.across[p]);
      sum += other.of_twist[p] * twist[a] + other.of_face[p] * face[a][other.face[p]];
    }
    return sum;
  }
};

/// [3 corner + component]
std::array<CellColumn, 24> cell_columns() {
  std::array<CellColumn, 24> columns;
  for (int i = 0; i < 24; ++i)
    columns[i] = cell_column(i / 3, i % 3);
  return columns;
}

} // namespace

CellMatrix cell_matrix(const CellCoefficients& c) {
  static const std::array<CellColumn, 24> columns = cell_columns();
  CellMatrix K;
  for (int j = 0; j < 24; ++j) {
    const CellPull pull(c, columns[j]);
    for (int i = 0; i <= j; ++i)
      K(i, j) = K(j, i) = pull.at(columns[i]);
  }
  for (int a = 0; a < 3; ++a)
    for (int corner = 0; corner < 8; ++corner)
      if (!(corner & 1 << a)) {
        const int i = 3 * corner + a, j = 3 * (corner | 1 << a) + a;
        const double edge = c[MaskedOperator::edge + a];
        K(i, i) += edge;
        K(j, j) += edge;
        K(i, j) -= edge;
        K(j, i) -= edge;
      }
  return K;
}

namespace {

/// The 24 entries of the diagonal, rounded up.
constexpr std::size_t diagonal_size = column_part;

/// The diagonal is linear in the coefficients: its parts, one coefficient after another.
std::vector<float> diagonals_of_coefficients() {
  const std::array<CellColumn, 24> columns = cell_columns();
  std::vector<float> all(diagonal_size * MaskedOperator::most_coefficients, 0.0F);
  for (std::size_t k = 0; k < MaskedOperator::most_coefficients; ++k) {
    CellCoefficients one{};
    one[k] = 1;
    for (std::size_t i = 0; i < 24; ++i)
      all[diagonal_size * k + i] = static_cast<float>(CellPull(one, columns[i]).at(columns[i]) +
                                                      one[MaskedOperator::edge + i % 3]); // exact
  }
  return all;
}

} // namespace

CellDiagonal cell_diagonal(const CellCoefficients& c, bool bends) {
  static const std::vector<float> of_coefficients = diagonals_of_coefficients();
  std::array<double, diagonal_size> sum{};
  add_columns(diagonal_size, MaskedOperator::coefficients_of(bends), of_coefficients.data(), c.data(),
              sum.data());
  CellDiagonal diagonal;
  std::copy_n(sum.begin(), diagonal.size(), diagonal.begin());
  return diagonal;
}

} // namespace maille::deform
