#include "elastic/box/box_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/box/box_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "elastic/box/box_plane-inl.hpp"

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every node is
// computed by the same operations in vectors of any length, and sums over a row have 16 parts; so bits depend
// on whether the machine fuses products with sums, but neither on the length of its vectors nor on the number
// of threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

/// Vectors of the operator. Longer ones would waste padding, because boxes often have a power of two plus one
/// node.
using F = hn::CappedTag<float, line_of_floats / 2>;
using VF = hn::VFromD<F>;
/// Vectors of all other loops.
using Line = hn::CappedTag<float, line_of_floats>;
using VLine = hn::VFromD<Line>;

struct LoadPadded {
  HWY_INLINE VF operator()(const float* row, int x) const { return hn::Load(F(), row + x); }
};

/// Sixteen running sums of products, for any vector length.
class SixteenSums {
public:
  HWY_INLINE SixteenSums() {
    for (float& part : parts_)
      part = 0;
  }
  template<class V>
  HWY_INLINE void add(int x, V a, V b) {
    const hn::DFromV<V> d;
    float* const part = parts_ + x % line_of_floats;
    hn::Store(hn::MulAdd(a, b, hn::Load(d, part)), d, part);
  }
  HWY_INLINE double total() const {
    double sum = 0;
    for (const float part : parts_)
      sum += double{part};
    return sum;
  }

private:
  alignas(64) float parts_[line_of_floats];
};

/// Calls visit(offset of the row, inverse diagonals, x, force along x, y, z) for the vectors of a plane.
template<class Visit>
HWY_INLINE void for_plane(const BoxOperator& A, int z, const float* u, void* scratch, Visit&& visit) {
  const BoxPlane<F, LoadPadded> plane(A, A.x_axis, scratch);
  for (int y = 0; y < A.nodes[1]; ++y) {
    const std::int64_t at = y * A.row_stride + z * A.slab_stride, row = y + std::int64_t{1} * A.nodes[1] * z;
    const float* const of_u[3] = {u + at, u + at + A.component_stride, u + at + 2 * A.component_stride};
    const float* const inverse[3] = {A.inverse[0][row], A.inverse[1][row], A.inverse[2][row]};
    plane.for_row(y, z, of_u, A.row_stride, A.slab_stride, LoadPadded(),
                  [&](int x, VF force_x, VF force_y, VF force_z)
                      HWY_ATTR { visit(at, inverse, x, force_x, force_y, force_z); });
  }
}

void start(const BoxOperator& A, int z, float weight, float step, const float* q, float* f, float* u) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const VLine factor = hn::Set(d, weight), length = hn::Set(d, step);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < A.nodes[1]; ++y) {
      const std::int64_t at = c * A.component_stride + y * A.row_stride + z * A.slab_stride;
      const float* const inverse = A.inverse[c][y + std::int64_t{1} * A.nodes[1] * z];
      for (int x = 0; x < A.nodes[0]; x += lanes) {
        VLine force = hn::Load(d, f + at + x);
        if (step != 0) {
          force = hn::NegMulAdd(length, hn::Load(d, q + at + x), force);
          hn::Store(force, d, f + at + x);
        }
        hn::Store(hn::Mul(hn::Mul(factor, hn::Load(d, inverse + x)), force), d, u + at + x);
      }
    }
}

void relax(const BoxOperator& A, int z, float weight, const float* f, const float* u, float* next,
           void* scratch) {
  const F d;
  const VF factor = hn::Set(d, weight);
  for_plane(
      A, z, u, scratch,
      [&](std::int64_t at, const float* const* inverse, int x, VF force_x, VF force_y, VF force_z) HWY_ATTR {
        const auto one = [&](int c, VF force) HWY_ATTR {
          const std::int64_t i = at + c * A.component_stride + x;
          const VF change = hn::Mul(factor, hn::Load(d, inverse[c] + x));
          hn::Store(hn::MulAdd(hn::Sub(hn::Load(d, f + i), force), change, hn::Load(d, u + i)), d, next + i);
        };
        one(0, force_x);
        one(1, force_y);
        one(2, force_z);
      });
}

void residual_of(const BoxOperator& A, int z, const float* f, const float* u, float* r, void* scratch) {
  const F d;
  for_plane(A, z, u, scratch,
            [&](std::int64_t at, const float* const* inverse, int x, VF force_x, VF force_y, VF force_z)
                HWY_ATTR {
                  const auto one = [&](int c, VF force) HWY_ATTR {
                    const std::int64_t i = at + c * A.component_stride + x;
                    const auto may_move = hn::Gt(hn::Load(d, inverse[c] + x), hn::Zero(d));
                    hn::Store(hn::IfThenElseZero(may_move, hn::Sub(hn::Load(d, f + i), force)), d, r + i);
                  };
                  one(0, force_x);
                  one(1, force_y);
                  one(2, force_z);
                });
}

