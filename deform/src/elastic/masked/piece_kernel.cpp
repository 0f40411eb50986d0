#include "elastic/masked/coarse_operator.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/piece_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every number of a
// product is summed by the same operations in the same order, whatever the length of vectors.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, block_stride>;
using Line = hn::CappedTag<float, 16>;
constexpr int column_size = static_cast<int>(PatternedPieces::column_size);
constexpr int n_lines = column_size / static_cast<int>(hn::MaxLanes(Line()));

/// forces = matrix times u, both with four numbers a vertex. Sums by component wait less for one another.
HWY_INLINE void multiply(const float* matrix, const float* u, float* forces) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  hn::VFromD<Line> sums[3][n_lines];
  for (int c = 0; c < 3; ++c)
    for (int line = 0; line < n_lines; ++line)
      sums[c][line] = hn::Mul(hn::Load(d, matrix + c * column_size + line * lanes), hn::Set(d, u[c]));
  for (int k = 1; k < 8; ++k)
    for (int c = 0; c < 3; ++c) {
      const auto factor = hn::Set(d, u[block_stride * k + c]);
      const float* const column = matrix + (3 * k + c) * column_size;
      for (int line = 0; line < n_lines; ++line)
        sums[c][line] = hn::MulAdd(hn::Load(d, column + line * lanes), factor, sums[c][line]);
    }
  for (int line = 0; line < n_lines; ++line)
    hn::Store(hn::Add(hn::Add(sums[0][line], sums[1][line]), sums[2][line]), d, forces + line * lanes);
}

void add(const float* matrices, const PatternedPiece* pieces, std::size_t n, const float* u, float* out) {
  const F d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float of_u[column_size], forces[column_size];
  for (std::size_t i = 0; i < n; ++i) {
    const PatternedPiece& piece = pieces[i];
    if (piece.pattern == PatternedPiece::no_pattern)
      continue;
    for (int k = 0; k < 8; ++k)
      for (int part = 0; part < block_stride; part += lanes)
        hn::StoreU(hn::LoadU(d, u + std::int64_t{block_stride} * piece.vertex[k] + part), d,
                   of_u + block_stride * k + part);
    multiply(matrices + std::int64_t{piece.pattern} * static_cast<std::int64_t>(PatternedPieces::matrix_size),
             of_u, forces);
    for (int k = 0; k < 8; ++k)
      for (int part = 0; part < block_stride; part += lanes) {
        float* const at = out + std::int64_t{block_stride} * piece.vertex[k] + part;
        hn::StoreU(hn::Add(hn::LoadU(d, at), hn::LoadU(d, forces + block_stride * k + part)), d, at);
      }
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add);

void add_pieces(const PatternedPieces& all, std::size_t first, std::size_t end, const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(add)(all.matrices.data(), all.pieces.data() + first, end - first, u, out);
}

} // namespace maille::deform
#endif
