#include "elastic/model/stiffness_blocks.hpp"

#include <map>

namespace maille::deform {

template<int dimension>
Eigen::MatrixXd cell_stiffness(const LatticeElasticity& elasticity, std::int64_t cell) {
  constexpr int corners = corners_of_cell<dimension>, n = dimension * corners;
  Eigen::MatrixXd matrix(n, n);
  for (int column = 0; column < n; ++column) {
    Eigen::Matrix<double, 3, corners> u = Eigen::Matrix<double, 3, corners>::Zero();
    u(column % dimension, column / dimension) = 1;
    const Eigen::Matrix<double, 3, corners> force = elasticity.cell_forces<dimension>(cell, u);
    for (int row = 0; row < n; ++row)
      matrix(row, column) = force(row % dimension, row / dimension);
  }
  return matrix;
}

template Eigen::MatrixXd cell_stiffness<2>(const LatticeElasticity& elasticity, std::int64_t cell);
template Eigen::MatrixXd cell_stiffness<3>(const LatticeElasticity& elasticity, std::int64_t cell);

std::vector<std::int64_t> nodes_of_matter(const Specimen& body) {
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      nodes.push_back(node);
  return nodes;
}

StiffnessBlocks::StiffnessBlocks(const Specimen& body, const LatticeElasticity& elasticity,
                                 const std::vector<std::int64_t>& nodes)
    : grid_(body.grid), place_(static_cast<std::size_t>(grid_.n_nodes()), -1), rows_(nodes.size()) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place_[nodes[i]] = static_cast<std::int32_t>(i);
  const int d = grid_.dimension();
  std::map<std::int32_t, Eigen::MatrixXd> by_kind;
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    auto [entry, is_new] = by_kind.try_emplace(elasticity.kind_number(cell));
    if (is_new)
      entry->second = (d == 2 ? cell_stiffness<2>(elasticity, cell) : cell_stiffness<3>(elasticity, cell)) /
                      elasticity.weight(cell);
    const Index3 index = grid_.cell_at(cell);
    for (int near = 0; near < grid_.corners_per_cell(); ++near)
      for (int far = 0; far < grid_.corners_per_cell(); ++far) {
        const auto along = [&](int axis) { return ((far >> axis) & 1) - ((near >> axis) & 1); };
        const int after = along(0) + 3 * along(1) + 9 * along(2);
        if (after < 0)
          continue;
        Block& of_both = block(grid_.corner(index, near), after);
        of_both.node = place_[grid_.corner(index, far)];
        of_both.values.topLeftCorner(d, d) +=
            elasticity.weight(cell) * entry->second.block(d * far, d * near, d, d);
      }
  }
  for (const NodalSpring& spring : elasticity.springs())
    if (place_[spring.node] >= 0)
      block(spring.node, 0).values += spring.stiffness;
}

StiffnessBlocks::Block& StiffnessBlocks::block(std::int64_t near, int after) {
  return rows_[place_[near]][static_cast<std::size_t>(after)];
}

void StiffnessBlocks::add_spring(std::int64_t node, int axis, int component, double stiffness) {
  constexpr std::array<int, 3> next{1, 3, 9};
  block(node, 0).values(component, component) += stiffness;
  block(node + grid_.stride(axis), 0).values(component, component) += stiffness;
  block(node, next[axis]).values(component, component) -= stiffness;
}

Eigen::SparseMatrix<double> StiffnessBlocks::lower(const FixedMask& fixed,
                                                   std::vector<std::int32_t>* group) const {
  const auto d = static_cast<std::size_t>(grid_.dimension());
  std::vector<int> free(d * rows_.size(), -1);
  int n_free = 0, n_groups = 0;
  for (std::size_t node = 0; node < rows_.size(); ++node) {
    const int before = n_free;
    for (std::size_t b = 0; b < d; ++b)
      if (!fixed(b, node)) {
        free[d * node + b] = n_free++;
        if (group != nullptr)
          group->push_back(n_groups);
      }
    n_groups += n_free > before ? 1 : 0;
  }
  Eigen::SparseMatrix<double> matrix(n_free, n_free);
  matrix.reserve(static_cast<Eigen::Index>(n_free) * 3 * std::tuple_size_v<Row>);
  for (std::size_t column = 0; column < free.size(); ++column) {
    if (free[column] < 0)
      continue;
    matrix.startVec(free[column]);
    for (const Block& block : rows_[column / d])
      for (std::size_t b = 0; b < d && block.node >= 0; ++b) {
        const std::size_t row = d * static_cast<std::size_t>(block.node) + b;
        if (free[row] >= free[column])
          matrix.insertBack(free[row], free[column]) =
              block.values(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(column % d));
      }
  }
  matrix.finalize();
  return matrix;
}

} // namespace maille::deform
