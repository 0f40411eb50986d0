#pragma once
/// A Cholesky factor of a body's stiffness by CHOLMOD, in a shared object of its own, maille-cholmod.so, that
/// is opened when the first factor is made.

#include "maille/plugins/open_plugin.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstdint>
#include <memory>
#include <span>

namespace maille::deform {

/// Cholesky factor of a symmetric positive definite matrix.
class SupernodalFactor {
public:
  virtual ~SupernodalFactor() = default;
  /// Solves for each column of `forces`, within rounding: one column takes the time of reading the factor,
  /// thirty together three times as long.
  virtual Eigen::MatrixXd solve(const Eigen::MatrixXd& forces) const = 0;
};

/// Functions of the shared object.
struct CholmodFunctions {
  /// @param lower triangle of the matrix
  /// @param group of each row, from 0 on without gaps, in rising order: rows of a group have the same columns
  /// @param most  numbers that a factor may have
  /// @return null where it would have more, or the matrix is not positive definite
  /// @throws std::bad_alloc
  std::unique_ptr<SupernodalFactor> (*factor)(const Eigen::SparseMatrix<double>& lower,
                                              std::span<const std::int32_t> group, double most);
};

inline constexpr std::size_t cholmod_layout =
    layout_of<CholmodFunctions, SupernodalFactor, Eigen::SparseMatrix<double>, Eigen::MatrixXd>();

} // namespace maille::deform
