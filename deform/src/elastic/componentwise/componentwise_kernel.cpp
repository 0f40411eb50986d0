#include "elastic/componentwise/componentwise_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/componentwise/componentwise_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Products are
// fused with sums where the machine can, so bits depend on the kind of vector, but never on the number of
// threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, line_of_floats>;
using V = hn::VFromD<D>;

/// Weights of a row of a box: factors of the row, times one number per node.
struct BoxRow {
  const float* x_link;
  const float* x_mass;
  V along_x, y_below, y_above, z_below, z_above, sum;

  HWY_INLINE BoxRow(const ComponentwiseOperator& A, int y, int z)
      : x_link(A.axis_link[0]), x_mass(A.axis_mass[0]) {
    const D d;
    const float y_mass = A.axis_mass[1][y], z_mass = A.axis_mass[2][z];
    const float below_y = A.axis_link[1][y - 1] * z_mass, above_y = A.axis_link[1][y] * z_mass;
    const float below_z = A.axis_link[2][z - 1] * y_mass, above_z = A.axis_link[2][z] * y_mass;
    along_x = hn::Set(d, y_mass * z_mass);
    y_below = hn::Set(d, below_y);
    y_above = hn::Set(d, above_y);
    z_below = hn::Set(d, below_z);
    z_above = hn::Set(d, above_z);
    sum = hn::Set(d, (below_y + above_y) + (below_z + above_z));
  }

  /// f - A u, without masks.
  HWY_INLINE V residual(const D d, int x, V f, V u, const float* row, const float* ym, const float* yp,
                        const float* zm, const float* zp) const {
    V across = hn::Mul(y_below, hn::Load(d, ym + x));
    across = hn::MulAdd(y_above, hn::Load(d, yp + x), across);
    across = hn::MulAdd(z_below, hn::Load(d, zm + x), across);
    across = hn::MulAdd(z_above, hn::Load(d, zp + x), across);
    across = hn::NegMulAdd(sum, u, across);
    V along = hn::Mul(hn::LoadU(d, x_link + x - 1), hn::Sub(hn::LoadU(d, row + x - 1), u));
    along = hn::MulAdd(hn::Load(d, x_link + x), hn::Sub(hn::LoadU(d, row + x + 1), u), along);
    return hn::MulAdd(along_x, along, hn::MulAdd(hn::Load(d, x_mass + x), across, f));
  }
};

/// Weights of a row of any body: one number per link.
struct LinkRow {
  const float *x_link, *y_below, *y_above, *z_below, *z_above;

  HWY_INLINE LinkRow(const ComponentwiseOperator& A, int y, int z) {
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    x_link = A.link[0] + at;
    y_above = A.link[1] + at;
    z_above = A.link[2] + at;
    // The last row and plane have no links beyond them: their zeros serve before the first too.
    y_below = y > 0 ? y_above - A.row_stride : y_above + (A.nodes[1] - 1) * A.row_stride;
    z_below = z > 0 ? z_above - A.slab_stride : z_above + (A.nodes[2] - 1) * A.slab_stride;
  }

  HWY_INLINE V residual(const D d, int x, V f, V u, const float* row, const float* ym, const float* yp,
                        const float* zm, const float* zp) const {
    V sum = hn::MulAdd(hn::LoadU(d, x_link + x - 1), hn::Sub(hn::LoadU(d, row + x - 1), u), f);
    sum = hn::MulAdd(hn::Load(d, x_link + x), hn::Sub(hn::LoadU(d, row + x + 1), u), sum);
    sum = hn::MulAdd(hn::Load(d, y_below + x), hn::Sub(hn::Load(d, ym + x), u), sum);
    sum = hn::MulAdd(hn::Load(d, y_above + x), hn::Sub(hn::Load(d, yp + x), u), sum);
    sum = hn::MulAdd(hn::Load(d, z_below + x), hn::Sub(hn::Load(d, zm + x), u), sum);
    return hn::MulAdd(hn::Load(d, z_above + x), hn::Sub(hn::Load(d, zp + x), u), sum);
  }
};