double apply(const BoxOperator& A, int z, const float* p, float* q, void* scratch) {
  const F d;
  double sum = 0;
  SixteenSums row_sum;
  for_plane(A, z, p, scratch,
            [&](std::int64_t at, const float* const* inverse, int x, VF force_x, VF force_y, VF force_z)
                HWY_ATTR {
                  const auto one = [&](int c, VF force) HWY_ATTR {
                    const std::int64_t i = at + c * A.component_stride + x;
                    const auto may_move = hn::Gt(hn::Load(d, inverse[c] + x), hn::Zero(d));
                    const VF value = hn::IfThenElseZero(may_move, force);
                    hn::Store(value, d, q + i);
                    row_sum.add(x, hn::Load(d, p + i), value);
                  };
                  one(0, force_x);
                  one(1, force_y);
                  one(2, force_z);
                  if (x + static_cast<int>(hn::Lanes(d)) >= A.nodes[0]) { // the row's end
                    sum += row_sum.total();
                    row_sum = SixteenSums();
                  }
                });
  return sum;
}

double dot_plane(const BoxOperator& A, int z, const float* a, const float* b) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  double sum = 0;
  for (int y = 0; y < A.nodes[1]; ++y) {
    SixteenSums row_sum;
    for (int c = 0; c < 3; ++c) {
      const std::int64_t at = c * A.component_stride + y * A.row_stride + z * A.slab_stride;
      for (int x = 0; x < A.nodes[0]; x += lanes)
        row_sum.add(x, hn::Load(d, a + at + x), hn::Load(d, b + at + x));
    }
    sum += row_sum.total();
  }
  return sum;
}

void direction_plane(const BoxOperator& A, int z, const float* v, float beta, float step, float* p,
                     float* x) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const VLine factor = hn::Set(d, beta), length = hn::Set(d, step);
  for (int c = 0; c < 3; ++c) {
    const std::int64_t first = c * A.component_stride + z * A.slab_stride;
    for (std::int64_t at = first; at < first + A.slab_stride; at += lanes) {
      if (step != 0)
        hn::Store(hn::MulAdd(length, hn::Load(d, p + at), hn::Load(d, x + at)), d, x + at);
      const VLine towards = hn::Load(d, v + at); // alone where memory of p may never have been touched
      hn::Store(beta == 0 ? towards : hn::MulAdd(factor, hn::Load(d, p + at), towards), d, p + at);
    }
  }
}

double finish_plane(const BoxOperator& A, int z, const BoxSteps& steps, const float* p, const float* q,
                    float* x, float* f, double scale, bool adds, double* u) {
  const Line d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const VLine of_state = hn::Set(d, steps.of_state), of_residual = hn::Set(d, steps.of_residual);
  double sum = 0;
  for (int y = 0; y < A.nodes[1]; ++y) {
    SixteenSums row_sum;
    for (int c = 0; c < 3; ++c) {
      const std::int64_t at = c * A.component_stride + y * A.row_stride + z * A.slab_stride;
      for (int i = 0; i < A.nodes[0]; i += lanes) {
        const VLine state = hn::MulAdd(of_state, hn::Load(d, p + at + i), hn::Load(d, x + at + i));
        const VLine rest = hn::NegMulAdd(of_residual, hn::Load(d, q + at + i), hn::Load(d, f + at + i));
        hn::Store(state, d, x + at + i);
        hn::Store(rest, d, f + at + i);
        row_sum.add(i, state, rest);
      }
      double* const HWY_RESTRICT dense =
          u + (y + std::int64_t{1} * A.nodes[1] * (z + std::int64_t{1} * A.nodes[2] * c)) * A.nodes[0];
      const float* const HWY_RESTRICT found = x + at;
      if (adds)
        for (int i = 0; i < A.nodes[0]; ++i)
          dense[i] += scale * double{found[i]};
      else
        for (int i = 0; i < A.nodes[0]; ++i)
          dense[i] = scale * double{found[i]};
    }
    sum += row_sum.total();
  }
  return sum;
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
HWY_EXPORT(finish_plane);

std::int64_t box_scratch_bytes(const BoxOperator& A) {
  const int row = (A.nodes[0] + line_of_floats - 1) / line_of_floats * line_of_floats;
  return 9 * (row + 2 * line_of_floats) * static_cast<std::int64_t>(sizeof(double));
}
void start_box(const BoxOperator& A, int z, float weight, float step, const float* q, float* f, float* u) {
  HWY_DYNAMIC_DISPATCH(start)(A, z, weight, step, q, f, u);
}
void relax_box(const BoxOperator& A, int z, float weight, const float* f, const float* u, float* next,
               void* scratch) {
  HWY_DYNAMIC_DISPATCH(relax)(A, z, weight, f, u, next, scratch);
}
void find_box_residual(const BoxOperator& A, int z, const float* f, const float* u, float* r, void* scratch) {
  HWY_DYNAMIC_DISPATCH(residual_of)(A, z, f, u, r, scratch);
}
double apply_box_and_dot(const BoxOperator& A, int z, const float* p, float* q, void* scratch) {
  return HWY_DYNAMIC_DISPATCH(apply)(A, z, p, q, scratch);
}
double dot_box(const BoxOperator& A, int z, const float* a, const float* b) {
  return HWY_DYNAMIC_DISPATCH(dot_plane)(A, z, a, b);
}
void update_box_direction(const BoxOperator& A, int z, const float* v, float beta, float step, float* p,
                          float* x) {
  HWY_DYNAMIC_DISPATCH(direction_plane)(A, z, v, beta, step, p, x);
}
double finish_box(const BoxOperator& A, int z, const BoxSteps& steps, const float* p, const float* q,
                  float* x, float* f, double scale, bool adds, double* u) {
  return HWY_DYNAMIC_DISPATCH(finish_plane)(A, z, steps, p, q, x, f, scale, adds, u);
}

} // namespace maille::deform
#endif
