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
  V f[4][3];               ///< K F^T h
  V of_beyond;             ///< w . K w
  V R[9], U[9], strain[9]; ///< of find_polar(): F = R U, U - I

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
  }
  /// F = R U, and U - I with all its digits: 2 E (U + I)^-1. R by Newton's steps X = (X + X^-T) / 2, of every
  /// cell by itself.
  /// Source  Higham 1986 (SIAM J. Sci. Stat. Comput. 7), for the steps
  HWY_INLINE void find_polar(D tag) {
    const V one = hn::Set(tag, 1), half = hn::Set(tag, 0.5);
    for (int i = 0; i < 9; ++i)
      R[i] = F[i];
    auto should_continue = hn::Gt(J, hn::Zero(tag));
    for (int step = 0; step < 40 && !hn::AllFalse(tag, should_continue); ++step) {
      V next[9], change = hn::Zero(tag);
      cofactors(R, next);
      const V factor = hn::Div(one, dot(R, next));
      for (int i = 0; i < 9; ++i) {
        next[i] = hn::Mul(half, hn::MulAdd(factor, next[i], R[i]));
        change = hn::Max(change, hn::Abs(hn::Sub(next[i], R[i])));
        R[i] = hn::IfThenElse(should_continue, next[i], R[i]);
      }
      should_continue =
          hn::And(should_continue, hn::Gt(change, hn::Set(tag, 1e-8))); // the next one is its square
    }
    V sum[9], inverse[9], E[9];
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        U[3 * i + j] = U[3 * j + i] = dot(R + 3 * i, F + 3 * j);
        sum[3 * i + j] = sum[3 * j + i] = i == j ? hn::Add(U[3 * i + j], one) : U[3 * i + j];
      }
    invert_symmetric(tag, sum, inverse);
    find_E(tag, E);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        strain[3 * i + j] = hn::Mul(hn::Set(tag, 2), dot(E + 3 * i, inverse + 3 * j));
  }

  static HWY_INLINE void cofactors(const V* A, V* of) {
    for (int a = 0; a < 3; ++a) {
      const V *const p = A + 3 * ((a + 1) % 3), *const q = A + 3 * ((a + 2) % 3);
      for (int b = 0; b < 3; ++b) {
        const int c = (b + 1) % 3, e = (b + 2) % 3;
        of[3 * a + b] = hn::Sub(hn::Mul(p[c], q[e]), hn::Mul(p[e], q[c]));
      }
    }
  }
  /// Product of the first columns: the determinant, if the second are cofactors.
  static HWY_INLINE V dot(const V* a, const V* b) {
    return hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
  }
  static HWY_INLINE V trace(const V* A) { return hn::Add(A[0], hn::Add(A[4], A[8])); }
  static HWY_INLINE void invert_symmetric(D tag, const V* A, V* inverse) {
    cofactors(A, inverse);
    const V factor = hn::Div(hn::Set(tag, 1), dot(A, inverse));
    for (int i = 0; i < 9; ++i)
      inverse[i] = hn::Mul(inverse[i], factor);
  }
  /// Green and Lagrange's strain.
  HWY_INLINE void find_E(D tag, V* E) const {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        E[3 * i + j] = hn::Mul(hn::Set(tag, 0.5),
                               hn::Add(hn::Add(H[3 * i + j], H[3 * j + i]), dot(H + 3 * i, H + 3 * j)));
  }
};

