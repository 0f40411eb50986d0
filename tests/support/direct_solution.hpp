#pragma once
/// Reference solution of lattice elasticity: a factored matrix of the cells' energies.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include <array>
#include <map>
#include <numeric>
#include <vector>

namespace maille::test {

/// Energy of a cell as LatticeElasticity's documentation has it, term by term. @param C  stiffness in Voigt's
/// order [Pa] @param h  [m] @param cells  in a row along each axis: one or two cells bend as plates
/// @param value  displacement of a component at a corner
template<class Real, class Value>
Real cell_energy(int d, const Eigen::MatrixXd& stiffness, const Vec3& h, const Index3& cells,
                 const Value& value) {
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  const Matrix C = stiffness.cast<Real>(), S = C.inverse();
  const auto of = [](int a) { return std::size_t(a); };
  const int corners = 1 << d;
  Real volume = 1, total = 0;
  for (int a = 0; a < d; ++a)
    volume *= h[of(a)];
  /// Mean of d u_b / d x_a over the edges along a whose corners satisfy `is_in`.
  const auto slope = [&](int b, int a, auto is_in) {
    Real sum = 0;
    int n = 0;
    for (int corner = 0; corner < corners; ++corner)
      if (!(corner & 1 << a) && is_in(corner)) {
        sum += (value(b, corner | 1 << a) - value(b, corner)) / h[of(a)];
        ++n;
      }
    return Real(sum / n);
  };
  const auto everywhere = [](int) { return true; };
  Eigen::Matrix<Real, Eigen::Dynamic, 1> strain(C.rows());
  const int pairs[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  for (int a = 0; a < d; ++a)
    strain[a] = slope(a, a, everywhere);
  for (int row = d; row < C.rows(); ++row) {
    const auto& [a, b] = pairs[d == 2 ? 2 : row - 3];
    strain[row] = slope(a, b, everywhere) + slope(b, a, everywhere);
  }
  Matrix mean = C;
  for (int a = 0; a < d; ++a)
    mean(a, a) -= 1 / (3 * S(a, a));
  total += volume / 2 * strain.dot(mean * strain);
  for (int a = 0; a < d; ++a)
    for (int corner = 0; corner < corners; ++corner)
      if (!(corner & 1 << a)) {
        const Real e = (value(a, corner | 1 << a) - value(a, corner)) / h[of(a)];
        total += volume / (6 * (corners / 2)) / S(a, a) * e * e;
      }
  for (int pair = 0; d == 3 && pair < 3; ++pair) {
    const auto& [a, b] = pairs[pair];
    const auto upper = [&](int corner) { return (corner & 1 << pair) != 0; };
    const auto lower = [&](int corner) { return (corner & 1 << pair) == 0; };
    const Real jump = slope(a, b, upper) + slope(b, a, upper) - slope(a, b, lower) - slope(b, a, lower);
    total += volume / 24 / S(3 + pair, 3 + pair) * jump * jump;
    if (cells[of(pair)] > 2)
      continue;
    const int first = (pair + 1) % 3, second = (pair + 2) % 3;
    const Eigen::Matrix<Real, 3, 1> faces(slope(first, first, upper) - slope(first, first, lower),
                                          slope(second, second, upper) - slope(second, second, lower), jump);
    const std::array<int, 3> rows{first, second, 3 + pair};
    const Eigen::Matrix<Real, 3, 3> across = S(rows, rows);
    total += volume / 24 * faces.dot(Eigen::Matrix<Real, 3, 3>(across.inverse()) * faces);
    for (int i = 0; i < 3; ++i)
      total -= volume / 24 / across(i, i) * faces[i] * faces[i];
  }
  return total;
}

/// Hessian of the energy of a cell in 3D, by 3 corner + component.
inline Eigen::Matrix<long double, 24, 24> cell_hessian(const Matrix6& stiffness, const Vec3& h,
                                                       const Index3& cells) {
  const auto energy = [&](int i, int j) { // of unit displacements
    return cell_energy<long double>(3, stiffness, h, cells, [&](int b, int corner) {
      const int at = 3 * corner + b;
      return static_cast<long double>((at == i ? 1 : 0) + (at == j ? 1 : 0));
    });
  };
  Eigen::Matrix<long double, 24, 24> K;
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j <= i; ++j)
      K(i, j) = K(j, i) = i == j ? 2 * energy(i, -1) : energy(i, j) - energy(i, -1) - energy(j, -1);
  return K;
}

/// Number of connected cells in the row through a cell, along each axis.
inline Index3 cells_in_a_row(const Specimen& body, const Index3& at) {
  const auto is_matter = [&](const Index3& cell) {
    for (std::size_t a = 0; a < 3; ++a)
      if (cell[a] < 0 || cell[a] >= body.grid.cells()[a])
        return false;
    return body.is_matter(body.grid.cell(cell));
  };
  Index3 in_a_row{};
  for (std::size_t a = 0; a < 3; ++a) {
    Index3 low = at, high = at;
    while (is_matter(low))
      --low[a];
    while (is_matter(high))
      ++high[a];
    in_a_row[a] = high[a] - low[a] - 1;
  }
  return in_a_row;
}

/// Solution for a body of one material, by factorisation in long double: rounding in float64 would be as
/// large as the bending stiffness of a rod a thousand times as long as thick. Unknowns are numbered along the
/// longest axis, so that factors are banded. @pre the cells of the body are connected
inline Displacement direct_solution(const Scene& scene) {
  using Real = long double;
  using Matrix = Eigen::SparseMatrix<Real>;
  const Grid& grid = scene.specimen.grid;
  const Index3& nodes = grid.nodes();
  const auto n = std::size_t(grid.n_nodes());
  const auto longest = std::size_t(std::ranges::max_element(nodes) - nodes.begin());
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t node) { return grid.node_at(std::int64_t(node))[longest]; });
  Displacement u(grid);
  std::vector<int> number(3 * n, 0);
  for (const Prescribed& p : scene.prescribed) {
    number[3 * std::size_t(p.node) + std::size_t(p.component)] = -1;
    u(p.component, p.node) = p.value;
  }
  int unknowns = 0;
  for (const std::size_t node : order)
    for (std::size_t c = 0; c < 3; ++c)
      if (number[3 * node + c] == 0)
        number[3 * node + c] = scene.specimen.is_node(grid.node_at(std::int64_t(node))) ? unknowns++ : -1;
  Eigen::Matrix<Real, Eigen::Dynamic, 1> f = Eigen::Matrix<Real, Eigen::Dynamic, 1>::Zero(unknowns);
  for (int c = 0; c < 3; ++c) {
    const List<double> loads = nodal_forces(scene, c);
    for (std::size_t node = 0; node < loads.size(); ++node)
      if (const int row = number[3 * node + std::size_t(c)]; row >= 0)
        f[row] += loads[node];
  }
  std::map<Index3, Eigen::Matrix<Real, 24, 24>> hessians;
  std::vector<Eigen::Triplet<Real>> entries;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const Index3 in_a_row = cells_in_a_row(scene.specimen, grid.cell_at(cell));
    const auto [entry, is_new] = hessians.try_emplace(in_a_row);
    if (is_new)
      entry->second = cell_hessian(scene.object_stiffness(cell), grid.spacing(), in_a_row);
    const Eigen::Matrix<Real, 24, 24>& K = entry->second;
    std::array<std::int64_t, 8> corner;
    for (int k = 0; k < 8; ++k)
      corner[std::size_t(k)] = grid.corner(grid.cell_at(cell), k);
    for (int i = 0; i < 24; ++i) {
      const int row = number[3 * std::size_t(corner[std::size_t(i / 3)]) + std::size_t(i % 3)];
      for (int j = 0; j < 24 && row >= 0; ++j) {
        const std::int64_t other = corner[std::size_t(j / 3)];
        const int column = number[3 * std::size_t(other) + std::size_t(j % 3)];
        if (column < 0)
          f[row] -= K(i, j) * u(j % 3, other);
        else
          entries.emplace_back(row, column, K(i, j));
      }
    }
  }
  Matrix A(unknowns, unknowns);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factors(A);
  const Eigen::Matrix<Real, Eigen::Dynamic, 1> x = factors.solve(f);
  for (std::size_t node = 0; node < n; ++node)
    for (std::size_t c = 0; c < 3; ++c)
      if (const int i = number[3 * node + c]; i >= 0)
        u(c, node) = double(x[i]);
  return u;
}

} // namespace maille::test
