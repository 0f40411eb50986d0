#include "discretization/cell_operator.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "discretization/element_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per vector instruction set; nothing with external linkage may be defined outside the guarded
// part below.

HWY_BEFORE_NAMESPACE();
namespace maille::fem_ref {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Number of rows of K that share each load of x.
constexpr int rows_at_once = 3;

template<class T>
HWY_INLINE void multiply_batch(const T* K, int n, const T* x, T* y) {
  const hn::CappedTag<T, cells_per_batch> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int lane = 0; lane < cells_per_batch; lane += lanes) {
    int i = 0;
    for (; i + rows_at_once <= n; i += rows_at_once) {
      const T *first = K + i * n, *second = first + n, *third = second + n;
      auto a = hn::Zero(d), b = hn::Zero(d), c = hn::Zero(d);
      for (int j = 0; j < n; ++j) {
        const auto value = hn::LoadU(d, x + j * cells_per_batch + lane);
        a = hn::MulAdd(hn::Set(d, first[j]), value, a);
        b = hn::MulAdd(hn::Set(d, second[j]), value, b);
        c = hn::MulAdd(hn::Set(d, third[j]), value, c);
      }
      hn::StoreU(a, d, y + i * cells_per_batch + lane);
      hn::StoreU(b, d, y + (i + 1) * cells_per_batch + lane);
      hn::StoreU(c, d, y + (i + 2) * cells_per_batch + lane);
    }
    for (; i < n; ++i) {
      auto a = hn::Zero(d);
      for (int j = 0; j < n; ++j)
        a = hn::MulAdd(hn::Set(d, K[i * n + j]), hn::LoadU(d, x + j * cells_per_batch + lane), a);
      hn::StoreU(a, d, y + i * cells_per_batch + lane);
    }
  }
}

void multiply_float(const float* K, int n, const float* x, float* y) {
  multiply_batch(K, n, x, y);
}

void multiply_double(const double* K, int n, const double* x, double* y) {
  multiply_batch(K, n, x, y);
}

} // namespace HWY_NAMESPACE
} // namespace maille::fem_ref
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::fem_ref {

HWY_EXPORT(multiply_float);
HWY_EXPORT(multiply_double);

void multiply(const float* K, int n, const float* x, float* y) {
  HWY_DYNAMIC_DISPATCH(multiply_float)(K, n, x, y);
}

void multiply(const double* K, int n, const double* x, double* y) {
  HWY_DYNAMIC_DISPATCH(multiply_double)(K, n, x, y);
}

} // namespace maille::fem_ref
#endif
