#include "world/surface/flexibility.hpp"

#include "elastic/model/lattice_elasticity.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include <cstdint>
#include <map>
#include <stdexcept>
#include <vector>

namespace maille::deform {

namespace {

/// The stiffness of one cell, from unit displacements of its corners.
template<int dimension>
Eigen::MatrixXd cell_stiffness(const LatticeElasticity& elasticity, std::int64_t cell) {
  constexpr int corners = 1 << dimension, n = dimension * corners;
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

/// Shifts and turns of all nodes, each of length 1 and across the others.
Eigen::MatrixXd rigid_motions(const Specimen& body, const std::vector<std::int64_t>& nodes) {
  const int d = body.grid.dimension();
  const auto n = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd places(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    places.col(i) =
        Eigen::Vector3d::Map(body.position(body.grid.node_at(nodes[static_cast<std::size_t>(i)])).data());
  places.colwise() -= places.rowwise().mean().eval();
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(d * n, d == 2 ? 3 : 6);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int a = 0; a < d; ++a) {
      motions(d * i + a, a) = 1;
      for (int turn = 0; turn < (d == 2 ? 1 : 3); ++turn) {
        const Eigen::Vector3d axis = Eigen::Vector3d::Unit(d == 2 ? 2 : turn);
        motions(d * i + a, d + turn) = axis.cross(Eigen::Vector3d(places.col(i)))[a];
      }
    }
  Eigen::HouseholderQR<Eigen::MatrixXd> factor(motions);
  return factor.householderQ() * Eigen::MatrixXd::Identity(motions.rows(), motions.cols());
}

} // namespace

Flexibility::Flexibility(const Scene& scene, const std::vector<std::int64_t>& fixed,
                         const Eigen::VectorXd& inertia, bool floats) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  const int d = grid.dimension(), corners = grid.corners_per_cell();
  std::vector<std::int64_t> number(static_cast<std::size_t>(grid.n_nodes()), -1);
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (body.is_node(grid.node_at(node))) {
      number[static_cast<std::size_t>(node)] = static_cast<std::int64_t>(nodes.size());
      nodes.push_back(node);
    }
  if (floats)
    rigid_ = rigid_motions(body, nodes);
  const LatticeElasticity elasticity(scene);
  std::map<std::int32_t, Eigen::MatrixXd> by_kind;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    auto [entry, is_new] = by_kind.try_emplace(elasticity.kind_number(cell));
    if (is_new)
      entry->second = d == 2 ? cell_stiffness<2>(elasticity, cell) : cell_stiffness<3>(elasticity, cell);
    const Eigen::MatrixXd& matrix = entry->second;
    const auto component = [&](int i) {
      return d * number[static_cast<std::size_t>(grid.corner(grid.cell_at(cell), i / d))] + i % d;
    };
    for (int column = 0; column < d * corners; ++column)
      for (int row = 0; row < d * corners; ++row)
        if (matrix(row, column) != 0)
          entries.emplace_back(static_cast<int>(component(row)), static_cast<int>(component(column)),
                               matrix(row, column));
  }
  const std::int64_t n = d * static_cast<std::int64_t>(nodes.size());
  stiffness_.resize(n, n);
  stiffness_.setFromTriplets(entries.begin(), entries.end());
  free_.assign(static_cast<std::size_t>(n), 0);
  for (const std::int64_t component : fixed)
    free_[static_cast<std::size_t>(component)] = -1;
  for (std::int64_t& place : free_)
    if (place >= 0)
      place = n_free_++;
  std::vector<Eigen::Triplet<double>> of_free;
  for (int column = 0; column < stiffness_.outerSize(); ++column)
    for (Sparse::InnerIterator entry(stiffness_, column); entry; ++entry)
      if (const std::int64_t row = free_[static_cast<std::size_t>(entry.row())],
          place = free_[static_cast<std::size_t>(column)];
          row >= 0 && place >= 0)
        of_free.emplace_back(static_cast<int>(row), static_cast<int>(place), entry.value());
  for (Eigen::Index component = 0; component < inertia.size(); ++component)
    if (const std::int64_t place = free_[static_cast<std::size_t>(component)]; place >= 0)
      of_free.emplace_back(static_cast<int>(place), static_cast<int>(place), inertia[component]);
  Sparse matrix(n_free_, n_free_);
  matrix.setFromTriplets(of_free.begin(), of_free.end());
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success)
    throw std::invalid_argument("Flexibility: a body that is held so that no rigid motion is left");
}

Eigen::VectorXd Flexibility::solve(const Eigen::VectorXd& forces) const {
  Eigen::VectorXd right(n_free_), whole = Eigen::VectorXd::Zero(forces.size());
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (free_[i] >= 0)
      right[free_[i]] = forces[static_cast<Eigen::Index>(i)];
  const Eigen::VectorXd solution = factor_.solve(right);
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (free_[i] >= 0)
      whole[static_cast<Eigen::Index>(i)] = solution[free_[i]];
  return whole;
}

const Eigen::VectorXd& Flexibility::column(std::int64_t component) {
  auto [entry, is_new] = columns_.try_emplace(component);
  if (is_new) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(n_components());
    if (rigid_.size() > 0) {
      unit[component] = 1;
      const Eigen::VectorXd balanced = unit - rigid_ * rigid_.row(component).transpose(),
                            found = solve(balanced);
      entry->second = found - rigid_ * (rigid_.transpose() * found);
    } else {
      if (!is_fixed(component))
        unit[component] = 1;
      entry->second = is_fixed(component) ? unit : solve(unit);
    }
  }
  return entry->second;
}

Eigen::VectorXd Flexibility::moved(const Eigen::VectorXd& prescribed) const {
  if (rigid_.size() > 0)
    return rigid_ * (rigid_.transpose() * prescribed);
  Eigen::VectorXd given = prescribed;
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (free_[i] >= 0)
      given[static_cast<Eigen::Index>(i)] = 0;
  if (given.isZero(0))
    return given;
  return given - solve(stiffness_ * given);
}

} // namespace maille::deform
