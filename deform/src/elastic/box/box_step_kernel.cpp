#include "elastic/box/box_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/box/box_step_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every node is
// computed by the same operations in vectors of any length.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Many = hn::CappedTag<double, line_of_floats / 2>;
using One = hn::CappedTag<double, 1>;

template<class D>
HWY_INLINE hn::VFromD<D> widened(D d, const float* values) {
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, D>(), values));
}

/// Calls visit(tag, x) for vectors of a row of n nodes and, at its end, for single ones: what comes next in
/// memory is another row's.
template<class Visit>
HWY_INLINE void for_row(int n, Visit&& visit) {
  const int lanes = static_cast<int>(hn::Lanes(Many()));
  int x = 0;
  for (; x + lanes <= n; x += lanes)
    visit(Many(), x);
  for (; x < n; ++x)
    visit(One(), x);
}

/// Calls visit(place of a row in dense fields, place in fields of float32) for the rows of a plane.
template<class Visit>
HWY_INLINE void for_rows(const BoxOperator& A, int z, Visit&& visit) {
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < A.nodes[1]; ++y)
      visit((y + std::int64_t{1} * A.nodes[1] * (z + std::int64_t{1} * A.nodes[2] * c)) * A.nodes[0],
            c * A.component_stride + y * A.row_stride + z * A.slab_stride);
}

void move(const BoxOperator& A, int z, double of_u, const float* p, double* u, double of_r, const float* q,
          double* r) {
  for_rows(A, z, [&](std::int64_t dense, std::int64_t at) HWY_ATTR {
    double *const u_row = u + dense, *const r_row = r + dense;
    for_row(A.nodes[0], [&](auto d, int x) HWY_ATTR {
      hn::StoreU(hn::MulAdd(hn::Set(d, of_u), widened(d, p + at + x), hn::LoadU(d, u_row + x)), d, u_row + x);
      hn::StoreU(hn::MulAdd(hn::Set(d, of_r), widened(d, q + at + x), hn::LoadU(d, r_row + x)), d, r_row + x);
    });
  });
}

void narrow(const BoxOperator& A, int z, double factor, const double* from, float* to) {
  for_rows(A, z, [&](std::int64_t dense, std::int64_t at) HWY_ATTR {
    for_row(A.nodes[0], [&](auto d, int x) HWY_ATTR {
      const hn::Rebind<float, decltype(d)> narrow;
      hn::StoreU(hn::DemoteTo(narrow, hn::Mul(hn::Set(d, factor), hn::LoadU(d, from + dense + x))), narrow,
                 to + at + x);
    });
  });
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(move);
HWY_EXPORT(narrow);

void move_box(const BoxOperator& A, int z, double of_u, const float* p, double* u, double of_r,
              const float* q, double* r) {
  HWY_DYNAMIC_DISPATCH(move)(A, z, of_u, p, u, of_r, q, r);
}
void narrow_box(const BoxOperator& A, int z, double factor, const double* from, float* to) {
  HWY_DYNAMIC_DISPATCH(narrow)(A, z, factor, from, to);
}

} // namespace maille::deform
#endif
