#pragma once
/// Galerkin products P^T K P, cell by cell: cells of each piece, matrices of pieces, and their sum as blocks.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/coarsening/cell_complex.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "parallel/thread_team.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

/// Rows and columns: 3 corner + component.
using CellMatrix = Eigen::Matrix<double, 24, 24>;
/// Rows and columns: 3 local vertex + component.
using PieceMatrix = Eigen::MatrixXd;

/// The coarse vertices that the fine vertices of a piece are interpolated from.
struct Piece {
  List<std::int32_t> vertices; ///< its own eight first
  std::int32_t local(std::int32_t vertex) const {
    return static_cast<std::int32_t>(std::ranges::find(vertices, vertex) - vertices.begin());
  }
};

/// Cuts pieces into slabs of `planes` planes: the first piece of each slab, and the end.
List<std::size_t> slabs_of(std::span<const std::int32_t> pieces, const List<ComplexCell>& cells, int planes);

/// The cells of each piece of a coarsened grid, and the sum of their matrices.
class PieceAssembly {
public:
  /// Planes of pieces per work item. Every second slab shares no row, not even at hinges.
  static constexpr int planes_per_slab = MaskedRows::planes_per_slab;

  /// Both must outlive this.
  PieceAssembly(const CellComplex& fine, const Coarsened& coarsened);

  std::size_t n_pieces() const { return coarsened_.complex.cells.size(); }
  std::span<const std::int32_t> cells_of(std::size_t piece) const {
    return std::span(cells_).subspan(first_[piece],
                                     static_cast<std::size_t>(first_[piece + 1] - first_[piece]));
  }
  Piece piece(std::size_t number) const;
  bool is_hinge(std::int32_t vertex) const { return coarsened_.is_hinge[vertex] != 0; }
  /// The octant of its piece that a cell lies in, by bits x y z.
  static std::size_t octant(const ComplexCell& cell) {
    return static_cast<std::size_t>(cell.at[0] % 2 + 2 * (cell.at[1] % 2) + 4 * (cell.at[2] % 2));
  }
  /// sum += P^T K P of a cell with any vertices, hinges included.
  void add_cell(const ComplexCell& cell, const CellMatrix& K, const Piece& piece, PieceMatrix& sum) const;
  /// K = P^T K P of a cell without hinges.
  static void take_to_piece(std::size_t octant, CellMatrix& K);

  /// Sum of `others` and the matrices of the pieces `numbers`, which ascend. @param matrix (number, Piece,
  /// memory) -> the piece's matrix, column by column; called on several threads
  template<class Matrix>
  BlockMatrix sum_of_pieces(std::span<const std::int32_t> numbers, ThreadTeam& team, const Matrix& matrix,
                            BlockMatrix others = {}) const;

private:
  const CellComplex& fine_;
  const Coarsened& coarsened_;
  List<std::int32_t> first_, cells_; ///< of pieces
};

/// An empty matrix with a block for each pair of vertices of a piece, plus the blocks of `others`.
BlockMatrix matrix_for(const List<Piece>& pieces, std::int32_t n_vertices, BlockMatrix others,
                       ThreadTeam& team);
/// Adds the matrix of a piece. @param local its columns, one after another @param order scratch memory
void add_piece(const Piece& piece, const double* local, std::vector<std::size_t>& order, BlockMatrix& matrix);

template<class Matrix>
BlockMatrix PieceAssembly::sum_of_pieces(std::span<const std::int32_t> numbers, ThreadTeam& team,
                                         const Matrix& matrix, BlockMatrix others) const {
  const List<std::size_t> slabs = slabs_of(numbers, coarsened_.complex.cells, planes_per_slab);
  List<Piece> pieces(numbers.size());
  for_slabs(slabs, team, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
      pieces[i] = piece(static_cast<std::size_t>(numbers[i]));
  });
  BlockMatrix sum = matrix_for(pieces, coarsened_.complex.n_vertices, std::move(others), team);
  for_slabs(slabs, team, [&](std::size_t first, std::size_t end) {
    PieceMatrix memory;
    std::vector<std::size_t> order;
    for (std::size_t i = first; i < end; ++i)
      add_piece(pieces[i], matrix(static_cast<std::size_t>(numbers[i]), pieces[i], memory), order, sum);
  });
  return sum;
}

} // namespace maille::deform
