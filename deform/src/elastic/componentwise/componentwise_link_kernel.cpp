#include "elastic/componentwise/componentwise_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/componentwise/componentwise_link_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::VFromD<D>;
using Narrow = hn::Rebind<float, D>;

HWY_INLINE V clamped(V value, V low, V high) {
  return hn::Min(hn::Max(value, low), high);
}

HWY_INLINE double clamped_one(double value, double low, double high) {
  return value < low ? low : value > high ? high : value;
}

void pull(const RowOfLinks& row, double scale, double* target) {
  const D d;
  const Narrow narrow;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const double factor = scale * row.factor;
  const V all = hn::Set(d, factor), two = hn::Set(d, 2.0);
  int x = 0;
  for (; x + lanes <= row.n; x += lanes) {
    const V v = hn::PromoteTo(d, hn::LoadU(narrow, row.v + x));
    const V weight = hn::Mul(all, hn::PromoteTo(d, hn::LoadU(narrow, row.weight + x)));
    const V z = clamped(v, hn::LoadU(d, row.low + x), hn::LoadU(d, row.high + x));
    const V force = hn::Mul(weight, hn::Sub(hn::Mul(two, z), v));
    hn::StoreU(hn::Add(hn::LoadU(d, target + x), force), d, target + x);
  }
  for (; x < row.n; ++x) {
    const double v = double{row.v[x]}, z = clamped_one(v, row.low[x], row.high[x]);
    target[x] += factor * double{row.weight[x]} * (2 * z - v);
  }
}

void update(const RowOfLinks& row, double over_relaxation, const double* near, const double* far,
            LinkResiduals& residuals) {
  const D d;
  const Narrow narrow;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V relaxation = hn::Set(d, over_relaxation);
  V primal = hn::Zero(d), dual = hn::Zero(d), norm = hn::Zero(d);
  int x = 0;
  for (; x + lanes <= row.n; x += lanes) {
    const V low = hn::LoadU(d, row.low + x), high = hn::LoadU(d, row.high + x);
    const V weight = hn::PromoteTo(d, hn::LoadU(narrow, row.weight + x));
    const V difference = hn::Sub(hn::LoadU(d, far + x), hn::LoadU(d, near + x));
    const V before = hn::PromoteTo(d, hn::LoadU(narrow, row.v + x));
    const V z_before = clamped(before, low, high);
    const V after = hn::MulAdd(relaxation, hn::Sub(difference, z_before), before);
    const V z = clamped(after, low, high);
    hn::StoreU(hn::DemoteTo(narrow, after), narrow, row.v + x);
    const V gap = hn::Sub(difference, z), change = hn::Sub(z, z_before);
    primal = hn::MulAdd(weight, hn::Mul(gap, gap), primal);
    dual = hn::MulAdd(weight, hn::Mul(change, change), dual);
    norm = hn::MulAdd(weight, hn::Mul(difference, difference), norm);
  }
  double sums[3] = {hn::GetLane(hn::SumOfLanes(d, primal)), hn::GetLane(hn::SumOfLanes(d, dual)),
                    hn::GetLane(hn::SumOfLanes(d, norm))};
  for (; x < row.n; ++x) {
    const double weight = double{row.weight[x]}, difference = far[x] - near[x], before = double{row.v[x]};
    const double z_before = clamped_one(before, row.low[x], row.high[x]);
    const double after = over_relaxation * (difference - z_before) + before;
    const double z = clamped_one(after, row.low[x], row.high[x]);
    row.v[x] = static_cast<float>(after);
    sums[0] += weight * (difference - z) * (difference - z);
    sums[1] += weight * (z - z_before) * (z - z_before);
    sums[2] += weight * difference * difference;
  }
  residuals.primal += row.factor * sums[0];
  residuals.dual += row.factor * sums[1];
  residuals.norm += row.factor * sums[2];
}

void rescale(const RowOfLinks& row, double factor) {
  for (int x = 0; x < row.n; ++x) {
    const double v = double{row.v[x]}, z = clamped_one(v, row.low[x], row.high[x]);
    row.v[x] = static_cast<float>(z + (v - z) / factor);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(pull);
HWY_EXPORT(update);
HWY_EXPORT(rescale);

void add_pulls(const RowOfLinks& row, double scale, double* target) {
  HWY_DYNAMIC_DISPATCH(pull)(row, scale, target);
}
void update_multipliers(const RowOfLinks& row, double over_relaxation, const double* near, const double* far,
                        LinkResiduals& residuals) {
  HWY_DYNAMIC_DISPATCH(update)(row, over_relaxation, near, far, residuals);
}
void scale_multipliers(const RowOfLinks& row, double factor) {
  HWY_DYNAMIC_DISPATCH(rescale)(row, factor);
}

} // namespace maille::deform
#endif
