#include "elastic/componentwise/componentwise_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/componentwise/componentwise_transfer_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, line_of_floats>;
using V = hn::VFromD<D>;

/// target = sum of weighted rows; `rows` of them.
HWY_INLINE void sum_rows(const float* const* row, const float* weight, int rows, int n, float* target) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < n; x += lanes) {
    V sum = hn::Mul(hn::Set(d, weight[0]), hn::Load(d, row[0] + x));
    for (int k = 1; k < rows; ++k)
      sum = hn::MulAdd(hn::Set(d, weight[k]), hn::Load(d, row[k] + x), sum);
    hn::Store(sum, d, target + x);
  }
}

/// One row of the transposed interpolation along x. @pre readable a line before and after `fine`, 0 before it
HWY_INLINE void restrict_row(const AxisTransfer& t, const float* fine, float* coarse) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (!t.is_coarsened) {
    for (int x = 0; x < t.n_coarse; ++x)
      coarse[x] = fine[x];
    return;
  }
  const int regular = t.n_coarse - 2;
  int done = 0;
  while (done < regular && regular >= lanes) {
    const int x = done + lanes <= regular ? done : regular - lanes; // the last vector may do some twice
    V even, odd, before, unused;
    hn::LoadInterleaved2(d, fine + 2 * x, even, odd);
    hn::LoadInterleaved2(d, fine + 2 * x - 1, before, unused);
    hn::StoreU(hn::MulAdd(hn::Set(d, 0.5F), hn::Add(before, odd), even), d, coarse + x);
    done = x + lanes;
  }
  for (int x = done; x < t.n_coarse; ++x) {
    float sum = 0;
    for (int k = 0; k < t.count[x]; ++k)
      sum += t.hat[x * most_in_support + k] * fine[t.first[x] + k];
    coarse[x] = x < regular ? fine[2 * x] + 0.5F * (fine[2 * x - 1] + fine[2 * x + 1]) : sum; // as in vectors
  }
}

void restrict_to(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine,
                 const AxisTransfer* t, int z, const float* r, float* f_coarse, float* scratch) {
  float* const collected = scratch + line_of_floats;
  collected[-1] = 0;
  const float* rows[most_in_support * most_in_support];
  float weights[most_in_support * most_in_support];
  for (int y = 0; y < coarse.nodes[1]; ++y) {
    int n = 0;
    for (int k = 0; k < t[2].count[z]; ++k)
      for (int j = 0; j < t[1].count[y]; ++j) {
        const int fine_y = t[1].first[y] + j, fine_z = t[2].first[z] + k;
        rows[n] = r + fine_y * fine.row_stride + fine_z * fine.slab_stride;
        weights[n++] = t[2].hat[z * most_in_support + k] * t[1].hat[y * most_in_support + j];
      }
    sum_rows(rows, weights, n, fine.nodes[0], collected);
    restrict_row(t[0], collected, f_coarse + y * coarse.row_stride + z * coarse.slab_stride);
  }
}

HWY_INLINE void prolong_row(const AxisTransfer& t, const float* coarse, float* fine) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int regular = t.is_coarsened ? t.n_coarse - 2 : 0;
  int done = 0;
  while (done < regular && regular >= lanes) {
    const int x = done + lanes <= regular ? done : regular - lanes;
    const V here = hn::LoadU(d, coarse + x), next = hn::LoadU(d, coarse + x + 1);
    hn::StoreInterleaved2(here, hn::Mul(hn::Set(d, 0.5F), hn::Add(here, next)), d, fine + 2 * x);
    done = x + lanes;
  }
  for (int i = 2 * done; i < t.n_fine; ++i) {
    const float* const left = coarse + t.left[i];
    fine[i] = t.right[i] == 0      ? left[0]
              : t.right[i] == 0.5F ? 0.5F * (left[0] + left[1]) // as in vectors
                                   : left[0] + t.right[i] * (left[1] - left[0]);
  }
}

void prolong_to(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine, const AxisTransfer* t,
                int z, const float* u_coarse, bool replaces, float* u, float* scratch) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int coarse_line = (coarse.nodes[0] + line_of_floats - 1) / line_of_floats * line_of_floats;
  float* const collected = scratch;
  float* const interpolated = scratch + coarse_line + line_of_floats;
  const int left_z = t[2].left[z];
  const float right_z = t[2].right[z];
  for (int y = 0; y < fine.nodes[1]; ++y) {
    const float* const inverse = fine.inverse_diagonal[y + int64_t{1} * fine.nodes[1] * z];
    if (inverse == nullptr)
      continue;
    const float* rows[4];
    float weights[4];
    int n = 0;
    for (int k = 0; k < (right_z == 0 ? 1 : 2); ++k)
      for (int j = 0; j < (t[1].right[y] == 0 ? 1 : 2); ++j) {
        const int y_coarse = t[1].left[y] + j, z_coarse = left_z + k;
        rows[n] = u_coarse + y_coarse * coarse.row_stride + z_coarse * coarse.slab_stride;
        weights[n++] = (k == 0 ? 1 - right_z : right_z) * (j == 0 ? 1 - t[1].right[y] : t[1].right[y]);
      }
    sum_rows(rows, weights, n, coarse.nodes[0], collected);
    prolong_row(t[0], collected, interpolated);
    float* const row = u + y * fine.row_stride + z * fine.slab_stride;
    for (int x = 0; x < fine.nodes[0]; x += lanes) {
      const V here = hn::Load(d, row + x), change = hn::Load(d, interpolated + x);
      const auto may_move = hn::Gt(hn::Load(d, inverse + x), hn::Zero(d));
      hn::Store(hn::IfThenElse(may_move, replaces ? change : hn::Add(here, change), here), d, row + x);
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(restrict_to);
HWY_EXPORT(prolong_to);

void restrict_plane(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine,
                    const AxisTransfer* transfer, int z, const float* r, float* f_coarse, float* scratch) {
  HWY_DYNAMIC_DISPATCH(restrict_to)(coarse, fine, transfer, z, r, f_coarse, scratch);
}
void prolong_plane(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine,
                   const AxisTransfer* transfer, int z, const float* u_coarse, bool replaces, float* u,
                   float* scratch) {
  HWY_DYNAMIC_DISPATCH(prolong_to)(coarse, fine, transfer, z, u_coarse, replaces, u, scratch);
}

} // namespace maille::deform
#endif
