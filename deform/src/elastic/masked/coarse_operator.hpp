#pragma once
/// The operators of coarser grids: a matrix of blocks, or matrices of patterns that many pieces share.

#include "elastic/masked/block_matrix.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include "maille/base/arena.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace maille::deform {

/// Calls work(first row, end) for parts of n rows.
template<class Work>
void for_rows(std::int32_t n, ThreadTeam& team, Work&& work) {
  if (n < 4 * rows_per_item)
    work(0, n);
  else
    team.run((n + rows_per_item - 1) / rows_per_item,
             [&](int item, int) { work(item * rows_per_item, std::min(n, (item + 1) * rows_per_item)); });
}

/// Calls work(first, end) for slabs, as run_slabs() does.
template<class Work>
void for_slabs(const List<std::size_t>& first_of_slab, ThreadTeam& team, const Work& work) {
  run_slabs(team, static_cast<int>(first_of_slab.size()) - 1, [&](int slab) {
    const auto at = static_cast<std::size_t>(slab);
    work(first_of_slab[at], first_of_slab[at + 1]);
  });
}

/// A piece of matter, which is stiff between its eight vertices.
struct PatternedPiece {
  static constexpr std::int32_t no_pattern = no_index;
  std::int32_t vertex[8] = {};
  std::int32_t pattern = no_pattern; ///< whose matrix it has
};

/// A matrix takes 2 KB; a piece without a pattern takes 1 to 2 KB as blocks.
inline constexpr int fewest_pieces_of_a_pattern = 3;

/// Matrices of pieces where many are alike: those of one material have no more than 255.
struct PatternedPieces {
  /// A column holds the forces of a unit displacement of one vertex and component, in the order of vertices.
  static constexpr std::size_t column_size = 3 * std::extent_v<decltype(PatternedPiece::vertex)>,
                               matrix_size = column_size * column_size;
  List<PatternedPiece> pieces; ///< of all planes, one after another, whether they have patterns or not
  /// First piece of every slab of planes; every second slab shares no vertex.
  List<std::size_t> first_of_slab;
  /// Numbers of the pieces, slab by slab, sorted by pattern so that products find the matrix in the cache.
  /// Pieces without a pattern come last.
  List<std::int32_t> by_pattern;
  AlignedArray<float> matrices; ///< [pattern][column][row]

  /// Place of an entry in a matrix.
  static constexpr std::size_t place(std::size_t row, std::size_t column) {
    return column_size * column + row;
  }
  int n_slabs() const { return static_cast<int>(first_of_slab.size()) - 1; }
  void set_by_pattern(ThreadTeam& team);
};

/// out += matrices of the pieces at these places of by_pattern, times u. Compiled as apply_blocks().
void add_pieces(const PatternedPieces& all, std::size_t first, std::size_t end, const float* u, float* out);

/// A coarse operator: a matrix of blocks, plus the pieces that share patterns.
/// Same bits for any number of threads.
///
/// Cost  a piece of a known pattern has 36 bytes, and a vertex of it some 800 as blocks, 500 of them rounded
class CoarseOperator {
public:
  /// @param blocks of the pieces without a pattern, with a row for every vertex
  explicit CoarseOperator(BlockMatrix blocks, PatternedPieces pieces = {});

  std::int32_t n_rows() const { return is_rounded_ ? rounded_.n_rows() : blocks_.n_rows(); }
  bool has_pieces() const { return pieces_.matrices.size() > 0; }
  /// Blocks of the pieces without a pattern. @pre they were not rounded
  const BlockMatrix& blocks() const { return blocks_; }
  BlockMatrix& blocks() { return blocks_; }
  const PatternedPieces& pieces() const { return pieces_; }
  /// Rounds blocks to 16 bits; then restores the exact blocks, or frees them.
  void round(ThreadTeam& team);
  void undo_rounding();
  void forget_exact() { blocks_.blocks = {}; }
  /// Calls visit(blocks) with the stored representation.
  template<class Visit>
  void with_blocks(const Visit& visit) const {
    is_rounded_ ? visit(rounded_) : visit(blocks_);
  }
  /// block_stride numbers a row. @pre blocks were not rounded
  void copy_diagonal(AlignedArray<float>& to, ThreadTeam& team) const;
  /// out = A u
  void apply(const float* u, float* out, ThreadTeam& team) const;

private:
  template<class Work>
  void for_slabs_of_pieces(ThreadTeam& team, const Work& work) const;

  BlockMatrix blocks_;
  bool is_rounded_ = false;
  RoundedBlockMatrix rounded_; ///< blocks_, if so
  PatternedPieces pieces_;
};

} // namespace maille::deform
