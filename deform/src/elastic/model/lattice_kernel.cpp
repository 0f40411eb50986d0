#include "elastic/model/lattice_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/model/lattice_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Every cell is
// computed by the same operations in vectors of any length, and what the two cells beside a node pull with is
// added to it at once; so bits depend on whether the machine fuses products with sums, not on vectors.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Many = hn::CappedTag<double, 4>;
using One = hn::CappedTag<double, 1>;

/// Forces of cells at their lower and upper corners along x, by component and row of nodes: y + 2 z.
struct Pulls {
  double lower[3][4][most_cells], upper[3][4][most_cells];
};

/// Values of one component: edges along x, and sums and differences over the eight corners.
template<class D>
struct Corners {
  using V = hn::VFromD<D>;
  V lower[4], upper[4], along_x, along_y, along_z, yz, xz, xy;

  HWY_INLINE Corners(D d, const double* u, const std::int64_t* row, int x) {
    V sum[4], edge[4];
    for (int r = 0; r < 4; ++r) {
      lower[r] = hn::LoadU(d, u + row[r] + x);
      upper[r] = hn::LoadU(d, u + row[r] + x + 1);
      sum[r] = hn::Add(lower[r], upper[r]);
      edge[r] = hn::Sub(upper[r], lower[r]);
    }
    const V low = hn::Add(edge[0], edge[1]), high = hn::Add(edge[2], edge[3]);
    along_x = hn::Add(low, high);
    xz = hn::Sub(high, low);
    xy = hn::Add(hn::Sub(edge[1], edge[0]), hn::Sub(edge[3], edge[2]));
    const V y_low = hn::Sub(sum[1], sum[0]), y_high = hn::Sub(sum[3], sum[2]);
    along_y = hn::Add(y_low, y_high);
    yz = hn::Sub(y_high, y_low);
    along_z = hn::Add(hn::Sub(sum[2], sum[0]), hn::Sub(sum[3], sum[1]));
  }
};

/// +-a by a row's side along y or z.
template<class D, class V>
HWY_INLINE V by_side(D, bool is_upper, V a) {
  return is_upper ? a : hn::Neg(a);
}