/// Calls visit(y, row offset, inverse diagonal, residual at) for the rows of a plane that have free nodes.
/// residual at(x, f, u) is f - A u of a vector of nodes.
template<class Row, class Visit>
HWY_INLINE void for_rows(const ComponentwiseOperator& A, int z, const float* u, Visit&& visit) {
  const D d;
  for (int y = 0; y < A.nodes[1]; ++y) {
    const float* const inverse = A.inverse_diagonal[y + int64_t{1} * A.nodes[1] * z];
    if (inverse == nullptr)
      continue;
    const Row weights(A, y, z);
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    const float* const row = u + at;
    // Where there is no neighbour the weight is 0, and any row will do.
    const float* const ym = y > 0 ? row - A.row_stride : row;
    const float* const yp = y + 1 < A.nodes[1] ? row + A.row_stride : row;
    const float* const zm = z > 0 ? row - A.slab_stride : row;
    const float* const zp = z + 1 < A.nodes[2] ? row + A.slab_stride : row;
    const float* const anchor = A.anchor == nullptr ? nullptr : A.anchor[y + int64_t{1} * A.nodes[1] * z];
    if (anchor == nullptr)
      visit(y, at, inverse, [&](int x, V f, V here) HWY_ATTR {
        return weights.residual(d, x, f, here, row, ym, yp, zm, zp);
      });
    else
      visit(y, at, inverse, [&](int x, V f, V here) HWY_ATTR {
        return hn::NegMulAdd(hn::Load(d, anchor + x), here,
                             weights.residual(d, x, f, here, row, ym, yp, zm, zp));
      });
  }
}

template<class Visit>
HWY_INLINE void for_all_rows(const ComponentwiseOperator& A, int z, const float* u, Visit&& visit) {
  if (A.link[0] == nullptr)
    for_rows<BoxRow>(A, z, u, visit);
  else
    for_rows<LinkRow>(A, z, u, visit);
}

void start(const ComponentwiseOperator& A, int z, float weight, const float* f, float* u) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V factor = hn::Set(d, weight);
  for (int y = 0; y < A.nodes[1]; ++y) {
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    const float* const inverse = A.inverse_diagonal[y + int64_t{1} * A.nodes[1] * z];
    for (int x = 0; x < A.nodes[0]; x += lanes)
      hn::Store(inverse == nullptr
                    ? hn::Zero(d)
                    : hn::Mul(factor, hn::Mul(hn::Load(d, f + at + x), hn::Load(d, inverse + x))),
                d, u + at + x);
  }
}

void relax(const ComponentwiseOperator& A, int z, float weight, const float* f, const float* u, float* next) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V factor = hn::Set(d, weight);
  for (int y = 0; y < A.nodes[1]; ++y)
    if (A.inverse_diagonal[y + int64_t{1} * A.nodes[1] * z] == nullptr)
      for (int64_t at = y * A.row_stride + z * A.slab_stride, end = at + A.nodes[0]; at < end; at += lanes)
        hn::Store(hn::Load(d, u + at), d, next + at);
  for_all_rows(A, z, u, [&](int, int64_t at, const float* inverse, const auto& residual) HWY_ATTR {
    for (int x = 0; x < A.nodes[0]; x += lanes) {
      const V here = hn::Load(d, u + at + x);
      const V change = hn::Mul(factor, hn::Load(d, inverse + x));
      hn::Store(hn::MulAdd(residual(x, hn::Load(d, f + at + x), here), change, here), d, next + at + x);
    }
  });
}

void residual_of(const ComponentwiseOperator& A, int z, const float* f, const float* u, float* r) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for_all_rows(A, z, u, [&](int, int64_t at, const float* inverse, const auto& residual) HWY_ATTR {
    for (int x = 0; x < A.nodes[0]; x += lanes) {
      const V value = residual(x, hn::Load(d, f + at + x), hn::Load(d, u + at + x));
      const auto may_move = hn::Gt(hn::Load(d, inverse + x), hn::Zero(d));
      hn::Store(hn::IfThenElseZero(may_move, value), d, r + at + x);
    }
  });
}

double apply(const ComponentwiseOperator& A, int z, const float* p, float* q) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  double sum = 0;
  for_all_rows(A, z, p, [&](int, int64_t at, const float* inverse, const auto& residual) HWY_ATTR {
    V row_sum = hn::Zero(d);
    for (int x = 0; x < A.nodes[0]; x += lanes) {
      const V here = hn::Load(d, p + at + x);
      const auto may_move = hn::Gt(hn::Load(d, inverse + x), hn::Zero(d));
      const V value = hn::IfThenElseZero(may_move, hn::Neg(residual(x, hn::Zero(d), here)));
      hn::Store(value, d, q + at + x);
      row_sum = hn::MulAdd(here, value, row_sum);
    }
    sum += double{hn::GetLane(hn::SumOfLanes(d, row_sum))};
  });
  return sum;
}

