#include "feasible/box/scan_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/box/pair_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template<bool is_least>
HWY_INLINE void sample_pairs(const Bound<double>& bound, const GridSeedArrays& seeds,
                             const Queries& queries) {
  const hn::CappedTag<double, nodes_per_block> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const double* const axes[3] = {seeds.x, seeds.y, seeds.z};
  for (int q = 0; q < queries.n; ++q) {
    const int at[3] = {queries.at[q].x, queries.at[q].y, queries.at[q].z};
    auto best = hn::Set(d, bound.sample[q]);
    for (int s = 0; s < seeds.n; s += lanes) {
      auto sum = hn::LoadU(d, seeds.value + s);
      for (int axis = 0; axis < 3; ++axis) {
        // ahead and behind are ordered so that the worse of the two products is the right one
        const auto offset = hn::Sub(hn::Set(d, double{1} * at[axis]), hn::LoadU(d, axes[axis] + s));
        const auto ahead = hn::Mul(offset, hn::Set(d, bound.ahead[axis]));
        const auto behind = hn::Mul(offset, hn::Set(d, bound.behind[axis]));
        sum = hn::Add(sum, is_least ? hn::Min(ahead, behind) : hn::Max(ahead, behind));
      }
      best = is_least ? hn::Max(best, sum) : hn::Min(best, sum);
    }
    bound.sample[q] = hn::GetLane(is_least ? hn::MaxOfLanes(d, best) : hn::MinOfLanes(d, best)) + 0.0;
  }
}

void sample_all_pairs(const Bound<double>& bound, const GridSeedArrays& seeds, const Queries& queries) {
  if (bound.is_least)
    sample_pairs<true>(bound, seeds, queries);
  else
    sample_pairs<false>(bound, seeds, queries);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(sample_all_pairs);

void sample_by_pairs(const Bound<double>& bound, const GridSeedArrays& seeds, const Queries& queries) {
  HWY_DYNAMIC_DISPATCH(sample_all_pairs)(bound, seeds, queries);
}

} // namespace maille::deform
#endif
