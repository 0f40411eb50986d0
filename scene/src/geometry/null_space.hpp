#pragma once
/// What is left of a small vector space as one linear condition after another is laid on it.

#include <Eigen/Core>

namespace maille {

/// Starts as all of R^n. Keeps an orthonormal basis (columns).
class NullSpace {
public:
  explicit NullSpace(Eigen::Index n) : basis_(Eigen::MatrixXd::Identity(n, n)) {}

  Eigen::Index dimension() const { return basis_.cols(); }
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// Keeps the vectors v with row . v = 0. A row that earlier ones imply to 1e-9 changes nothing.
  /// @param row entries of the order of one before any cancellation, so that a row of rounding errors shows
  ///        as such
  void forbid(const Eigen::VectorXd& row);

private:
  Eigen::MatrixXd basis_;
};

/// The same space with as many zeros as can be had: reduced row echelon form, one vector a row, pivots first
/// in the order of the columns.
Eigen::MatrixXd echelon(const Eigen::MatrixXd& basis);

} // namespace maille
