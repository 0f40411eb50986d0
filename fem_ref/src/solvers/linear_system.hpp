#pragma once
/// What assembly hands to the linear solvers, and what their residuals are measured by.

#include "maille/base/grid.hpp"

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
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

/// @param free  size of the forces at free nodes before they move
/// @param all   the same with those at nodes that are prescribed. Where holds carry all that pulls, what is
///              left at free nodes is rounding, and no measure
inline double residual_size(double free, double all) {
  constexpr double rounding =
      1e-9; // forces that are less than this part of all are what sums of larger ones leave
  return std::max(free, rounding * all);
}

/// Takes the mean out of a cell's displacement (dim * node + component). It costs no force, but where a cell
/// moves a thousand times as far as it deforms, its rounding would.
template<int dim>
void take_out_shift(dealii::Vector<double>& of_cell) {
  for (unsigned c = 0; c < dim; ++c) {
    double sum = 0;
    for (unsigned i = c; i < of_cell.size(); i += dim)
      sum += of_cell[i];
    const double mean = sum * dim / of_cell.size();
    for (unsigned i = c; i < of_cell.size(); i += dim)
      of_cell[i] -= mean;
  }
}

} // namespace maille::fem_ref
