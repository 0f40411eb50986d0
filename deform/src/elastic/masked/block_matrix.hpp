#pragma once
/// Sparse matrices of 3 x 3 blocks: the operators of coarser grids.

#include "elastic/masked/coarsening/cell_complex.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>

namespace maille::deform {

/// A symmetric matrix. Columns of a row ascend; a block stores its three columns one after another.
struct BlockMatrix {
  List<std::int32_t> first; ///< per row, and the end
  List<std::int32_t> column;
  AlignedArray<float> blocks; ///< nine numbers each, and one line of padding

  std::int32_t n_rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
};

/// The same in half the bytes: binary16 numbers (IEEE 754) times a scale per row. The scale is a power of 2,
/// so symmetric entries round alike, by at most 2^-11 of their size.
struct RoundedBlockMatrix {
  List<std::int32_t> first, column;
  List<float> scale; ///< per row
  /// The first eight numbers of each block, which fill a vector, and the ninth ones, both padded.
  AlignedArray<std::uint16_t> blocks, last;

  std::int32_t n_rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
};
/// Moves `first` and `column` out of A; the numbers of A stay.
RoundedBlockMatrix rounded(BlockMatrix& A, ThreadTeam& team);

/// P^T A P.
BlockMatrix galerkin_product(const BlockMatrix& A, const Weights& P, const Weights& P_transposed,
                             ThreadTeam& team);

/// A + B. The result has a block where either matrix has one. @pre equal numbers of rows
BlockMatrix sum_of(const BlockMatrix& A, const BlockMatrix& B);

/// Numbers of a field per row: three components and an unused fourth.
inline constexpr int block_stride = 4;

/// Loops over the rows from `first` to `end`, compiled for every vector instruction set. `inverse` is that of
/// the diagonal, 0 where a component is fixed.
/// out = A u
void apply_blocks(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* u, float* out);
void apply_blocks(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* u,
                  float* out);
/// out = f - A u
void find_block_residual(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* f,
                         const float* u, float* out);
void find_block_residual(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* f,
                         const float* u, float* out);
/// next = u + weight (f - A u) / diagonal
void relax_blocks(const BlockMatrix& A, std::int32_t first, std::int32_t end, float weight,
                  const float* inverse, const float* f, const float* u, float* next);
void relax_blocks(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, float weight,
                  const float* inverse, const float* f, const float* u, float* next);
/// Divides n blocks by `unit`, a power of 2, and rounds them to 16 bits: eight numbers of each, then the
/// ninth.
void round_blocks(const float* blocks, std::int32_t n, float unit, std::uint16_t* eight, std::uint16_t* last);
/// out = P u, or out += P u
void interpolate_blocks(const Weights& P, std::int32_t first, std::int32_t end, const float* u, bool adds,
                        float* out);

} // namespace maille::deform