double dot_plane(const ComponentwiseOperator& A, int z, const float* a, const float* b) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  double sum = 0;
  for (int y = 0; y < A.nodes[1]; ++y) {
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    V row_sum = hn::Zero(d);
    for (int x = 0; x < A.nodes[0]; x += lanes)
      row_sum = hn::MulAdd(hn::Load(d, a + at + x), hn::Load(d, b + at + x), row_sum);
    sum += double{hn::GetLane(hn::SumOfLanes(d, row_sum))};
  }
  return sum;
}

double direction_plane(const ComponentwiseOperator& A, int z, const float* v, float beta, float* p) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V factor = hn::Set(d, beta);
  V largest = hn::Zero(d);
  for (int y = 0; y < A.nodes[1]; ++y) {
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    for (int x = 0; x < A.nodes[0]; x += lanes) {
      const V correction = hn::Load(d, v + at + x);
      largest = hn::Max(largest, hn::Abs(correction));
      hn::Store(hn::MulAdd(factor, hn::Load(d, p + at + x), correction), d, p + at + x);
    }
  }
  return double{hn::GetLane(hn::MaxOfLanes(d, largest))};
}

double step_plane(const ComponentwiseOperator& A, int z, double alpha, double scale, const float* p,
                  const float* q, double* x, float* r) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V factor = hn::Set(d, static_cast<float>(alpha));
  const double step = alpha * scale;
  V largest = hn::Zero(d);
  for (int y = 0; y < A.nodes[1]; ++y) {
    const int64_t at = y * A.row_stride + z * A.slab_stride;
    for (int i = 0; i < A.nodes[0]; i += lanes) {
      hn::Store(hn::NegMulAdd(factor, hn::Load(d, q + at + i), hn::Load(d, r + at + i)), d, r + at + i);
      largest = hn::Max(largest, hn::Abs(hn::Load(d, p + at + i)));
    }
    double* const dense = x + (y + int64_t{1} * A.nodes[1] * z) * A.nodes[0];
    const float* const direction = p + at;
    for (int i = 0; i < A.nodes[0]; ++i)
      dense[i] += step * double{direction[i]};
  }
  const double change = alpha * double{hn::GetLane(hn::MaxOfLanes(d, largest))};
  return change < 0 ? -change : change;
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(start);
HWY_EXPORT(relax);
HWY_EXPORT(residual_of);
HWY_EXPORT(apply);
HWY_EXPORT(dot_plane);
HWY_EXPORT(direction_plane);
HWY_EXPORT(step_plane);

void start_relaxation(const ComponentwiseOperator& A, int z, float weight, const float* f, float* u) {
  HWY_DYNAMIC_DISPATCH(start)(A, z, weight, f, u);
}
void relax_plane(const ComponentwiseOperator& A, int z, float weight, const float* f, const float* u,
                 float* next) {
  HWY_DYNAMIC_DISPATCH(relax)(A, z, weight, f, u, next);
}
void find_residual(const ComponentwiseOperator& A, int z, const float* f, const float* u, float* r) {
  HWY_DYNAMIC_DISPATCH(residual_of)(A, z, f, u, r);
}
double apply_and_dot(const ComponentwiseOperator& A, int z, const float* p, float* q) {
  return HWY_DYNAMIC_DISPATCH(apply)(A, z, p, q);
}
double dot(const ComponentwiseOperator& A, int z, const float* a, const float* b) {
  return HWY_DYNAMIC_DISPATCH(dot_plane)(A, z, a, b);
}
double update_direction(const ComponentwiseOperator& A, int z, const float* v, float beta, float* p) {
  return HWY_DYNAMIC_DISPATCH(direction_plane)(A, z, v, beta, p);
}
double take_step(const ComponentwiseOperator& A, int z, double alpha, double scale, const float* p,
                 const float* q, double* x, float* r) {
  return HWY_DYNAMIC_DISPATCH(step_plane)(A, z, alpha, scale, p, q, x, r);
}

} // namespace maille::deform
#endif
