#pragma once
/// What the forces that a solution leaves at free nodes are measured by.

#include <algorithm>
#include <deal.II/lac/vector.h>

namespace maille::fem_ref {

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