/// Forces of the cells from x on.
template<class D>
HWY_INLINE void find_pulls(D d, const LatticeRun& run, const std::int64_t* row, int x, Pulls& pulls) {
  using V = hn::VFromD<D>;
  const Corners<D> of_x(d, run.u[0], row, x), of_y(d, run.u[1], row, x), of_z(d, run.u[2], row, x);
  const V h[3] = {hn::Set(d, run.per_length[0]), hn::Set(d, run.per_length[1]),
                  hn::Set(d, run.per_length[2])};
  const V quarter = hn::Set(d, 0.25), half = hn::Set(d, 0.5);
  const V per[3] = {hn::Mul(quarter, h[0]), hn::Mul(quarter, h[1]), hn::Mul(quarter, h[2])};
  const V strain[6] = {hn::Mul(per[0], of_x.along_x),
                       hn::Mul(per[1], of_y.along_y),
                       hn::Mul(per[2], of_z.along_z),
                       hn::MulAdd(per[1], of_z.along_y, hn::Mul(per[2], of_y.along_z)),
                       hn::MulAdd(per[0], of_z.along_x, hn::Mul(per[2], of_x.along_z)),
                       hn::MulAdd(per[0], of_y.along_x, hn::Mul(per[1], of_x.along_y))};
  V stress[6];
  for (int p = 0; p < 6; ++p) {
    stress[p] = hn::Mul(hn::Set(d, run.mean[mean_coefficient(p, 0)]), strain[0]);
    for (int q = 1; q < 6; ++q)
      stress[p] = hn::MulAdd(hn::Set(d, run.mean[mean_coefficient(p, q)]), strain[q], stress[p]);
  }
  // Twist across an axis: the difference of the shears of the two faces, times its stiffness.
  const auto twist = [&](int across, V one, V other) HWY_ATTR {
    return hn::Mul(hn::Set(d, run.shear[across]), hn::Mul(half, hn::Add(one, other)));
  };
  const V twist_x = twist(0, hn::Mul(of_y.xz, h[2]), hn::Mul(of_z.xy, h[1])),
          twist_y = twist(1, hn::Mul(of_x.yz, h[2]), hn::Mul(of_z.xy, h[0])),
          twist_z = twist(2, hn::Mul(of_x.yz, h[1]), hn::Mul(of_y.xz, h[0]));
  const auto turn = [&](V one, V of_one, V other, V of_other)
                        HWY_ATTR { return hn::Mul(half, hn::MulAdd(one, of_one, hn::Mul(other, of_other))); };
  const V turn_x = turn(twist_z, h[1], twist_y, h[2]), turn_y = turn(twist_z, h[0], twist_x, h[2]),
          turn_z = turn(twist_y, h[0], twist_x, h[1]);
  const V edge[3] = {hn::Set(d, run.edge[0]), hn::Set(d, run.edge[1]), hn::Set(d, run.edge[2])};
  for (int r = 0; r < 4; ++r) {
    const bool is_y = (r & 1) != 0, is_z = (r & 2) != 0;
    const auto even = [&](int along_y, int along_z) HWY_ATTR {
      return hn::Add(by_side(d, is_y, hn::Mul(per[1], stress[along_y])),
                     by_side(d, is_z, hn::Mul(per[2], stress[along_z])));
    };
    const auto put = [&](int component, V all, V odd, V of_lower, V of_upper) HWY_ATTR {
      hn::StoreU(hn::Add(hn::Sub(all, odd), of_lower), d, pulls.lower[component][r] + x);
      hn::StoreU(hn::Add(hn::Add(all, odd), of_upper), d, pulls.upper[component][r] + x);
    };
    const V along_x = hn::Mul(edge[0], hn::Sub(of_x.upper[r], of_x.lower[r]));
    put(0, hn::Add(even(5, 4), by_side(d, is_y == is_z, turn_x)), hn::Mul(per[0], stress[0]),
        hn::Neg(along_x), along_x);
    const int low_y = r & 2, low_z = r & 1; // the first node of the row's edges along y and z
    put(1, even(1, 3), hn::Add(hn::Mul(per[0], stress[5]), by_side(d, is_z, turn_y)),
        by_side(d, is_y, hn::Mul(edge[1], hn::Sub(of_y.lower[low_y + 1], of_y.lower[low_y]))),
        by_side(d, is_y, hn::Mul(edge[1], hn::Sub(of_y.upper[low_y + 1], of_y.upper[low_y]))));
    put(2, even(3, 2), hn::Add(hn::Mul(per[0], stress[4]), by_side(d, is_y, turn_z)),
        by_side(d, is_z, hn::Mul(edge[2], hn::Sub(of_z.lower[low_z + 2], of_z.lower[low_z]))),
        by_side(d, is_z, hn::Mul(edge[2], hn::Sub(of_z.upper[low_z + 2], of_z.upper[low_z]))));
  }
}

void add_run(const LatticeRun& run) {
  const std::int64_t row[4] = {0, run.next_y, run.next_z, run.next_y + run.next_z};
  const Many many;
  const int lanes = static_cast<int>(hn::Lanes(many));
  Pulls pulls;
  for (int first = 0; first < run.cells; first += most_cells) {
    const int n = std::min(most_cells, run.cells - first);
    LatticeRun part = run;
    for (int c = 0; c < 3; ++c)
      part.u[c] += first;
    int x = 0;
    for (; x + lanes <= n; x += lanes)
      find_pulls(many, part, row, x, pulls);
    if (x < n && n >= lanes)
      find_pulls(many, part, row, n - lanes, pulls); // some of them once more
    else
      for (; x < n; ++x)
        find_pulls(One(), part, row, x, pulls);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 4; ++r) {
        double* const to = run.forces[c] + row[r] + first;
        const double *const lower = pulls.lower[c][r], *const upper = pulls.upper[c][r];
        to[0] += lower[0];
        for (int i = 1; i < n; ++i)
          to[i] += lower[i] + upper[i - 1];
        to[n] += upper[n - 1];
      }
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add_run);

void add_run_forces(const LatticeRun& run) {
  HWY_DYNAMIC_DISPATCH(add_run)(run);
}

} // namespace maille::deform
#endif
