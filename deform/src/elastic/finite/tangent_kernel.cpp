#include "elastic/finite/tangent_kernel.hpp"

#include "elastic/model/lattice_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/finite/tangent_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Many = hn::CappedTag<double, 4>;
using One = hn::CappedTag<double, 1>;

/// What cells pull with at their nodes, at their own place and at the next, by component and row of nodes.
using Pulls = double[2][3][4][most_cells + 1];

HWY_INLINE constexpr int bits(int of) {
  return (of & 1) + (of >> 1 & 1) + (of >> 2 & 1);
}

template<int n, class V>
HWY_INLINE void transform(V* values) {
  for (int half = 1; half < n; half *= 2)
    for (int i = 0; i < n; ++i)
      if ((i & half) == 0) {
        const V low = values[i], high = values[i | half];
        values[i] = hn::Add(high, low);
        values[i | half] = hn::Sub(high, low);
      }
}

/// Pulls of the cells from x on. See CellModes for the modes.
template<int d, class D>
HWY_INLINE void find_pulls(D tag, const TangentRun& run, int x, Pulls& pulls) {
  using V = hn::VFromD<D>;
  using At = TangentNumbers<d>;
  constexpr int g = d * d, n_beyond = At::n_beyond, n = n_beyond + 1 + d;
  constexpr int beyond[4] = {3, 5, 6, 7};
  const hn::Rebind<float, D> floats;
  const auto number = [&](int k) HWY_ATTR {
    return hn::PromoteTo(tag, hn::LoadU(floats, run.numbers + k * run.row + x));
  };
  const V zero = hn::Zero(tag);
  V mode[d][n], dH[g], F[g], dP[g];
  for (int b = 0; b < d; ++b) {
    const V first = hn::LoadU(tag, run.u[b] + x);
    mode[b][0] = zero;
    for (int corner = 1; corner < n; ++corner)
      mode[b][corner] = hn::Sub(hn::LoadU(tag, run.u[b] + run.corner[corner] + x), first);
    transform<n>(mode[b]);
    for (int a = 0; a < d; ++a)
      dH[d * a + b] = hn::Mul(hn::Set(tag, 2 * run.per_length[a] / n), mode[b][1 << a]);
    for (int k = 0; k < n_beyond; ++k)
      mode[b][beyond[k]] = hn::Mul(hn::Set(tag, 1.0 / n), mode[b][beyond[k]]);
  }
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
        sum = hn::MulAdd(F[d * b + c], mode[c][beyond[k]], hn::MulAdd(dH[d * b + c], h[k][c], sum));
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
    V pull[n];
    pull[0] = zero;
    for (int a = 0; a < d; ++a) {
      V sum = dP[d * a + b];
      for (int k = 0; k < n_beyond; ++k)
        sum = hn::MulAdd(mode[b][beyond[k]], f[k][a], hn::MulAdd(h[k][b], df[3 * k + a], sum));
      pull[1 << a] = hn::Mul(hn::Set(tag, 2 * run.per_length[a] / n), sum);
    }
    for (int k = 0; k < n_beyond; ++k) {
      V sum = zero;
      for (int a = 0; a < d; ++a)
        sum = hn::MulAdd(dH[d * a + b], f[k][a], hn::MulAdd(F[d * a + b], df[3 * k + a], sum));
      pull[beyond[k]] = hn::Mul(hn::Set(tag, 1.0 / n), sum);
    }
    for (int m = 0; m < n; ++m)
      pull[m] = bits(m) % 2 != 0 ? hn::Neg(pull[m]) : pull[m];
    transform<n>(pull);
    for (int corner = 0; corner < n; ++corner) {
      const V signed_pull = bits(corner) % 2 != 0 ? hn::Neg(pull[corner]) : pull[corner];
      hn::StoreU(signed_pull, tag, pulls[corner & 1][b][corner >> 1] + x + (corner & 1));
    }
  }
}

/// Cells are computed twice where vectors overlap at the end of a run, with the same result.
template<int d, class D>
HWY_INLINE void find_all(D tag, const TangentRun& run, Pulls& pulls) {
  const int lanes = static_cast<int>(hn::Lanes(tag));
  for (int x = 0; x < run.cells; x += lanes)
    find_pulls<d>(tag, run, x < run.cells - lanes ? x : run.cells - lanes, pulls);
}

template<int d>
HWY_INLINE void add_part(const TangentRun& run) {
  Pulls pulls;
  const Many many;
  if (run.cells >= static_cast<int>(hn::Lanes(many)))
    find_all<d>(many, run, pulls);
  else
    find_all<d>(One(), run, pulls);
  const int n = run.cells;
  for (int b = 0; b < d; ++b)
    for (int row = 0; row < 1 << (d - 1); ++row) {
      double *const to = run.forces[b] + run.corner[2 * row], *const lower = pulls[0][b][row],
                    *const upper = pulls[1][b][row];
      lower[n] = upper[0] = 0;
      for (int i = 0; i <= n; ++i)
        to[i] += lower[i] + upper[i];
    }
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
