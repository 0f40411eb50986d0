#pragma once
/// Data from assembly for the linear solvers, and the scale of their residuals.

#include "maille/base/grid.hpp"

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <vector>

namespace maille::fem_ref {

/// The stiffness matrix without prescribed unknowns: their rows and columns have only a diagonal entry.
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
/// @param all   size with forces at prescribed nodes too. If holds carry all loads, the forces at free nodes
/// are rounding and give no scale
inline double residual_size(double free, double all) {
  constexpr double rounding = 1e-9; // forces below this part of all forces are rounding of larger sums
  return std::max(free, rounding * all);
}

/// Subtracts the mean from a cell's displacement (dim * node + component). A translation costs no force, but
/// its rounding matters for cells that move a thousand times as far as they deform.
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
