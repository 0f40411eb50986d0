#pragma once
/// Inner loop of FiniteElasticity's tangent: forces of cells for a change of their displacement.
///
/// With dH the change of the mean gradient, dh that of what lies beyond it, and P = A dH the mean part, a
/// cell pulls by
///
///   dP = A dH + dh f^T + h df^T,  dq = dH f + F df,  w' = F^T dh + dH^T h,  df = K w',
///
/// where h and f = K F^T h are those of the state. A is symmetric, K sparse. States that take neither h nor f
/// (Convexity::positive) have zeros in their place.
///
/// Numbers are float32 and lie row by row of cells, number after number, so that vectors hold cells beside
/// each other; sums are float64. Every cell is computed alike in vectors of any length.

#include <cstdint>
#include <utility>

namespace maille::deform {

/// Row and column, i <= j, of an entry of K that is not zero: 3 k + component of CellModes::beyond_modes.
using BeyondPair = std::pair<std::uint8_t, std::uint8_t>;

/// Places of a cell's numbers, after the upper triangle of A, row after row [N m].
template<int dimension>
struct TangentNumbers {
  static constexpr int d = dimension, n_beyond = (1 << d) - 1 - d;
  static constexpr int F = d * d * (d * d + 1) / 2;         ///< by columns
  static constexpr int h = F + d * d, f = h + d * n_beyond; ///< mode after mode [m], [N]
  static constexpr int K = f + d * n_beyond;                ///< of every BeyondPair [N/m]
};

/// Cells of matter along x that follow one another.
struct TangentRun {
  int dimension = 3, cells = 0;
  const float* numbers = nullptr; ///< number k of cell x is at [k row + x]
  std::int64_t row = 0;
  const BeyondPair* pairs = nullptr;
  int n_pairs = 0;
  double per_length[3] = {}; ///< 1 over the spacing [1/m]
  // Pointers to the first cell's first node, by component; distances to the other corners of a cell.
  const double* u[3] = {};
  double* forces[3] = {};
  std::int64_t corner[8] = {};
};

/// forces += the tangent times u.
void add_tangent_forces(const TangentRun& run);

} // namespace maille::deform
