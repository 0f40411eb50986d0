#include "elastic/finite/law_kernel.hpp"

#include "elastic/finite/tangent_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/finite/law_kernel.cpp"
#include <hwy/foreach_target.h>

#include "elastic/finite/cell_kernel-inl.hpp"

#include <hwy/contrib/math/math-inl.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

/// The state of a vector of cells. Matrices by columns.
template<class D>
struct LawState {
  using V = hn::VFromD<D>;
  V H[9], h[4][3];
  V F[9], G[9], J, L;
  V f[4][3]; ///< K F^T h

  HWY_INLINE LawState(D tag, const LawRun& run, int x) {
    find_modes<3>(tag, run, x, H, h);
    const V one = hn::Set(tag, 1);
    for (int i = 0; i < 9; ++i)
      F[i] = i % 4 == 0 ? hn::Add(H[i], one) : H[i];
    cofactors(F, G);
    J = dot(F, G);
    V of_H[9];
    cofactors(H, of_H); // J - 1 keeps all digits at small strains
    const V beyond_1 = hn::Add(hn::Add(trace(H), trace(of_H)), dot(H, of_H));
    L = hn::Log1p(tag, beyond_1);
    const V inverse = hn::Div(one, J);
    for (V& g : G)
      g = hn::Mul(g, inverse);
    V w[12], sum[12];
    for (int k = 0; k < 4; ++k)
      for (int b = 0; b < 3; ++b) {
        w[3 * k + b] =
            hn::MulAdd(F[3 * b], h[k][0], hn::MulAdd(F[3 * b + 1], h[k][1], hn::Mul(F[3 * b + 2], h[k][2])));
        sum[3 * k + b] = hn::Zero(tag);
      }
    const V weight = hn::LoadU(tag, run.weight + x);
    for (int at = 0; at < run.n_pairs; ++at) {
      const auto& [i, j] = run.pairs[at];
      const V K = hn::Mul(weight, hn::Set(tag, run.beyond[at]));
      sum[i] = hn::MulAdd(K, w[j], sum[i]);
      if (i != j)
        sum[j] = hn::MulAdd(K, w[i], sum[j]);
    }
    of_beyond = hn::Zero(tag);
    for (int i = 0; i < 12; ++i) {
      f[i / 3][i % 3] = sum[i];
      of_beyond = hn::MulAdd(w[i], sum[i], of_beyond);
    }
    V squares = hn::Zero(tag);
    for (const V& of : H)
      squares = hn::MulAdd(of, of, squares);
    trace_E = hn::MulAdd(hn::Set(tag, 0.5), squares, trace(H));
  }
  V of_beyond; ///< w . K w
  V trace_E;

private:
  static HWY_INLINE void cofactors(const V* A, V* of) {
    for (int a = 0; a < 3; ++a) {
      const V *const p = A + 3 * ((a + 1) % 3), *const q = A + 3 * ((a + 2) % 3);
      for (int b = 0; b < 3; ++b) {
        const int c = (b + 1) % 3, e = (b + 2) % 3;
        of[3 * a + b] = hn::Sub(hn::Mul(p[c], q[e]), hn::Mul(p[e], q[c]));
      }
    }
  }
  /// Of the first columns: the determinant, if the second are cofactors.
  static HWY_INLINE V dot(const V* a, const V* b) {
    return hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
  }
  static HWY_INLINE V trace(const V* A) { return hn::Add(A[0], hn::Add(A[4], A[8])); }
};

template<class D>
HWY_INLINE void evaluate_at(D tag, const LawRun& run, int x, Pulls& pulls) {
  using V = hn::VFromD<D>;
  const LawState<D> at(tag, run, x);
  const V mu = hn::Set(tag, run.mu), lambda = hn::Set(tag, run.lambda),
          V_cell = hn::Mul(hn::Set(tag, run.volume), hn::LoadU(tag, run.weight + x)),
          half = hn::Set(tag, 0.5), half_L = hn::Mul(half, at.L);
  const V W = hn::MulAdd(mu, hn::Sub(at.trace_E, at.L), hn::Mul(hn::Mul(lambda, half_L), at.L));
  hn::StoreU(at.J, tag, run.determinant + x);
  hn::StoreU(hn::MulAdd(V_cell, W, hn::Mul(half, at.of_beyond)), tag, run.energy + x);
  const V of_G = hn::MulSub(lambda, at.L, mu);
  V P[9], q[4][3];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int i = 3 * a + b;
      P[i] = hn::Mul(V_cell, hn::MulAdd(mu, at.F[i], hn::Mul(of_G, at.G[i])));
      for (int k = 0; k < 4; ++k)
        P[i] = hn::MulAdd(at.h[k][b], at.f[k][a], P[i]);
    }
  for (int k = 0; k < 4; ++k)
    for (int b = 0; b < 3; ++b)
      q[k][b] = hn::MulAdd(at.F[b], at.f[k][0],
                           hn::MulAdd(at.F[3 + b], at.f[k][1], hn::Mul(at.F[6 + b], at.f[k][2])));
  put_pulls<3>(tag, run, x, P, q, pulls);
}

