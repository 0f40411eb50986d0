#include "geometry/null_space.hpp"

namespace maille {

void NullSpace::forbid(const Eigen::VectorXd& row) {
  const Eigen::Index k = basis_.cols();
  if (k == 0)
    return;
  Eigen::VectorXd v = basis_.transpose() * row;
  const double length = v.norm();
  if (length <= 1e-9)
    return;
  // The reflection that takes v to the last unit vector leaves k - 1 columns on which the row vanishes.
  v /= length;
  const double sign = v[k - 1] > 0 ? 1.0 : -1.0; // away from cancellation
  v[k - 1] += sign;
  const Eigen::MatrixXd reflected = basis_ - (basis_ * v) * (v.transpose() * (2.0 / v.squaredNorm()));
  basis_ = reflected.leftCols(k - 1);
}

Eigen::MatrixXd echelon(const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd rows = basis.transpose();
  Eigen::Index rank = 0;
  for (Eigen::Index column = 0; column < rows.cols() && rank < rows.rows(); ++column) {
    Eigen::Index pivot = 0;
    if (rows.col(column).tail(rows.rows() - rank).cwiseAbs().maxCoeff(&pivot) < 1e-8)
      continue;
    rows.row(rank).swap(rows.row(rank + pivot));
    rows.row(rank) /= rows(rank, column);
    for (Eigen::Index other = 0; other < rows.rows(); ++other)
      if (other != rank)
        rows.row(other) -= rows(other, column) * rows.row(rank);
    ++rank;
  }
  return rows.topRows(rank);
}

} // namespace maille
