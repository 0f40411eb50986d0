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

template<bool least_above, class T>
HWY_INLINE T better(T a, T b) {
  return least_above ? (a > b ? a : b) : (a < b ? a : b);
}

/// target = better(target, source + step) for a row.
template<bool least_above, class T>
HWY_INLINE void offer_row(T* HWY_RESTRICT target, const T* HWY_RESTRICT source, T step, int width) {
  const hn::CappedTag<T, nodes_per_block> d;
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
template<bool least_above, int n_rows, class T>
HWY_INLINE void scan_rows(T* HWY_RESTRICT first, int64_t stride, int width, T ahead, T behind) {
  T last[n_rows];
  for (int k = 0; k < n_rows; ++k)
    last[k] = first[k * stride];
  for (int x = 1; x < width; ++x)
    for (int k = 0; k < n_rows; ++k)
      first[k * stride + x] = last[k] = better<least_above>(first[k * stride + x], last[k] + ahead);
  for (int x = width - 2; x >= 0; --x)
    for (int k = 0; k < n_rows; ++k)
      first[k * stride + x] = last[k] = better<least_above>(first[k * stride + x], last[k] - behind);
}

template<bool least_above, class T>
HWY_INLINE void close_one_slab(const Closure<T>& closure, int z) {
  constexpr int side_by_side = line_of_floats / 2;
  const int width = closure.nodes[0], n_rows = closure.nodes[1];
  const int64_t stride = closure.field.row_stride;
  T* const slab = closure.field.data + z * closure.field.slab_stride;
  const T ahead = static_cast<T>(closure.ahead[0]), behind = static_cast<T>(closure.behind[0]);
  int y = 0;
  for (; y + side_by_side <= n_rows; y += side_by_side)
    scan_rows<least_above, side_by_side>(slab + y * stride, stride, width, ahead, behind);
  for (; y < n_rows; ++y)
    scan_rows<least_above, 1>(slab + y * stride, stride, width, ahead, behind);
  for (y = 1; y < n_rows; ++y)
    offer_row<least_above>(slab + y * stride, slab + (y - 1) * stride, static_cast<T>(closure.ahead[1]),
                           width);
  for (y = n_rows - 2; y >= 0; --y)
    offer_row<least_above>(slab + y * stride, slab + (y + 1) * stride, static_cast<T>(-closure.behind[1]),
                           width);
}

template<bool least_above, class T>
HWY_INLINE void close_rows(const Closure<T>& closure, int y) {
  const int width = closure.nodes[0], n_slabs = closure.nodes[2];
  const int64_t stride = closure.field.slab_stride;
  T* const rows = closure.field.data + y * closure.field.row_stride;
  for (int z = 1; z < n_slabs; ++z)
    offer_row<least_above>(rows + z * stride, rows + (z - 1) * stride, static_cast<T>(closure.ahead[2]),
                           width);
  for (int z = n_slabs - 2; z >= 0; --z)
    offer_row<least_above>(rows + z * stride, rows + (z + 1) * stride, static_cast<T>(-closure.behind[2]),
                           width);
}

template<class T>
HWY_INLINE double mean_of_rows(const Field<T>& below, const Field<T>& above, const int* nodes, int y) {
  const hn::CappedTag<T, nodes_per_block> d;
  const int lanes = static_cast<int>(hn::Lanes(d)), width = nodes[0];
  const auto half = hn::Set(d, static_cast<T>(0.5));
  auto farthest = hn::Zero(d);
  T rest = T{0};
  for (int z = 0; z < nodes[2]; ++z) {
    T* const b = below.data + y * below.row_stride + z * below.slab_stride;
    const T* const a = above.data + y * above.row_stride + z * above.slab_stride;
    int x = 0;
    for (; x + lanes <= width; x += lanes) {
      const auto low = hn::LoadU(d, b + x), high = hn::LoadU(d, a + x);
      farthest = hn::Max(farthest, hn::Sub(high, low));
      // halves first: the sum of two values near the largest would overflow
      hn::StoreU(hn::Add(hn::Mul(half, high), hn::Mul(half, low)), d, b + x);
    }
    for (; x < width; ++x) {
      const T difference = a[x] - b[x];
      rest = difference > rest ? difference : rest;
      b[x] = static_cast<T>(0.5) * a[x] + static_cast<T>(0.5) * b[x];
    }
  }
  const T of_lanes = hn::GetLane(hn::MaxOfLanes(d, farthest));
  return double{of_lanes > rest ? of_lanes : rest};
}

template<class T>
HWY_INLINE void slab_of(const Closure<T>& closure, int z) {
  if (closure.is_least_above)
    close_one_slab<true>(closure, z);
  else
    close_one_slab<false>(closure, z);
}
template<class T>
HWY_INLINE void along_z_of(const Closure<T>& closure, int y) {
  if (closure.is_least_above)
    close_rows<true>(closure, y);
  else
    close_rows<false>(closure, y);
}

void slab_float(const Closure<float>& closure, int z) {
  slab_of(closure, z);
}
void slab_double(const Closure<double>& closure, int z) {
  slab_of(closure, z);
}
void along_z_float(const Closure<float>& closure, int y) {
  along_z_of(closure, y);
}
void along_z_double(const Closure<double>& closure, int y) {
  along_z_of(closure, y);
}
double mean_float(const Field<float>& below, const Field<float>& above, const int* nodes, int y) {
  return mean_of_rows(below, above, nodes, y);
}
double mean_double(const Field<double>& below, const Field<double>& above, const int* nodes, int y) {
  return mean_of_rows(below, above, nodes, y);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(slab_float);
HWY_EXPORT(slab_double);
HWY_EXPORT(along_z_float);
HWY_EXPORT(along_z_double);
HWY_EXPORT(mean_float);
HWY_EXPORT(mean_double);

void close_slab(const Closure<float>& closure, int z) {
  HWY_DYNAMIC_DISPATCH(slab_float)(closure, z);
}
void close_slab(const Closure<double>& closure, int z) {
  HWY_DYNAMIC_DISPATCH(slab_double)(closure, z);
}
void close_along_z(const Closure<float>& closure, int y) {
  HWY_DYNAMIC_DISPATCH(along_z_float)(closure, y);
}
void close_along_z(const Closure<double>& closure, int y) {
  HWY_DYNAMIC_DISPATCH(along_z_double)(closure, y);
}
double take_mean(const Field<float>& below, const Field<float>& above, const int* nodes, int y) {
  return HWY_DYNAMIC_DISPATCH(mean_float)(below, above, nodes, y);
}
double take_mean(const Field<double>& below, const Field<double>& above, const int* nodes, int y) {
  return HWY_DYNAMIC_DISPATCH(mean_double)(below, above, nodes, y);
}

} // namespace maille::deform
#endif
