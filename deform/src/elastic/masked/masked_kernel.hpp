#pragma once
/// Inner loops on bodies of any shape, compiled for every vector instruction set: the cell operator, and
/// loops over the entries of float32 fields.

#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/lattice_kernel.hpp"

#include <cstdint>
#include <span>

namespace maille::deform {

/// Float32 operator of the finest grid, for displacements times the spacing of their axis over the unit of
/// length, which removes the spacing from all loops.
///
/// Coefficients of a cell: 21 of the mean strain (upper triangle of 6 x 6, strains in the order of the
/// scene), 3 of its twists, 3 of its edges, and where some cell of the body is thin 6 of bending across every
/// axis (upper triangle of 3 x 3); all 0 where there is no matter.
struct MaskedOperator {
  enum Coefficient : int { mean = 0, twist = 21, edge = 24, bending = 27, most_coefficients = 45 };
  static constexpr int coefficients_of(bool bends) { return bends ? most_coefficients : bending; }
  /// [coefficient][kind] if `kind` is set; else [block of cells][coefficient][cell], run after run, with as
  /// many coefficients as the run needs.
  const float* coefficients = nullptr;
  const std::uint8_t* kind = nullptr; ///< per slot of cells, padded by a block; 0: no matter
  const std::uint8_t* block_kind =
      nullptr; ///< per block of cells: the kind of all its matter, 0 if they differ
  std::int32_t n_kinds = 0;
  bool couples_all = false; ///< strains of different kinds, as fibres do that are turned out of the axes
  std::int64_t component_stride = 0;
};

/// forces += A u of the cells of some runs, in their order.
void add_matter_forces(const MaskedOperator& A, std::span<const CellRun> runs, const float* u, float* forces);

/// Numbers of a column that one pass of add_columns() takes.
inline constexpr std::int64_t column_part = 32;
/// sum += columns times c, for n contiguous columns of `size` numbers. @pre size is a multiple of column_part
void add_columns(std::int64_t size, int n, const float* columns, const double* c, double* sum);

/// Start of the eigenvalue iteration: f is -1 or 1 in units of the diagonal, the same on every machine, and 0
/// where components are fixed. @param first number of the entry at which inverse and f start
void noise_entries(std::int64_t n, std::int64_t first, const float* inverse, float* f);
/// Loops over n entries, a multiple of 16 unless stated otherwise. `inverse` is that of the diagonal, 0 where
/// a component is fixed. u = weight f / diagonal
void start_entries(std::int64_t n, float weight, const float* inverse, const float* f, float* u);
/// u += weight (f - Au) / diagonal
void relax_entries(std::int64_t n, float weight, const float* inverse, const float* f, const float* Au,
                   float* u);
/// Au = u + weight (f - Au) / diagonal, for any n. The second one returns f . Au.
void step_from_entries(std::int64_t n, float weight, const float* inverse, const float* f, const float* u,
                       float* Au);
double step_and_dot_entries(std::int64_t n, float weight, const float* inverse, const float* f,
                            const float* u, float* Au);
/// Au = f - Au where nodes may move, 0 elsewhere; for any n
void subtract_entries(std::int64_t n, const float* inverse, const float* f, float* Au);
/// Ap = 0 where nodes may not move; for any n. @return p . Ap
double mask_and_dot_entries(std::int64_t n, const float* inverse, const float* p, float* Ap);
double dot_entries(std::int64_t n, const float* a, const float* b);
/// p = v + beta p
void direct_entries(std::int64_t n, const float* v, float beta, float* p);
/// u = of_a a + of_u u
void combine_entries(std::int64_t n, float of_a, const float* a, float of_u, float* u);
/// r -= step q
void step_entries(std::int64_t n, float step, const float* q, float* r);

} // namespace maille::deform
