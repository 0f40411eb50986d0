#include "elastic/box/box_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/box/box_double_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "elastic/box/box_plane-inl.hpp"

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

using G = hn::CappedTag<double, line_of_floats / 2>;
using VG = hn::VFromD<G>;

/// Loads from a row of n numbers, with zeros beyond its ends.
struct LoadDense {
  int n;
  HWY_INLINE VG operator()(const double* row, int x) const {
    const G d;
    if (x + static_cast<int>(hn::Lanes(d)) <= n)
      return hn::LoadU(d, row + x);
    alignas(64) double end[line_of_floats / 2] = {};
    for (int i = x; i < n; ++i)
      end[i - x] = row[i];
    return hn::Load(d, end);
  }
};

/// Loads from a padded row of float32, widened to float64.
struct LoadWidened {
  HWY_INLINE VG operator()(const float* row, int x) const {
    const hn::Rebind<float, G> narrow;
    return hn::PromoteTo(G(), hn::LoadU(narrow, row + x));
  }
};

double begin_double(const BoxOperator& A, int z, const float* pulls, const float* u, float* f,
                    void* scratch) {
  constexpr int n_parts = line_of_floats / 2; // of sums, whatever the length of vectors
  const G d;
  const hn::Rebind<float, G> narrow;
  const LoadWidened load;
  const BoxPlane<G, LoadWidened> plane(A, A.axis[0], scratch);
  alignas(64) double parts[3][n_parts] = {};
  for (int y = 0; y < A.nodes[1]; ++y) {
    const std::int64_t at = y * A.row_stride + z * A.slab_stride, row = y + std::int64_t{1} * A.nodes[1] * z;
    const float* const of_u[3] = {u + at, u + at + A.component_stride, u + at + 2 * A.component_stride};
    plane.for_row(y, z, of_u, A.row_stride, A.slab_stride, load,
                  [&](int x, VG force_x, VG force_y, VG force_z) HWY_ATTR {
                    const auto one = [&](int c, VG force) HWY_ATTR {
                      const std::int64_t i = at + c * A.component_stride + x;
                      double* const part = parts[c] + x % n_parts;
                      hn::Store(hn::MulAdd(load(of_u[c], x), force, hn::Load(d, part)), d, part);
                      const VG pull =
                          pulls == nullptr ? hn::Zero(d) : hn::PromoteTo(d, hn::LoadU(narrow, pulls + i));
                      const auto rest = hn::DemoteTo(narrow, hn::Sub(pull, force));
                      const auto may_move =
                          hn::Gt(hn::LoadU(narrow, A.inverse[c][row] + x), hn::Zero(narrow));
                      hn::StoreU(hn::IfThenElseZero(may_move, rest), narrow, f + i);
                    };
                    one(0, force_x);
                    one(1, force_y);
                    one(2, force_z);
                  });
  }
  double sum = 0;
  for (const auto& of_component : parts)
    for (const double part : of_component)
      sum += part;
  return sum;
}

void apply_double(const BoxOperator& A, int z, const double* u, double* forces, void* scratch) {
  const G d;
  const int lanes = static_cast<int>(hn::Lanes(d)), nx = A.nodes[0];
  const LoadDense load{nx};
  const BoxPlane<G, LoadDense> plane(A, A.axis[0], scratch);
  const std::int64_t slab = std::int64_t{1} * nx * A.nodes[1], component = slab * A.nodes[2];
  for (int y = 0; y < A.nodes[1]; ++y) {
    const double* const first = u + y * nx + z * slab;
    const double* const of_u[3] = {first, first + component, first + 2 * component};
    double* const row = forces + y * nx;
    plane.for_row(y, z, of_u, nx, slab, load, [&](int x, VG force_x, VG force_y, VG force_z) HWY_ATTR {
      const auto one = [&](double* target, VG force) HWY_ATTR {
        if (x + lanes <= nx) {
          hn::StoreU(force, d, target + x);
          return;
        }
        alignas(64) double end[line_of_floats / 2];
        hn::Store(force, d, end);
        for (int i = x; i < nx; ++i)
          target[i] = end[i - x];
      };
      one(row, force_x);
      one(row + slab, force_y);
      one(row + 2 * slab, force_z);
    });
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(begin_double);
HWY_EXPORT(apply_double);

double begin_box(const BoxOperator& A, int z, const float* pulls, const float* u, float* f, void* scratch) {
  return HWY_DYNAMIC_DISPATCH(begin_double)(A, z, pulls, u, f, scratch);
}
void apply_box(const BoxOperator& A, int z, const double* u, double* forces, void* scratch) {
  HWY_DYNAMIC_DISPATCH(apply_double)(A, z, u, forces, scratch);
}

} // namespace maille::deform
#endif
