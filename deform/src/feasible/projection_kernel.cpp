#include "feasible/box/scan_kernel.hpp"
#include "feasible/projection.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/projection_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, nodes_per_block>;

template<bool least_above>
HWY_INLINE double better(double a, double b) {
  return least_above ? (a > b ? a : b) : (a < b ? a : b);
}

/// target = better(target, source + step) for a row.
template<bool least_above>
HWY_INLINE void offer_row(double* HWY_RESTRICT target, const double* HWY_RESTRICT source, double step,
                          int width) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto add = hn::Set(d, step);
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto old = hn::LoadU(d, target + x), offer = hn::Add(hn::LoadU(d, source + x), add);
    hn::StoreU(least_above ? hn::Max(old, offer) : hn::Min(old, offer), d, target + x);
  }
  for (; x < width; ++x)
    target[x] = better<least_above>(target[x], source[x] + step);
}

/// Scans n_rows rows along x side by side: each waits for its own last sum, not for the others'.
template<bool least_above, int n_rows>
HWY_INLINE void scan_rows(double* HWY_RESTRICT first, int64_t stride, int width, double ahead,
                          double behind) {
  double last[n_rows];
  for (int k = 0; k < n_rows; ++k)
    last[k] = first[k * stride];
  for (int x = 1; x < width; ++x)
    for (int k = 0; k < n_rows; ++k)
      first[k * stride + x] = last[k] = better<least_above>(first[k * stride + x], last[k] + ahead);
  for (int x = width - 2; x >= 0; --x)
    for (int k = 0; k < n_rows; ++k)
      first[k * stride + x] = last[k] = better<least_above>(first[k * stride + x], last[k] - behind);
}

template<bool least_above>
HWY_INLINE void close_one_slab(const Closure& closure, int z) {
  constexpr int side_by_side = line_of_floats / 2;
  const int width = closure.nodes[0], n_rows = closure.nodes[1];
  const int64_t stride = closure.field.row_stride;
  double* const slab = closure.field.data + z * closure.field.slab_stride;
  const double ahead = closure.ahead[0], behind = closure.behind[0];
  int y = 0;
  for (; y + side_by_side <= n_rows; y += side_by_side)
    scan_rows<least_above, side_by_side>(slab + y * stride, stride, width, ahead, behind);
  for (; y < n_rows; ++y)
    scan_rows<least_above, 1>(slab + y * stride, stride, width, ahead, behind);
  for (y = 1; y < n_rows; ++y)
    offer_row<least_above>(slab + y * stride, slab + (y - 1) * stride, closure.ahead[1], width);
  for (y = n_rows - 2; y >= 0; --y)
    offer_row<least_above>(slab + y * stride, slab + (y + 1) * stride, -closure.behind[1], width);
}

template<bool least_above>
HWY_INLINE void close_rows(const Closure& closure, int y) {
  const int width = closure.nodes[0], n_slabs = closure.nodes[2];
  const int64_t stride = closure.field.slab_stride;
  double* const rows = closure.field.data + y * closure.field.row_stride;
  for (int z = 1; z < n_slabs; ++z)
    offer_row<least_above>(rows + z * stride, rows + (z - 1) * stride, closure.ahead[2], width);
  for (int z = n_slabs - 2; z >= 0; --z)
    offer_row<least_above>(rows + z * stride, rows + (z + 1) * stride, -closure.behind[2], width);
}

double mean_of_rows(const Field<double>& below, const Field<double>& above, const int* nodes, int y) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d)), width = nodes[0];
  const auto half = hn::Set(d, 0.5);
  auto farthest = hn::Zero(d);
  double rest = 0;
  for (int z = 0; z < nodes[2]; ++z) {
    double* const b = below.data + y * below.row_stride + z * below.slab_stride;
    const double* const a = above.data + y * above.row_stride + z * above.slab_stride;
    int x = 0;
    for (; x + lanes <= width; x += lanes) {
      const auto low = hn::LoadU(d, b + x), high = hn::LoadU(d, a + x);
      farthest = hn::Max(farthest, hn::Sub(high, low));
      // halves first: the sum of two values near the largest would overflow
      hn::StoreU(hn::Add(hn::Mul(half, high), hn::Mul(half, low)), d, b + x);
    }
    for (; x < width; ++x) {
      const double difference = a[x] - b[x];
      rest = difference > rest ? difference : rest;
      b[x] = 0.5 * a[x] + 0.5 * b[x];
    }
  }
  const double of_lanes = hn::GetLane(hn::MaxOfLanes(d, farthest));
  return of_lanes > rest ? of_lanes : rest;
}

void slab(const Closure& closure, int z) {
  if (closure.is_least_above)
    close_one_slab<true>(closure, z);
  else
    close_one_slab<false>(closure, z);
}
void along_z(const Closure& closure, int y) {
  if (closure.is_least_above)
    close_rows<true>(closure, y);
  else
    close_rows<false>(closure, y);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(slab);
HWY_EXPORT(along_z);
HWY_EXPORT(mean_of_rows);

void close_slab(const Closure& closure, int z) {
  HWY_DYNAMIC_DISPATCH(slab)(closure, z);
}
void close_along_z(const Closure& closure, int y) {
  HWY_DYNAMIC_DISPATCH(along_z)(closure, y);
}
double take_mean(const Field<double>& below, const Field<double>& above, const int* nodes, int y) {
  return HWY_DYNAMIC_DISPATCH(mean_of_rows)(below, above, nodes, y);
}

} // namespace maille::deform
#endif
