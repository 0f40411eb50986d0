#pragma once
/// Sparse matrices of 3 x 3 blocks: the operators of coarser grids.

#include "elastic/masked/cell_complex.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>

namespace maille::deform {

/// Symmetric. Blocks of a row have columns in ascending order, and hold their three columns one after
/// another.
struct BlockMatrix {
  List<std::int32_t> first; ///< per row, and the end
  List<std::int32_t> column;
  AlignedArray<float> blocks; ///< nine numbers each, and one line of padding

  std::int32_t n_rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
};

/// The same in half the bytes: numbers of 16 bits (IEEE 754's binary16), each times the scale of its row.
/// That is a power of 2, so numbers that mirror one another are rounded alike, by 2^-11 of themselves at
/// most.
struct RoundedBlockMatrix {
  List<std::int32_t> first, column;
  List<float> scale; ///< per row
  /// The first eight numbers of each block, which fill a vector, and the last ones; some of padding.
  AlignedArray<std::uint16_t> blocks, last;

  std::int32_t n_rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
};
/// Takes first and column out of A, whose numbers stay.
RoundedBlockMatrix rounded(BlockMatrix& A, ThreadTeam& team);

/// P^T A P.
BlockMatrix galerkin_product(const BlockMatrix& A, const Weights& P, const Weights& P_transposed,
                             ThreadTeam& team);

/// A + B, of equally many rows, with a block wherever one of them has one.
BlockMatrix sum_of(const BlockMatrix& A, const BlockMatrix& B);

/// Fields have four numbers for each row: three components, and one that does not count.
inline constexpr int block_stride = 4;

/// Loops over the rows from `first` on, for every kind of vector that the machine may have; `inverse` of the
/// diagonal, 0 where nothing is to be moved.
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
/// Rounds n blocks over `unit`, a power of 2, to 16 bits: the first eight numbers of each, and the last ones.
void round_blocks(const float* blocks, std::int32_t n, float unit, std::uint16_t* eight, std::uint16_t* last);
/// out = sum of weights times entries of u, or that added to it
void interpolate_blocks(const Weights& P, std::int32_t first, std::int32_t end, const float* u, bool adds,
                        float* out);

} // namespace maille::deform
