#include "patch_weights.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace maille {

namespace {

/// Factor on the weight of a cell that is not at the node, per axis along which it is not.
constexpr double weight_of_outer = 0.1;
/// Regularisation of the moments of quadratic terms, which are at least 2.6 in a full patch.
constexpr double damping = 0.05;

int place(int bit, int axis) {
  return bit >> (2 * axis) & 3;
}

/// Pseudo-inverse of a positive semidefinite matrix.
Eigen::Matrix3d inverse_where_any(const Eigen::Matrix3d& matrix) {
  constexpr double rounding = 1e-9;
  if (const Eigen::LLT<Eigen::Matrix3d> factor(matrix); factor.info() == Eigen::Success) {
    const Eigen::Matrix3d inverse = factor.solve(Eigen::Matrix3d::Identity());
    if (inverse.norm() * rounding < 1)
      return inverse;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of(matrix);
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (of.eigenvalues()[k] > rounding)
      inverse += of.eigenvectors().col(k) * of.eigenvectors().col(k).transpose() / of.eigenvalues()[k];
  return inverse;
}

} // namespace

PatchWeights::PatchWeights(int dimension) : dimension_(dimension) {
  const int cells = 1 << (2 * dimension);
  moments_.resize(cells / across);
  for (auto& row : moments_)
    row.fill(Moments::Zero());
  for (int bit = 0; bit < cells; ++bit) {
    const std::uint64_t one = std::uint64_t{1} << bit;
    bool is_at_node = true;
    double weight = 1;
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), mean_square = x;
    for (int axis = 0; axis < dimension; ++axis) {
      const int at = place(bit, axis);
      const bool is_inner = at == 1 || at == 2;
      const auto a = static_cast<std::size_t>(axis);
      x[axis] = at - 1.5;
      mean_square[axis] = x[axis] * x[axis] + 1.0 / 12;
      weight *= is_inner ? 1 : weight_of_outer;
      is_at_node = is_at_node && is_inner;
      not_first_[a] |= at > 0 ? one : 0;
      not_last_[a] |= at < across - 1 ? one : 0;
    }
    at_node_ |= is_at_node ? one : 0;
    Coefficients means;
    means << 1, x, mean_square[0], x[0] * x[1], x[0] * x[2], mean_square[1], x[1] * x[2], mean_square[2];
    weighted_.push_back(weight * means);
    auto& row = moments_[bit / across];
    for (std::size_t there = 0; there < row.size(); ++there)
      if (there >> (bit % across) & 1)
        row[there] += weight * means * means.transpose();
  }
}

std::uint64_t PatchWeights::joined(std::uint64_t cells) const {
  std::uint64_t reached = cells & at_node_;
  for (std::uint64_t before = 0; before != reached;) {
    before = reached;
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension_); ++axis) {
      const int step = 1 << (2 * axis);
      reached |= ((reached & not_last_[axis]) << step | (reached & not_first_[axis]) >> step) & cells;
    }
  }
  return reached;
}

const PatchWeights::Coefficients& PatchWeights::of(std::uint64_t patch) {
  const auto [found, is_new] = known_.try_emplace(patch);
  if (is_new)
    found->second = fit(patch);
  return found->second;
}

/// Orthogonalises linear, then quadratic terms against the lower degrees, in sums over the cells; their
/// contributions to the value at the node are then independent.
PatchWeights::Coefficients PatchWeights::fit(std::uint64_t patch) const {
  Moments sums = Moments::Zero();
  for (std::size_t row = 0; row < moments_.size(); ++row)
    sums += moments_[row][patch >> (across * row) & 15];
  Eigen::Matrix<double, monomials, 3> slopes = Eigen::Matrix<double, monomials, 3>::Zero();
  slopes.middleRows<3>(1).setIdentity();
  slopes.row(0) = -sums.block<1, 3>(0, 1) / sums(0, 0);
  const Eigen::Matrix<double, monomials, 3> sums_of_slopes = sums * slopes;
  const Eigen::Matrix3d of_slopes = inverse_where_any(sums_of_slopes.middleRows<3>(1));
  Eigen::Matrix<double, monomials, 6> squares = Eigen::Matrix<double, monomials, 6>::Zero();
  squares.bottomRows<6>().setIdentity();
  squares.row(0) = -sums.block<1, 6>(0, 4) / sums(0, 0);
  squares -= slopes * (of_slopes * sums_of_slopes.bottomRows<6>().transpose());
  Eigen::Matrix<double, 6, 6> of_squares = (sums * squares).bottomRows<6>();
  of_squares.diagonal().array() += damping;
  return Coefficients::Unit(0) / sums(0, 0) + slopes * (of_slopes * slopes.row(0).transpose()) +
         squares * of_squares.llt().solve(squares.row(0).transpose());
}

} // namespace maille
