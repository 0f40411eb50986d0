#pragma once
/// What assembly hands to the linear solvers.

#include "maille/scene/grid.hpp"

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <vector>

namespace maille::fem_ref {

/// The stiffness matrix with the prescribed unknowns taken out: their rows and columns hold a diagonal only.
struct LinearSystem {
  int dimension = 0; ///< unknowns per node: unknown = dimension * node + component
  int degree = 0;
  std::int64_t longest = 0;        ///< nodes along the longest axis of the grid
  std::vector<Vec3> positions;     ///< of the nodes [m]
  dealii::SparsityPattern pattern; // before the matrix, which points to it
  dealii::SparseMatrix<double> matrix;
  dealii::AffineConstraints<double> constraints; ///< to zero

  std::int64_t n() const { return dimension * static_cast<std::int64_t>(positions.size()); }
  /// Unknowns that are not prescribed.
  std::int64_t n_free() const { return n() - static_cast<std::int64_t>(constraints.n_constraints()); }
  std::int64_t n_entries() const { return static_cast<std::int64_t>(pattern.n_nonzero_elements()); }
  /// Counted from the arrays.
  std::int64_t bytes() const;
};

} // namespace maille::fem_ref