template<class D>
HWY_INLINE void evaluate_at(D tag, const LawRun& run, int x, Pulls& pulls) {
  using V = hn::VFromD<D>;
  LawState<D> at(tag, run, x);
  const V mu = hn::Set(tag, run.mu), lambda = hn::Set(tag, run.lambda),
          V_cell = hn::Mul(hn::Set(tag, run.volume), hn::LoadU(tag, run.weight + x)),
          half = hn::Set(tag, 0.5);
  V W, P[9], q[4][3];
  if (run.is_corotated) {
    at.find_polar(tag);
    const V twice = hn::Add(mu, mu), trace = at.trace(at.strain), of_R = hn::Mul(lambda, trace);
    W = hn::Mul(hn::Mul(half, of_R), trace);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        V sum = hn::Zero(tag); // of R (U - I)
        for (int c = 0; c < 3; ++c)
          sum = hn::MulAdd(at.R[3 * c + b], at.strain[3 * a + c], sum);
        P[3 * a + b] = hn::MulAdd(twice, sum, hn::Mul(of_R, at.R[3 * a + b]));
        W = hn::MulAdd(hn::Mul(mu, at.strain[3 * a + b]), at.strain[3 * a + b], W);
      }
  } else {
    V E[9];
    at.find_E(tag, E);
    const V of_G = hn::MulSub(lambda, at.L, mu);
    W = hn::MulAdd(mu, hn::Sub(at.trace(E), at.L), hn::Mul(hn::Mul(lambda, hn::Mul(half, at.L)), at.L));
    for (int i = 0; i < 9; ++i)
      P[i] = hn::MulAdd(mu, at.F[i], hn::Mul(of_G, at.G[i]));
  }
  hn::StoreU(at.J, tag, run.determinant + x);
  hn::StoreU(hn::MulAdd(V_cell, W, hn::Mul(half, at.of_beyond)), tag, run.energy + x);
  for (int i = 0; i < 9; ++i) {
    P[i] = hn::Mul(V_cell, P[i]);
    for (int k = 0; k < 4; ++k)
      P[i] = hn::MulAdd(at.h[k][i % 3], at.f[k][i / 3], P[i]);
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
  LawState<D> at(tag, run, x);
  const V weight = hn::LoadU(tag, run.weight + x), V_cell = hn::Mul(hn::Set(tag, run.volume), weight),
          of_volume = hn::Mul(hn::Set(tag, run.kappa), at.L);
  const V pressure = run.has_pressures ? hn::LoadU(tag, run.pressure + x) : of_volume;
  hn::StoreU(pressure, tag, run.pressure + x);
  hn::StoreU(of_volume, tag, run.volume_pressure + x);
  // A = of_I + lambda N (.) N + twist G x G + the sum of turns (.) turned. Turns, by which R changes, are
  // R [e_k]x.
  const V mu = hn::Set(tag, run.mu), lambda = hn::Set(tag, run.lambda), zero = hn::Zero(tag),
          beyond = hn::Sub(pressure, of_volume);
  const V of_I = run.is_corotated ? hn::Add(mu, mu) : mu,
          twist = run.is_corotated ? hn::Neg(beyond) : hn::Sub(mu, hn::MulAdd(lambda, at.L, beyond));
  const V* const N = run.is_corotated ? at.R : at.G;
  V turns[3][9], turned[3][9];
  if (run.is_corotated) {
    at.find_polar(tag);
    V M[9], Z[9];
    const V trace = at.trace(at.U), stiff = hn::MulSub(lambda, at.trace(at.strain), of_I);
    for (int i = 0; i < 9; ++i)
      M[i] = i % 4 == 0 ? hn::Sub(trace, at.U[i]) : hn::Neg(at.U[i]);
    at.invert_symmetric(tag, M, Z);
    for (int k = 0; k < 3; ++k) // the columns 0, R e_(k+2), -R e_(k+1) from k on
      for (int b = 0; b < 3; ++b) {
        const int p = (k + 1) % 3, r = (k + 2) % 3;
        turns[k][3 * k + b] = zero;
        turns[k][3 * p + b] = at.R[3 * r + b];
        turns[k][3 * r + b] = hn::Neg(at.R[3 * p + b]);
      }
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 9; ++i) {
        turned[k][i] = zero;
        for (int l = 0; l < 3; ++l)
          turned[k][i] = hn::MulAdd(hn::Mul(stiff, Z[3 * k + l]), turns[l][i], turned[k][i]);
      }
  }
  V A[9][9], largest = hn::Zero(tag);
  for (int i = 0, k = 0; i < 9; ++i)
    for (int j = i; j < 9; ++j, ++k) {
      const int across = 3 * (j / 3) + i % 3, along = 3 * (i / 3) + j % 3; // G_bc, G_ea
      V of = hn::Mul(hn::Mul(lambda, N[i]), N[j]);
      of = hn::MulAdd(hn::Mul(twist, at.G[across]), at.G[along], of);
      for (int turn = 0; turn < 3 && run.is_corotated; ++turn)
        of = hn::MulAdd(turns[turn][i], turned[turn][j], of);
      A[i][j] = i == j ? hn::Add(of, of_I) : of;
      put(k, hn::Mul(V_cell, A[i][j]));
      largest = i == j ? hn::Max(largest, hn::Abs(A[i][j])) : largest;
    }
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
