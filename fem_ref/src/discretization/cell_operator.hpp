#pragma once
/// The stiffness of a body of congruent cells of one material, applied from the element's one matrix.

#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <span>
#include <vector>

namespace maille::fem_ref {

/// Cells that are multiplied at once: the lanes of `x` and `y`.
constexpr int cells_per_batch = 16;

/// y = K x for a batch of cells.
/// @param K symmetric, n x n
/// @param x,y n rows of cells_per_batch lanes each, one lane a cell
/// Source  Kronbichler and Kormann (2012), vectorisation over cells; here the cells share one element matrix
void multiply(const float* K, int n, const float* x, float* y);
void multiply(const double* K, int n, const double* x, double* y);

/// What deal.II's smoothers, CG and multigrid ask of a matrix: rows and columns of fixed unknowns are empty.
///
/// Cost   n_cells (n_unknowns^2 multiplications, 3 n_unknowns reads and writes); bytes: 4 for every node of
///        every cell
/// Bits   of CPUs with and without fused multiplication differ in the last place
template<int dim, class Number>
class CellOperator : public dealii::Subscriptor {
public:
  using value_type = Number;
  using Vector = dealii::LinearAlgebra::distributed::Vector<Number>;

  /// @param K       element matrix, row dim * node + component
  /// @param nodes   for every node of every cell its unknown of component 0; the others follow it
  /// @param fixed   unknowns
  CellOperator(std::vector<Number> K, std::vector<unsigned> nodes, std::vector<unsigned> fixed,
               std::size_t n_unknowns);

  void vmult(Vector& to, const Vector& from) const;
  void Tvmult(Vector& to, const Vector& from) const { vmult(to, from); }
  std::size_t m() const { return n_; }
  std::size_t n() const { return n_; }
  Number el(std::size_t, std::size_t) const;
  void initialize_dof_vector(Vector& vector) const { vector.reinit(static_cast<unsigned>(n_)); }
  /// 1 over the diagonal; 0 where fixed.
  Vector inverse_diagonal() const;
  std::span<const unsigned> fixed() const { return fixed_; }
  std::int64_t bytes() const;

private:
  int n_rows_ = 0; ///< of the element's matrix
  std::vector<Number> K_;
  std::vector<unsigned> nodes_, fixed_;
  std::size_t n_ = 0;
};

} // namespace maille::fem_ref
