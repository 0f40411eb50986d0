#pragma once
/// Matrix-free stiffness of a body of congruent cells of one material, by a single element matrix.

#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <span>
#include <vector>

namespace maille::fem_ref {

/// Number of cells per batch: the lanes of `x` and `y`.
constexpr int cells_per_batch = 16;

/// y = K x for a batch of cells.
/// @param K symmetric, n x n
/// @param x,y n rows of cells_per_batch lanes each, one lane a cell
/// Source  Kronbichler and Kormann (2012), vectorisation over cells; here the cells share one element matrix
void multiply(const float* K, int n, const float* x, float* y);
void multiply(const double* K, int n, const double* x, double* y);

/// Matrix interface for deal.II's smoothers, CG and multigrid; rows and columns of fixed unknowns are empty.
///
/// Cost   n_cells (n_unknowns^2 multiplications, 3 n_unknowns reads and writes); 4 bytes per node of every
///        cell
/// Bits   the last place differs between CPUs with and without fused multiply-add
template<int dim, class Number>
class CellOperator : public dealii::Subscriptor {
public:
  using value_type = Number;
  using Vector = dealii::LinearAlgebra::distributed::Vector<Number>;

  /// @param K       element matrix, row dim * node + component
  /// @param nodes   unknown of component 0 for every node of every cell; the other components follow
  /// @param fixed   fixed unknowns
  CellOperator(std::vector<Number> K, std::vector<unsigned> nodes, std::vector<unsigned> fixed,
               std::size_t n_unknowns);

  void vmult(Vector& to, const Vector& from) const;
  void Tvmult(Vector& to, const Vector& from) const { vmult(to, from); }
  std::size_t m() const { return n_; }
  std::size_t n() const { return n_; }
  Number el(std::size_t, std::size_t) const;
  void initialize_dof_vector(Vector& vector) const { vector.reinit(static_cast<unsigned>(n_)); }
  /// Reciprocal of the diagonal; 0 for fixed unknowns.
  Vector inverse_diagonal() const;
  std::span<const unsigned> fixed() const { return fixed_; }
  std::int64_t bytes() const;

private:
  int n_rows_ = 0; ///< rows of the element matrix
  std::vector<Number> K_;
  std::vector<unsigned> nodes_, fixed_;
  std::size_t n_ = 0;
};

} // namespace maille::fem_ref
