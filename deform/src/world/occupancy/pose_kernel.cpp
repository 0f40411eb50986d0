#include "world/occupancy/posed_lattice.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/occupancy/pose_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per vector instruction set; feasible/box/cone_kernel.cpp lists the restrictions.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using I32 = hn::Rebind<std::int32_t, D>;
using I16 = hn::Rebind<std::int16_t, D>;

HWY_INLINE std::int32_t cell_of(const CellsFromIndices& from, std::size_t axis, double i, double j,
                                double k) {
  const double y =
      from.offset[axis] + from.columns[0][axis] * i + from.columns[1][axis] * j + from.columns[2][axis] * k;
  return static_cast<std::int32_t>(std::floor(std::clamp(y, -furthest_cell, furthest_cell)));
}

void cells(const CellsFromIndices& from, const std::int16_t* const* index, std::int64_t n,
           std::int32_t* const* out) {
  const D d;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  std::int64_t v = 0;
  for (; v + lanes <= n; v += lanes) {
    const auto i = hn::PromoteTo(d, hn::PromoteTo(I32(), hn::LoadU(I16(), index[0] + v)));
    const auto j = hn::PromoteTo(d, hn::PromoteTo(I32(), hn::LoadU(I16(), index[1] + v)));
    const auto k = hn::PromoteTo(d, hn::PromoteTo(I32(), hn::LoadU(I16(), index[2] + v)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto y = hn::Add(hn::Set(d, from.offset[axis]), hn::Mul(hn::Set(d, from.columns[0][axis]), i));
      y = hn::Add(y, hn::Mul(hn::Set(d, from.columns[1][axis]), j));
      y = hn::Add(y, hn::Mul(hn::Set(d, from.columns[2][axis]), k));
      y = hn::Min(hn::Max(y, hn::Set(d, -furthest_cell)), hn::Set(d, furthest_cell));
      hn::StoreU(hn::DemoteTo(I32(), hn::Floor(y)), I32(), out[axis] + v);
    }
  }
  for (; v < n; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[axis][v] = cell_of(from, axis, index[0][v], index[1][v], index[2][v]);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(cells);

void cells_from_indices(const CellsFromIndices& from, const std::int16_t* const index[3], std::int64_t n,
                        std::int32_t* const cells[3]) {
  HWY_DYNAMIC_DISPATCH(cells)(from, index, n, cells);
}

} // namespace maille::deform
#endif
