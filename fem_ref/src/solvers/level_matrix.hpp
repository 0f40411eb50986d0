#pragma once
/// The stiffness of one multigrid level as a matrix of float32, for comparison with CellOperator.

#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <memory>
#include <span>
#include <vector>

namespace maille::fem_ref {

/// Same constructor, members and sense as CellOperator<dim, float>.
template<int dim>
class LevelMatrix : public dealii::Subscriptor {
public:
  using value_type = float;
  using Vector = dealii::LinearAlgebra::distributed::Vector<float>;

  LevelMatrix(const std::vector<float>& K, const std::vector<unsigned>& nodes, std::vector<unsigned> fixed,
              std::size_t n_unknowns);

  void vmult(Vector& to, const Vector& from) const { matrix_.vmult(to, from); }
  void Tvmult(Vector& to, const Vector& from) const { matrix_.vmult(to, from); }
  std::size_t m() const { return matrix_.m(); }
  std::size_t n() const { return matrix_.n(); }
  float el(std::size_t i, std::size_t j) const {
    return matrix_.el(static_cast<unsigned>(i), static_cast<unsigned>(j));
  }
  void initialize_dof_vector(Vector& vector) const { vector.reinit(matrix_.m()); }
  Vector inverse_diagonal() const;
  std::span<const unsigned> fixed() const { return fixed_; }
  std::int64_t bytes() const;

private:
  std::vector<unsigned> fixed_;
  dealii::SparsityPattern pattern_; // before the matrix, which points to it
  dealii::SparseMatrix<float> matrix_;
};

} // namespace maille::fem_ref
