#include "world/occupancy/occupancy_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/occupancy/occupancy_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per vector instruction set; feasible/box/cone_kernel.cpp lists the restrictions.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<std::int32_t>;
using U = hn::RebindToUnsigned<D>;

/// 1 where a cell is blocked, else 0.
HWY_INLINE hn::Vec<U> blocked(const OccupancyTables& tables, hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z) {
  const D d;
  const U u;
  const auto below = [&](hn::Vec<D> i, int n) {
    return hn::Lt(hn::BitCast(u, i), hn::Set(u, static_cast<std::uint32_t>(n)));
  };
  const auto has_cell =
      hn::And(below(x, tables.cells[0]), hn::And(below(y, tables.cells[1]), below(z, tables.cells[2])));
  // Indices outside are replaced by the first cell; their result is not used.
  const auto inside = hn::VecFromMask(d, hn::RebindMask(d, has_cell));
  x = hn::And(x, inside);
  y = hn::And(y, inside);
  z = hn::And(z, inside);
  const auto slab =
      hn::Add(hn::ShiftRight<4>(y), hn::Mul(hn::ShiftRight<4>(z), hn::Set(d, tables.n_bricks[1])));
  const auto place = hn::Add(hn::ShiftRight<4>(x), hn::Mul(slab, hn::Set(d, tables.n_bricks[0])));
  const auto brick = hn::GatherIndex(d, tables.bricks, place);
  const auto row =
      hn::Add(hn::ShiftRight<1>(hn::And(y, hn::Set(d, 15))), hn::ShiftLeft<3>(hn::And(z, hn::Set(d, 15))));
  const auto words = hn::GatherIndex(u, tables.words, hn::Add(hn::ShiftLeft<7>(brick), row));
  const auto bit = hn::Add(hn::And(x, hn::Set(d, 15)), hn::ShiftLeft<4>(hn::And(y, hn::Set(d, 1))));
  const auto one = hn::Set(u, 1);
  return hn::IfThenElse(has_cell, hn::And(hn::Shr(words, hn::BitCast(u, bit)), one), one);
}

std::int64_t count(const OccupancyTables& tables, std::int64_t n, const std::int32_t* const* cells) {
  const D d;
  const U u;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  auto sum = hn::Zero(u);
  std::int64_t v = 0;
  for (; v + lanes <= n; v += lanes)
    sum = hn::Add(sum, blocked(tables, hn::LoadU(d, cells[0] + v), hn::LoadU(d, cells[1] + v),
                               hn::LoadU(d, cells[2] + v)));
  std::int64_t total = hn::GetLane(hn::SumOfLanes(u, sum));
  if (v < n) {
    HWY_ALIGN std::int32_t rest[3][hn::MaxLanes(d)] = {};
    for (std::int64_t i = 0; v + i < n; ++i)
      for (int axis = 0; axis < 3; ++axis)
        rest[axis][i] = cells[axis][v + i];
    HWY_ALIGN std::uint32_t bits[hn::MaxLanes(d)];
    hn::Store(blocked(tables, hn::Load(d, rest[0]), hn::Load(d, rest[1]), hn::Load(d, rest[2])), u, bits);
    for (std::int64_t i = 0; v + i < n; ++i)
      total += bits[i];
  }
  return total;
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(count);

std::int64_t count_blocked(const OccupancyTables& tables, std::int64_t n,
                           const std::int32_t* const cells[3]) {
  return HWY_DYNAMIC_DISPATCH(count)(tables, n, cells);
}

} // namespace maille::deform
#endif
