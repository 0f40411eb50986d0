#pragma once
/// Sparse Cholesky factors, K = L L^T, of symmetric positive definite matrices in float64.
///
/// Two implementations. Eigen orders by approximate minimum degree and works column by column: best for
/// chains and small matrices, which have little fill. CHOLMOD orders by nested dissection (METIS) and works
/// on dense blocks of columns (supernodes): best for matrices with fill. CHOLMOD and its BLAS are in
/// maille-cholmod.so, which is opened for the first such factor.
///
/// The analysis orders the rows and predicts the cost; factor() computes the factor.
///
/// Source  Amestoy, Davis and Duff 1996 (minimum degree); Karypis and Kumar 1998 (nested dissection); Chen,
///         Davis, Hager and Rajamanickam 2008 (CHOLMOD)

#include "maille/plugins/open_plugin.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstdint>
#include <memory>
#include <span>

namespace maille {

/// A factor; the constructor analyses the pattern.
class SparseCholesky {
public:
  virtual ~SparseCholesky() = default;
  /// "CHOLMOD supernodal"
  virtual const char* name() const = 0;
  double n_numbers() const { return n_numbers_; }       ///< of the factor
  double n_operations() const { return n_operations_; } ///< sum of the squared numbers of its columns
  std::int64_t bytes() const { return bytes_; }         ///< of the factor and of its computation
  /// @param lower triangle, with the analysed pattern
  /// @return smallest over largest pivot; 0 if the matrix is not positive definite
  /// @throws std::bad_alloc; std::runtime_error if CHOLMOD fails otherwise
  virtual double factor(const Eigen::SparseMatrix<double>& lower) = 0;
  /// K^-1 right, within rounding, for each column; with CHOLMOD thirty take three times as long as one.
  /// @pre factor() returned more than 0
  virtual Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const = 0;

protected:
  double n_numbers_ = 0, n_operations_ = 0;
  std::int64_t bytes_ = 0;
};

/// By Eigen. @param lower triangle of the matrix
std::unique_ptr<SparseCholesky> simplicial_cholesky(const Eigen::SparseMatrix<double>& lower);
/// By CHOLMOD.
/// @param group of each row, from 0 without gaps, ascending: rows of a group are ordered together
/// @param blas_is_serial  one BLAS thread: the bits of OpenBLAS depend on the number of threads
/// @throws std::bad_alloc; std::runtime_error if maille-cholmod.so is missing
std::unique_ptr<SparseCholesky> supernodal_cholesky(const Eigen::SparseMatrix<double>& lower,
                                                    std::span<const std::int32_t> group, bool blas_is_serial);
/// By CHOLMOD if it is installed, else by Eigen.
std::unique_ptr<SparseCholesky> sparse_cholesky(const Eigen::SparseMatrix<double>& lower,
                                                std::span<const std::int32_t> group, bool blas_is_serial);

/// Return value of open_plugin for maille-cholmod.so: its supernodal_cholesky.
using SupernodalCholesky = decltype(supernodal_cholesky)*;
inline constexpr std::size_t cholmod_layout =
    layout_of<SupernodalCholesky, SparseCholesky, Eigen::SparseMatrix<double>, Eigen::MatrixXd>();

} // namespace maille
