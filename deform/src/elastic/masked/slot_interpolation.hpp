#pragma once
/// Interpolation of the body's own grid from the finest of the coarser ones, in few bytes.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/cell_complex.hpp"
#include "elastic/masked/coarse_operator.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>

namespace maille::deform {

/// What Weights say of the slots of a body, by one number for all but hinges: the piece that a node lies in,
/// and where in it, which has its weights from its eight vertices.
///
/// Cost  4 bytes a slot, where weights have 8 for each of 3 to 4 numbers of a node
class SlotInterpolation {
public:
  SlotInterpolation() = default;
  /// Takes the interpolation out of what the body's own cells were coarsened to.
  explicit SlotInterpolation(Coarsened& coarsened);

  /// The rows that have blocks in S, the others empty.
  Weights rows_of(const BlockMatrix& S, const List<PatternedPiece>& pieces) const;
  /// out += what slots have of u, four numbers a vertex, where `inverse` is not 0; out is component after
  /// component, `stride` apart. @pre first and end are multiples of block_stride
  void interpolate(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end, const float* u,
                   const float* inverse, std::int64_t stride, float* out) const;
  /// The transposed: vertices += what they take part in of f at slots.
  void add_up(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end, const float* f,
              std::int64_t stride, float* vertices) const;

private:
  static constexpr std::int32_t nowhere = no_index; ///< no matter

  /// Per slot: as Coarsened has it, and for hinges less than `nowhere`, by rows of hinges_.
  List<std::int32_t> place_;
  Weights hinges_;
};

} // namespace maille::deform
