#pragma once
/// Compact interpolation of the finest grid from the first coarser one.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/coarsening/cell_complex.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>

namespace maille::deform {

/// Interpolation weights of the slots of a body, stored as one number a slot: its piece, and its place in the
/// piece, whose weights are tabulated (place_weights). Hinges have explicit weights.
///
/// Cost  4 bytes a slot; explicit weights take 8 bytes for each of 3 to 4 entries a node
class SlotInterpolation {
public:
  SlotInterpolation() = default;
  /// Moves the interpolation out of the coarsening of the body's own cells.
  explicit SlotInterpolation(Coarsened& coarsened);

  /// Weights of the rows that have blocks in S; other rows are empty.
  Weights rows_of(const BlockMatrix& S, const List<PatternedPiece>& pieces) const;
  /// out += P u at the slots whose `inverse` is not 0. u has four numbers a vertex; the components of out are
  /// `stride` apart. @pre first and end are multiples of block_stride
  void interpolate(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end, const float* u,
                   const float* inverse, std::int64_t stride, float* out) const;
  /// vertices += P^T f over the slots from `first` to `end`.
  void add_up(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end, const float* f,
              std::int64_t stride, float* vertices) const;

private:
  static constexpr std::int32_t nowhere = no_index; ///< no matter

  /// Per slot: Coarsened::place; hinges have numbers below `nowhere`, by rows of hinges_.
  List<std::int32_t> place_;
  Weights hinges_;
};

} // namespace maille::deform
