#include "elastic/finite/tangent_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/finite/tangent_kernel.cpp"
#include <hwy/foreach_target.h>

#include "elastic/finite/cell_kernel-inl.hpp"

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

/// Forces of the cells from x on. See CellModes for the modes.
template<int d, class D>
HWY_INLINE void find_pulls(D tag, const TangentRun& run, int x, Pulls& pulls) {
  using V = hn::VFromD<D>;
  using At = TangentNumbers<d>;
  constexpr int g = d * d, n_beyond = At::n_beyond;
  const hn::Rebind<float, D> floats;
  const auto number = [&](int k) HWY_ATTR {
    return hn::PromoteTo(tag, hn::LoadU(floats, run.numbers + k * run.row + x));
  };
  const V zero = hn::Zero(tag);
  V dH[g], dh[n_beyond + 1][d], F[g], dP[g], dq[n_beyond + 1][d];
  find_modes<d>(tag, run, x, dH, dh);
  for (int i = 0; i < g; ++i)
    dP[i] = zero;
  for (int i = 0, k = 0; i < g; ++i) {
    dP[i] = hn::MulAdd(number(k++), dH[i], dP[i]);
    for (int j = i + 1; j < g; ++j, ++k) {
      const V A = number(k);
      dP[i] = hn::MulAdd(A, dH[j], dP[i]);
      dP[j] = hn::MulAdd(A, dH[i], dP[j]);
    }
  }
  V h[n_beyond + 1][d], f[n_beyond + 1][d], w[4 * 3], df[4 * 3];
  for (int i = 0; i < g; ++i)
    F[i] = number(At::F + i);
  for (int k = 0; k < n_beyond; ++k)
    for (int b = 0; b < d; ++b) {
      h[k][b] = number(At::h + d * k + b);
      f[k][b] = number(At::f + d * k + b);
      df[3 * k + b] = zero;
    }
  for (int k = 0; k < n_beyond; ++k)
    for (int b = 0; b < d; ++b) {
      V sum = zero;
      for (int c = 0; c < d; ++c)
        sum = hn::MulAdd(F[d * b + c], dh[k][c], hn::MulAdd(dH[d * b + c], h[k][c], sum));
      w[3 * k + b] = sum;
    }
  int at = At::K;
  for (const BeyondPair* pair = run.pairs; pair < run.pairs + run.n_pairs; ++pair) {
    const auto& [i, j] = *pair;
    const V K = number(at++);
    df[i] = hn::MulAdd(K, w[j], df[i]);
    if (i != j)
      df[j] = hn::MulAdd(K, w[i], df[j]);
  }
  for (int b = 0; b < d; ++b) {
    for (int a = 0; a < d; ++a)
      for (int k = 0; k < n_beyond; ++k)
        dP[d * a + b] = hn::MulAdd(dh[k][b], f[k][a], hn::MulAdd(h[k][b], df[3 * k + a], dP[d * a + b]));
    for (int k = 0; k < n_beyond; ++k) {
      V sum = zero;
      for (int a = 0; a < d; ++a)
        sum = hn::MulAdd(dH[d * a + b], f[k][a], hn::MulAdd(F[d * a + b], df[3 * k + a], sum));
      dq[k][b] = sum;
    }
  }
  put_pulls<d>(tag, run, x, dP, dq, pulls);
}

template<int d>
HWY_INLINE void add_part(const TangentRun& run) {
  Pulls pulls;
  for_each_vector(run.cells, [&](auto tag, int x) HWY_ATTR { find_pulls<d>(tag, run, x, pulls); });
  add_pulls<d>(run, pulls);
}

void add_run(const TangentRun& run) {
  for (int first = 0; first < run.cells; first += most_cells) {
    TangentRun part = run;
    part.cells = run.cells - first < most_cells ? run.cells - first : most_cells;
    part.numbers += first;
    for (int b = 0; b < run.dimension; ++b) {
      part.u[b] += first;
      part.forces[b] += first;
    }
    if (run.dimension == 3)
      add_part<3>(part);
    else if (run.dimension == 2)
      add_part<2>(part);
    else
      add_part<1>(part);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(add_run);

void add_tangent_forces(const TangentRun& run) {
  HWY_DYNAMIC_DISPATCH(add_run)(run);
}

} // namespace maille::deform
#endif
