#pragma once
/// Galerkin products cell by cell: what the pieces of a coarser grid are made of, and their sums as blocks.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/cell_complex.hpp"
#include "elastic/masked/coarse_operator.hpp"
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

/// Which coarse vertices the fine ones of a piece are interpolated from.
struct Piece {
  List<std::int32_t> vertices; ///< its own eight first
  std::int32_t local(std::int32_t vertex) const {
    return static_cast<std::int32_t>(std::ranges::find(vertices, vertex) - vertices.begin());
  }
};

/// Parts of pieces, in the order of planes: the first of each slab, and the end.
List<std::size_t> slabs_of(std::span<const std::int32_t> pieces, const List<ComplexCell>& cells, int planes);

/// For a coarsened grid: the cells of each piece, and how their matrices add up.
class PieceAssembly {
public:
  /// Planes of pieces that are added up in one go: those of every second slab share no row, not even at
  /// hinges.
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
  /// Which eighth of its piece a cell is, by bits x y z.
  static std::size_t octant(const ComplexCell& cell) {
    return static_cast<std::size_t>(cell.at[0] % 2 + 2 * (cell.at[1] % 2) + 4 * (cell.at[2] % 2));
  }
  /// sum += P^T K P, whatever its vertices are interpolated from.
  void add_cell(const ComplexCell& cell, const CellMatrix& K, const Piece& piece, PieceMatrix& sum) const;
  /// The same of a cell without hinges: K becomes P^T K P.
  static void take_to_piece(std::size_t octant, CellMatrix& K);

  /// The sum of the matrices of some pieces, in ascending order, and of others.
  /// @param matrix gives it the matrix of a piece, column after column: (number, Piece, memory) -> const
  ///        double*; from several threads
  template<class Matrix>
  BlockMatrix sum_of_pieces(std::span<const std::int32_t> numbers, ThreadTeam& team, const Matrix& matrix,
                            BlockMatrix others = {}) const;

private:
  const CellComplex& fine_;
  const Coarsened& coarsened_;
  List<std::int32_t> first_, cells_; ///< of pieces
};

/// Which blocks there are: pairs of vertices of one piece, and those of `others`, whose numbers they have.
BlockMatrix matrix_for(const List<Piece>& pieces, std::int32_t n_vertices, BlockMatrix others,
                       ThreadTeam& team);
/// @param local column after column @param order memory
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
