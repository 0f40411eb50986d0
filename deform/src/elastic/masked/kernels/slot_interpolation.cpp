#include "elastic/masked/slot_interpolation.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/slot_interpolation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <utility>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Vectors hold the
// components of one vertex or slot, in the same order of sums on every machine and any number of threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, block_stride>;
using VF = hn::VFromD<F>;

/// Calls visit(vertex, weight) for the weights of a slot. @param place not `nowhere`
template<class Visit>
HWY_INLINE void for_each_weight(std::int32_t place, const PatternedPiece* pieces, const Weights& hinges,
                                const Visit& visit) {
  if (place >= 0) {
    const PatternedPiece& piece = pieces[place / places_of_piece];
    const PlaceWeights& of = place_weights.data()[place % places_of_piece];
    for (int i = 0; i < of.size; ++i)
      visit(piece.vertex[of.corner[i]], of.weight[i]);
    return;
  }
  const std::int32_t hinge = -2 - place;
  for (std::int32_t i = hinges.first.data()[hinge]; i < hinges.first.data()[hinge + 1]; ++i)
    visit(hinges.column.data()[i], hinges.weight.data()[i]);
}

/// Interpolates as many slots at once as a vector has numbers; the values of vertices are transposed to the
/// layout of the finest fields.
void interpolate(const std::int32_t* place, const PatternedPiece* pieces, const Weights& hinges,
                 std::int32_t first, std::int32_t end, const float* u, const float* inverse,
                 std::int64_t stride, float* out) {
  const F d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  alignas(16) float sums[block_stride * block_stride];
  for (std::int32_t slot = first; slot < end; slot += lanes) {
    bool is_anywhere = false;
    for (int i = 0; i < lanes; ++i) {
      const std::int32_t at = place[slot + i];
      is_anywhere = is_anywhere || at != -1;
      for (int part = 0; part < block_stride; part += lanes) {
        VF sum = hn::Zero(d);
        if (at != -1)
          for_each_weight(at, pieces, hinges, [&](std::int32_t vertex, float weight) HWY_ATTR {
            sum = hn::MulAdd(hn::Set(d, weight), hn::LoadU(d, u + std::int64_t{block_stride} * vertex + part),
                             sum);
          });
        hn::StoreU(sum, d, sums + block_stride * i + part);
      }
    }
    if (!is_anywhere)
      continue;
    VF of[3], unused;
    hn::LoadInterleaved4(d, sums, of[0], of[1], of[2], unused);
    for (int c = 0; c < 3; ++c) {
      const std::int64_t at = c * stride + slot;
      const VF before = hn::LoadU(d, out + at);
      const auto may_move = hn::Gt(hn::LoadU(d, inverse + at), hn::Zero(d));
      hn::StoreU(hn::IfThenElse(may_move, hn::Add(before, of[c]), before), d, out + at);
    }
  }
}

void add_up(const std::int32_t* place, const PatternedPiece* pieces, const Weights& hinges,
            std::int32_t first, std::int32_t end, const float* f, std::int64_t stride, float* vertices) {
  const F d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  alignas(16) float forces[block_stride * block_stride];
  for (std::int32_t slot = first; slot < end; slot += lanes) {
    const float* const at_slot = f + slot; // reads beyond the slot; the rest is ignored
    hn::StoreInterleaved4(hn::LoadU(d, at_slot), hn::LoadU(d, at_slot + stride),
                          hn::LoadU(d, at_slot + 2 * stride), hn::Zero(d), d, forces);
    for (int i = 0; i < std::min(lanes, end - slot); ++i) {
      const std::int32_t at = place[slot + i];
      if (at == -1)
        continue;
      for (int part = 0; part < block_stride; part += lanes) {
        const VF of_slot = hn::Load(d, forces + block_stride * i + part);
        for_each_weight(at, pieces, hinges, [&](std::int32_t vertex, float weight) HWY_ATTR {
          float* const to = vertices + std::int64_t{block_stride} * vertex + part;
          hn::StoreU(hn::MulAdd(hn::Set(d, weight), of_slot, hn::LoadU(d, to)), d, to);
        });
      }
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(interpolate);
HWY_EXPORT(add_up);

SlotInterpolation::SlotInterpolation(Coarsened& coarsened) : place_(std::move(coarsened.place)) {
  const Weights P = std::exchange(coarsened.interpolation, {});
  hinges_.first.push_back(0);
  for (std::size_t slot = 0; slot < place_.size(); ++slot) {
    if (coarsened.is_hinge[slot] == 0)
      continue;
    place_[slot] = nowhere - hinges_.n_rows() - 1;
    hinges_.column.insert(hinges_.column.end(), P.column.begin() + P.first[slot],
                          P.column.begin() + P.first[slot + 1]);
    hinges_.weight.insert(hinges_.weight.end(), P.weight.begin() + P.first[slot],
                          P.weight.begin() + P.first[slot + 1]);
    hinges_.first.push_back(static_cast<std::int32_t>(hinges_.column.size()));
  }
  hinges_.first.shrink_to_fit(); // stored as long as the hierarchy
  hinges_.column.shrink_to_fit();
  hinges_.weight.shrink_to_fit();
}

Weights SlotInterpolation::rows_of(const BlockMatrix& S, const List<PatternedPiece>& pieces) const {
  Weights rows;
  rows.first.reserve(place_.size() + 1);
  rows.first.push_back(0);
  for (std::size_t slot = 0; slot < place_.size(); ++slot) {
    if (S.first[slot] < S.first[slot + 1] && place_[slot] != nowhere)
      HWY_STATIC_DISPATCH(for_each_weight)
    (place_[slot], pieces.data(), hinges_, [&](std::int32_t vertex, float weight) {
      rows.column.push_back(vertex);
      rows.weight.push_back(weight);
    });
    rows.first.push_back(static_cast<std::int32_t>(rows.column.size()));
  }
  return rows;
}

void SlotInterpolation::interpolate(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end,
                                    const float* u, const float* inverse, std::int64_t stride,
                                    float* out) const {
  HWY_DYNAMIC_DISPATCH(interpolate)
  (place_.data(), pieces.data(), hinges_, first, end, u, inverse, stride, out);
}

void SlotInterpolation::add_up(const List<PatternedPiece>& pieces, std::int32_t first, std::int32_t end,
                               const float* f, std::int64_t stride, float* vertices) const {
  HWY_DYNAMIC_DISPATCH(add_up)(place_.data(), pieces.data(), hinges_, first, end, f, stride, vertices);
}

} // namespace maille::deform
#endif
