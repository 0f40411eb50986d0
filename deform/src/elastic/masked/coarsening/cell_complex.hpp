#pragma once
/// Cells of matter and the vertices that they share, and how they are coarsened.
///
/// Scheme    the finest complex has the cells of a grid that hold matter. A coarser one has a cell, called a
///           piece, for each connected part of the matter in a block of 2 x 2 x 2 cells. Pieces that touch
///           only at an edge or a corner keep separate vertices there: a hinge.
/// Exact     linear displacements of every piece are interpolated exactly.

#include "maille/base/arena.hpp"
#include "maille/base/grid.hpp"
#include "parallel/thread_team.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace maille::deform {

/// A cell and its corners, by bits x y z. On coarser grids several cells may lie in one place, and several
/// vertices too: pieces of matter that are not joined there.
struct ComplexCell {
  Index3 at{};
  std::int32_t vertex[8] = {};
};

struct CellComplex {
  List<ComplexCell> cells;
  std::int32_t n_vertices = 0;
};

/// Rows of sparse weights.
struct Weights {
  List<std::int32_t> first; ///< per row, and the end
  List<std::int32_t> column;
  List<float> weight;

  std::int32_t n_rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
  /// Rows and columns exchanged; entries of a row in ascending order.
  Weights transposed(std::int32_t n_columns) const;
};

/// Weights of a place in a piece on the eight vertices of the piece. A place counts half sides from the
/// lowest corner: x + 3 y + 9 z, each 0 to 2.
struct PlaceWeights {
  int size = 0;
  int corner[8] = {}; ///< ascending
  float weight[8] = {};
};
constexpr std::array<PlaceWeights, 27> weights_of_places() {
  std::array<PlaceWeights, 27> all{};
  for (int place = 0; place < static_cast<int>(all.size()); ++place)
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1;
      for (int a = 0, halves = place; a < 3; ++a, halves /= 3)
        weight *= 0.5F * static_cast<float>((corner >> a & 1) != 0 ? halves % 3 : 2 - halves % 3);
      if (weight > 0) {
        PlaceWeights& of = all[place];
        of.corner[of.size] = corner;
        of.weight[of.size++] = weight;
      }
    }
  return all;
}
inline constexpr auto place_weights = weights_of_places();
inline constexpr auto places_of_piece = static_cast<int>(place_weights.size());

/// How pieces of matter are joined when a grid is coarsened.
enum class Joining {
  /// Where cells share a face. Parts that share only an edge or a corner stay separate, so that the hinge
  /// between them can still turn on coarser grids.
  faces,
  places ///< where they lie in the same or neighbouring cells, as on a grid without holes
};

struct Coarsened {
  CellComplex complex;
  List<std::int32_t> cell_of; ///< per fine cell
  Weights interpolation;      ///< of fine vertices from coarse ones; of hinges alone if requested
  /// Per fine vertex: places_of_piece times the number of its piece, plus its place in the piece; -1 at
  /// hinges and where no cell is.
  List<std::int32_t> place;
  /// Per fine vertex: 1 if it takes the mean of several pieces that are not joined there.
  List<std::uint8_t> is_hinge;
};

/// Coarsens to twice the spacing. Every coarse cell is a piece of the matter in 2 x 2 x 2 cells and has eight
/// vertices, which it shares with the pieces that it is joined to. A fine vertex is interpolated linearly in
/// each of its pieces: joined pieces give the same value, and a hinge takes the mean of the values. So pieces
/// move independently on the coarse grid, and the matrix holds the energy of the hinge between them.
///
/// Same result for any number of threads. @pre cells are in the order of planes
Coarsened coarsen(const CellComplex& fine, Joining joining, ThreadTeam& team, bool of_hinges_alone = false);

} // namespace maille::deform
