#pragma once
/// Inner loop of LatticeElasticity, compiled for every vector instruction set.

#include <cstdint>

namespace maille::deform {

/// Place of a pair of strains among the 21 numbers of a symmetric matrix: the upper triangle, row after row.
constexpr int mean_coefficient(int p, int q) {
  return p <= q ? p * 6 - p * (p - 1) / 2 + q - p : mean_coefficient(q, p);
}

/// Cells that a kernel processes at once, so that their forces stay in the first cache.
inline constexpr int most_cells = 64;

/// Cells along x that follow one another, of one matter without thin axes, in 3D.
struct LatticeRun {
  int cells = 0;
  const double* mean = nullptr; ///< see LatticeElasticity::Kind
  const double* edge = nullptr;
  const double* shear = nullptr;
  double per_length[3] = {}; ///< 1 over the spacing [1/m]
  // Pointers to the first cell's first node, by component; distances to the next nodes along y and z.
  const double* u[3] = {};
  double* forces[3] = {};
  std::int64_t next_y = 0, next_z = 0;
};

/// forces += the forces at the corners of the cells.
void add_run_forces(const LatticeRun& run);

} // namespace maille::deform
