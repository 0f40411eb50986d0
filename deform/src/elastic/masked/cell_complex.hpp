#pragma once
/// Which cells of a grid hold matter and which vertices they share, and the same on coarser grids.

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

/// What a place in a piece has of the piece's vertices: by halves of its sides, x + 3 y + 9 z, each 0 to 2.
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
  /// Only where cells share a face: what hangs together by an edge or a corner, a hinge, may still turn on
  /// coarser grids
  faces,
  places ///< wherever they lie in the same or neighbouring cells, as on a grid without holes
};

struct Coarsened {
  CellComplex complex;
  List<std::int32_t> cell_of; ///< per fine cell
  Weights interpolation;      ///< of fine vertices from coarse ones; where asked for so, of hinges alone
  /// Per fine vertex: places_of_piece times the number of its piece, and its place in that. -1 at
  /// hinges, and of no cell.
  List<std::int32_t> place;
  /// Per fine vertex: whether it takes the mean of pieces that are not joined there, else it is one's own.
  List<std::uint8_t> is_hinge;
};

/// Twice the spacing. Every coarse cell is a piece of the matter in 2 x 2 x 2 cells; its eight vertices are
/// its own, but for those that it shares with the pieces that it is joined to. A vertex interpolates linearly
/// in every piece that it belongs to; where they are joined that is the same, at hinges it takes the mean. So
/// on the coarse grid pieces move by themselves, and the energy of the hinge between them is in the matrix.
///
/// The same for any number of threads. @pre cells come plane after plane
Coarsened coarsen(const CellComplex& fine, Joining joining, ThreadTeam& team, bool of_hinges_alone = false);

} // namespace maille::deform
