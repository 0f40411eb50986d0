#include "world/occupancy/occupancy_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/occupancy/brick_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per vector instruction set; feasible/box/cone_kernel.cpp lists the restrictions.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<std::int32_t, 16>;

/// The words of a box's cells: `n` in each of `nz` slabs. A word holds two rows; one row of the first and of
/// the last word may be outside the box.
struct Words {
  std::uint32_t two_rows, of_first, of_last; ///< bits within the box: of all, first and last words
  int first, n, nz;

  HWY_INLINE explicit Words(const BrickBox& box) {
    const std::uint32_t row = (0xFFFFu >> (16 - box.nx)) << box.x;
    two_rows = row | row << 16;
    of_first = (box.y & 1) != 0 ? 0xFFFF0000u : ~0u;
    of_last = ((box.y + box.ny) & 1) != 0 ? 0xFFFFu : ~0u;
    first = (box.y >> 1) + 8 * box.z;
    n = ((box.y + box.ny + 1) >> 1) - (box.y >> 1);
    nz = box.nz;
  }
  HWY_INLINE std::uint32_t bits(int i) const {
    std::uint32_t bits = two_rows;
    bits &= i == 0 ? of_first : ~0u;
    bits &= i == n - 1 ? of_last : ~0u;
    return bits;
  }
};

/// Writes the numbers from `id` on to those of 16 cells whose bits are set. Numbers of the other cells may
/// wrap around; they are not written.
HWY_INLINE void number(std::int32_t* row, std::uint32_t bits, std::uint32_t id) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto lane = hn::Iota(d, 0), bit = hn::Shl(hn::Set(d, 1), lane);
  for (int x = 0; x < 16; x += lanes) {
    const auto has_bit = hn::TestBit(hn::Set(d, static_cast<std::int32_t>(bits >> x)), bit);
    hn::BlendedStore(hn::Add(lane, hn::Set(d, static_cast<std::int32_t>(id + static_cast<std::uint32_t>(x)))),
                     has_bit, d, row + x);
  }
}

std::int32_t put(const BrickBox& box, std::uint32_t* words, std::int32_t* ids) {
  const Words part(box);
  const auto row_step = static_cast<std::uint32_t>(box.row), slab_step = static_cast<std::uint32_t>(box.slab);
  std::uint32_t slab_id = static_cast<std::uint32_t>(box.id - box.x); // of the first cell of a row
  if ((box.y & 1) != 0)
    slab_id -= row_step;
  std::int32_t added = 0;
  words += part.first;
  ids += 32 * part.first;
  for (int z = 0; z < part.nz; ++z, words += 8, ids += 256, slab_id += slab_step) {
    std::uint32_t id = slab_id;
    for (int i = 0; i < part.n; ++i, id += 2 * row_step) {
      const std::uint32_t free = part.bits(i) & ~words[i];
      words[i] |= free;
      added += __builtin_popcount(free);
      number(ids + 32 * i, free & 0xFFFF, id);
      number(ids + 32 * i + 16, free >> 16, id + row_step);
    }
  }
  return added;
}

std::int32_t take(const BrickBox& box, std::uint32_t* words) {
  const Words part(box);
  std::int32_t removed = 0;
  words += part.first;
  for (int z = 0; z < part.nz; ++z, words += 8)
    for (int i = 0; i < part.n; ++i) {
      const std::uint32_t taken = part.bits(i) & words[i];
      words[i] ^= taken;
      removed += __builtin_popcount(taken);
    }
  return removed;
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(put);
HWY_EXPORT(take);

std::int32_t put_in_brick(const BrickBox& box, std::uint32_t* words, std::int32_t* ids) {
  return HWY_DYNAMIC_DISPATCH(put)(box, words, ids);
}

std::int32_t take_from_brick(const BrickBox& box, std::uint32_t* words) {
  return HWY_DYNAMIC_DISPATCH(take)(box, words);
}

} // namespace maille::deform
#endif