/// The least pivot of the Cholesky factor of A + shift, or a negative one.
template<class D, class V = hn::VFromD<D>>
HWY_INLINE V least_pivot(D tag, V (&A)[9][9], V shift) {
  V least = hn::Set(tag, 1e300);
  for (int i = 0; i < 9; ++i) {
    const V pivot = hn::Add(A[i][i], shift), inverse = hn::Div(hn::Set(tag, 1), pivot);
    least = hn::Min(least, pivot);
    for (int j = i + 1; j < 9; ++j) {
      const V part = hn::Mul(A[i][j], inverse);
      for (int k = j; k < 9; ++k)
        A[j][k] = hn::NegMulAdd(part, A[i][k], A[j][k]);
    }
  }
  return least;
}

template<class D>
HWY_INLINE void linearise_at(D tag, const LawRun& run, int x) {
  using V = hn::VFromD<D>;
  using Numbers = TangentNumbers<3>;
  const hn::Rebind<float, D> floats;
  const auto put = [&](int k, V number) HWY_ATTR {
    hn::StoreU(hn::DemoteTo(floats, number), floats, run.found + k * run.row + x);
  };
  const LawState<D> at(tag, run, x);
  const V mu = hn::Set(tag, run.mu), lambda = hn::Set(tag, run.lambda),
          weight = hn::LoadU(tag, run.weight + x), V_cell = hn::Mul(hn::Set(tag, run.volume), weight),
          of_volume = hn::Mul(hn::Set(tag, run.kappa), at.L);
  const V pressure = run.has_pressures ? hn::LoadU(tag, run.pressure + x) : of_volume;
  hn::StoreU(pressure, tag, run.pressure + x);
  hn::StoreU(of_volume, tag, run.volume_pressure + x);
  const V q = hn::Add(hn::Mul(lambda, at.L), hn::Sub(pressure, of_volume)), twist = hn::Sub(mu, q);
  V A[9][9], largest = hn::Zero(tag);
  for (int i = 0, k = 0; i < 9; ++i)
    for (int j = i; j < 9; ++j, ++k) {
      const int across = 3 * (j / 3) + i % 3, along = 3 * (i / 3) + j % 3; // G_bc, G_ea
      V of = hn::Mul(hn::Mul(lambda, at.G[i]), at.G[j]);
      of = hn::MulAdd(hn::Mul(twist, at.G[across]), at.G[along], of);
      A[i][j] = i == j ? hn::Add(of, mu) : of;
      put(k, hn::Mul(V_cell, A[i][j]));
      largest = i == j ? hn::Max(largest, hn::Abs(A[i][j])) : largest;
    }
  const V zero = hn::Zero(tag);
  for (int i = 0; i < 9; ++i)
    put(Numbers::F + i, at.F[i]);
  for (int i = 0; i < 12; ++i) {
    put(Numbers::h + i, run.is_exact ? at.h[i / 3][i % 3] : zero);
    put(Numbers::f + i, run.is_exact ? at.f[i / 3][i % 3] : zero);
  }
  for (int pair = 0; pair < run.n_pairs; ++pair)
    put(Numbers::K + pair, hn::Mul(weight, hn::Set(tag, run.beyond[pair])));
  if (!run.is_exact)
    hn::StoreU(least_pivot(tag, A, hn::Mul(hn::Set(tag, run.least_part), largest)), tag, run.determinant + x);
}

void evaluate_run(const LawRun& run) {
  Pulls pulls;
  for_each_vector(run.cells, [&](auto tag, int x) HWY_ATTR { evaluate_at(tag, run, x, pulls); });
  add_pulls<3>(run, pulls);
}

void linearise_run(const LawRun& run) {
  for_each_vector(run.cells, [&](auto tag, int x) HWY_ATTR { linearise_at(tag, run, x); });
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(evaluate_run);
HWY_EXPORT(linearise_run);

void evaluate_law(const LawRun& run) {
  HWY_DYNAMIC_DISPATCH(evaluate_run)(run);
}

void linearise_law(const LawRun& run) {
  HWY_DYNAMIC_DISPATCH(linearise_run)(run);
}

} // namespace maille::deform
#endif
