#include "elastic/masked/coarse_operator.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/piece_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstdint>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every number of a
// product is summed by the same operations in the same order, whatever the length of vectors.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, block_stride>;
using VF = hn::VFromD<F>;
using Line = hn::CappedTag<float, 8>;
constexpr int column_size = static_cast<int>(PatternedPieces::column_size);
constexpr int n_lines = column_size / static_cast<int>(hn::MaxLanes(Line()));

/// Pieces that one pass multiplies, so that they share the loads of their matrix.
constexpr int most_at_once = 3;

using Forces = hn::VFromD<Line>[n_lines];

/// Forces at the vertices of pieces of one pattern, three numbers each, from four numbers a vertex of u.
template<int n>
HWY_INLINE void multiply(const float* matrix, const PatternedPiece* const* pieces, const float* u,
                         Forces* forces) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < n; ++i)
    for (int line = 0; line < n_lines; ++line)
      forces[i][line] = hn::Zero(d);
  for (int k = 0; k < 8; ++k) {
    const float* of_vertex[n];
    for (int i = 0; i < n; ++i)
      of_vertex[i] = u + std::int64_t{block_stride} * pieces[i]->vertex[k];
    for (int c = 0; c < 3; ++c) {
      const float* const column = matrix + (3 * k + c) * column_size;
      hn::VFromD<Line> lines[n_lines];
      for (int line = 0; line < n_lines; ++line)
        lines[line] = hn::Load(d, column + line * lanes);
      for (int i = 0; i < n; ++i) {
        const auto factor = hn::Set(d, of_vertex[i][c]);
        for (int line = 0; line < n_lines; ++line)
          forces[i][line] = hn::MulAdd(lines[line], factor, forces[i][line]);
      }
    }
  }
}

HWY_INLINE void add_to(float* at, VF value) {
  hn::StoreU(hn::Add(hn::LoadU(F(), at), value), F(), at);
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void add_to_vertices(const hn::VFromD<Line>* forces, const PatternedPiece& piece, float* out) {
  for (int k = 0; k < 8; ++k)
    for (int c = 0; c < 3; ++c)
      add_to(out + std::int64_t{block_stride} * piece.vertex[k] + c, forces[3 * k + c]);
}
#else
/// The unused fourth number of a vertex overlaps the next vertex. Vectors stay in registers, because a load
/// across two that were just stored stalls.
HWY_INLINE void add_to_vertices(const hn::VFromD<Line>* forces, const PatternedPiece& piece, float* out) {
  const F d;
  VF four[6];
  for (int i = 0; i < 6; ++i)
#if HWY_MAX_BYTES >= 32
    four[i] = i % 2 == 0 ? hn::LowerHalf(d, forces[i / 2]) : hn::UpperHalf(d, forces[i / 2]);
#else
    four[i] = forces[i];
#endif
  const auto at = [&](int k) HWY_ATTR { return out + std::int64_t{block_stride} * piece.vertex[k]; };
  add_to(at(0), four[0]);
  add_to(at(1), hn::CombineShiftRightBytes<12>(d, four[1], four[0]));
  add_to(at(2), hn::CombineShiftRightBytes<8>(d, four[2], four[1]));
  add_to(at(3), hn::CombineShiftRightBytes<4>(d, four[3], four[2]));
  add_to(at(4), four[3]);
  add_to(at(5), hn::CombineShiftRightBytes<12>(d, four[4], four[3]));
  add_to(at(6), hn::CombineShiftRightBytes<8>(d, four[5], four[4]));
  add_to(at(7), hn::CombineShiftRightBytes<4>(d, four[5], four[5]));
}
#endif

template<int n>
HWY_INLINE void add_product(const float* matrix, const PatternedPiece* const* pieces, const float* u,
                            float* out) {
  Forces forces[n];
  multiply<n>(matrix, pieces, u, forces);
  for (int i = 0; i < n; ++i)
    add_to_vertices(forces[i], *pieces[i], out);
}

/// @param numbers of pieces, grouped by pattern
void add(const float* matrices, const PatternedPiece* pieces, const std::int32_t* numbers, std::size_t size,
         const float* u, float* out) {
  for (std::size_t first = 0, end = 0; first < size; first = end) {
    const std::int32_t pattern = pieces[numbers[first]].pattern;
    if (pattern == PatternedPiece::no_pattern)
      return;
    const PatternedPiece* at_once[most_at_once];
    int n = 0;
    for (; n < most_at_once && end < size && pieces[numbers[end]].pattern == pattern; ++n, ++end)
      at_once[n] = pieces + numbers[end];
    const float* const matrix =
        matrices + std::int64_t{pattern} * static_cast<std::int64_t>(PatternedPieces::matrix_size);
    if (n == 3)
      add_product<3>(matrix, at_once, u, out);
    else if (n == 2)
      add_product<2>(matrix, at_once, u, out);
    else
      add_product<1>(matrix, at_once, u, out);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add);

void add_pieces(const PatternedPieces& all, std::size_t first, std::size_t end, const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(add)
  (all.matrices.data(), all.pieces.data(), all.by_pattern.data() + first, end - first, u, out);
}

} // namespace maille::deform
#endif
