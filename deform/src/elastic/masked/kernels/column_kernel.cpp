#include "elastic/masked/masked_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/column_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstdint>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every number is
// summed in the same order in vectors of any length.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 4>;

void add_all(std::int64_t size, int n, const float* columns, const double* c, double* sum) {
  constexpr int n_vectors = static_cast<int>(column_part) / static_cast<int>(hn::MaxLanes(D()));
  const D d;
  const hn::Rebind<float, D> single;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  for (std::int64_t first = 0; first < size; first += column_part) {
    hn::VFromD<D> sums[n_vectors];
    for (int i = 0; i < n_vectors; ++i)
      sums[i] = hn::LoadU(d, sum + first + i * lanes);
    const float* from = columns + first;
    for (int k = 0; k < n; ++k, from += size) {
      const auto factor = hn::Set(d, c[k]);
      for (int i = 0; i < n_vectors; ++i)
        sums[i] = hn::MulAdd(hn::PromoteTo(d, hn::LoadU(single, from + i * lanes)), factor, sums[i]);
    }
    for (int i = 0; i < n_vectors; ++i)
      hn::StoreU(sums[i], d, sum + first + i * lanes);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add_all);

void add_columns(std::int64_t size, int n, const float* columns, const double* c, double* sum) {
  HWY_DYNAMIC_DISPATCH(add_all)(size, n, columns, c, sum);
}

} // namespace maille::deform
#endif
