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

/// Hessian of a cell's energy (LatticeElasticity's documentation), by 3 corner + component. @param C in
/// Voigt's order [Pa]; @param h [m]
/// @param cells in a row along each axis: one or two cells bend as plates
inline Eigen::Matrix<long double, 24, 24> cell_hessian(const Matrix6& stiffness, const Vec3& h,
                                                       const Index3& cells) {
  using Real = long double;
  using Row = Eigen::Matrix<Real, 1, 24>;
  const Eigen::Matrix<Real, 6, 6> C = stiffness.cast<Real>(), S = C.inverse();
  const Real V = Real{h[0]} * h[1] * h[2];
  const int pairs[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  /// Mean of d u_b / d x_a over the four edges along a, or over two of them on a face.
  const auto slope = [&](int b, int a, int axis, int side) {
    Row row = Row::Zero();
    const Real share = axis < 0 ? 4 : 2;
    for (int corner = 0; corner < 8; ++corner)
      if (!(corner & 1 << a) && (axis < 0 || (corner >> axis & 1) == side)) {
        row[3 * (corner | 1 << a) + b] += 1 / (share * h[std::size_t(a)]);
        row[3 * corner + b] -= 1 / (share * h[std::size_t(a)]);
      }
    return row;
  };
  Eigen::Matrix<Real, 6, 24> B;
  for (int a = 0; a < 3; ++a)
    B.row(a) = slope(a, a, -1, 0);
  for (int i = 0; i < 3; ++i)
    B.row(3 + i) = slope(pairs[i][0], pairs[i][1], -1, 0) + slope(pairs[i][1], pairs[i][0], -1, 0);
  Eigen::Matrix<Real, 6, 6> mean = C;
  for (int a = 0; a < 3; ++a)
    mean(a, a) -= 1 / (3 * S(a, a));
  Eigen::Matrix<Real, 24, 24> K = V * (B.transpose() * (mean * B).eval());
  for (int a = 0; a < 3; ++a)
    for (int corner = 0; corner < 8; ++corner)
      if (!(corner & 1 << a)) {
        Row edge = Row::Zero();
        edge[3 * (corner | 1 << a) + a] = 1 / Real{h[std::size_t(a)]};
        edge[3 * corner + a] = -edge[3 * (corner | 1 << a) + a];
        K += V / (12 * S(a, a)) * edge.transpose() * edge;
      }
  for (int i = 0; i < 3; ++i) {
    const auto& [a, b] = pairs[i];
    const Row jump = slope(a, b, i, 1) + slope(b, a, i, 1) - slope(a, b, i, 0) - slope(b, a, i, 0);
    K += V / (12 * S(3 + i, 3 + i)) * jump.transpose() * jump;
    if (cells[std::size_t(i)] > 2)
      continue;
    Eigen::Matrix<Real, 3, 24> faces;
    faces << slope(a, a, i, 1) - slope(a, a, i, 0), slope(b, b, i, 1) - slope(b, b, i, 0), jump;
    Eigen::Matrix<Real, 3, 3> across;
    across << S(a, a), S(a, b), S(a, 3 + i), S(a, b), S(b, b), S(b, 3 + i), S(a, 3 + i), S(b, 3 + i),
        S(3 + i, 3 + i);
    Eigen::Matrix<Real, 3, 3> beyond = across.inverse();
    for (int k = 0; k < 3; ++k)
      beyond(k, k) -= 1 / across(k, k);
    K += V / 12 * (faces.transpose() * (beyond * faces).eval());
  }
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
