#include "world/brick_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/brick_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see propagate/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<std::int32_t, 16>;

/// Bits of a box's cells, and where they are. Of two rows to a word the first may be of none of its cells, and the last.
struct Words {
  std::uint32_t row;
  int first_y, end_y, first_z, end_z;
  HWY_INLINE explicit Words(const BrickBox& box)
      : row((0xFFFFu >> (16 - box.nx)) << box.x), first_y(box.y), end_y(box.y + box.ny), first_z(box.z),
        end_z(box.z + box.nz) {}
  /// Of rows y and y + 1; y is even.
  HWY_INLINE std::uint32_t bits(int y) const {
    return (y >= first_y ? row : 0u) | (y + 1 < end_y ? row << 16 : 0u);
  }
};

/// The numbers from `id` on into those of 16 cells whose bits are set.
HWY_INLINE void number(std::int32_t* row, std::uint32_t bits, std::int32_t id) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto lane = hn::Iota(d, 0), bit = hn::Shl(hn::Set(d, 1), lane);
  for (int x = 0; x < 16; x += lanes) {
    const auto has_bit = hn::TestBit(hn::Set(d, static_cast<std::int32_t>(bits >> x)), bit);
    hn::BlendedStore(hn::Add(lane, hn::Set(d, id + x)), has_bit, d, row + x);
  }
}

std::int32_t put(const BrickBox& box, std::uint32_t* words, std::int32_t* ids) {
  const Words part(box);
  const std::int32_t row_step = box.row, slab_step = box.slab;
  std::int32_t slab_id = box.id - box.x - (part.first_y & 1) * row_step; // of the first cell of a row
  std::int32_t added = 0;
  for (int z = part.first_z; z < part.end_z; ++z, slab_id += slab_step) {
    std::int32_t id = slab_id;
    for (int y = part.first_y & ~1; y < part.end_y; y += 2, id += 2 * row_step) {
      std::uint32_t& word = words[y / 2 + 8 * z];
      const std::uint32_t free = part.bits(y) & ~word;
      word |= free;
      added += __builtin_popcount(free);
      std::int32_t* const row = ids + 16 * (y + 16 * z);
      number(row, free & 0xFFFF, id);
      number(row + 16, free >> 16, id + row_step);
    }
  }
  return added;
}

std::int32_t take(const BrickBox& box, std::uint32_t* words) {
  const Words part(box);
  std::int32_t removed = 0;
  for (int z = part.first_z; z < part.end_z; ++z)
    for (int y = part.first_y & ~1; y < part.end_y; y += 2) {
      std::uint32_t& word = words[y / 2 + 8 * z];
      const std::uint32_t taken = part.bits(y) & word;
      word ^= taken;
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
