#pragma once
/// One small dense matrix times many vectors at once, by the widest vectors that the processor has.

namespace maille::fem_ref {

/// Cells that are multiplied at once: the lanes of `x` and `y`.
constexpr int cells_per_batch = 16;

/// y = K x for a batch of cells.
/// @param K symmetric, n x n
/// @param x,y n rows of cells_per_batch lanes each, one lane a cell
/// Source  Kronbichler and Kormann (2012), vectorisation over cells; here the cells share one element matrix
void multiply(const float* K, int n, const float* x, float* y);
void multiply(const double* K, int n, const double* x, double* y);

} // namespace maille::fem_ref
