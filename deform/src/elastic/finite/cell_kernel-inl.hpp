/// Modes (see CellModes) and forces of a vector of cells. Included once per vector instruction set, by
/// tangent_kernel.cpp and law_kernel.cpp; see cone_kernel.cpp for the restrictions.
#if defined(MAILLE_CELL_KERNEL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_CELL_KERNEL_INL
#undef MAILLE_CELL_KERNEL_INL
#else
#define MAILLE_CELL_KERNEL_INL
#endif

#include "elastic/finite/tangent_kernel.hpp"
#include "elastic/model/lattice_kernel.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Many = hn::CappedTag<double, 4>;
using One = hn::CappedTag<double, 1>;

/// Forces of cells at their nodes, at their own place and at the next, by component and row of nodes.
using Pulls = double[2][3][4][most_cells + 1];

constexpr int beyond_mode[4] = {3, 5, 6, 7};

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

/// The modes of the cells from x on. @param gradient by columns [1] @param beyond mode after mode [m]
template<int d, class D, class V = hn::VFromD<D>>
HWY_INLINE void find_modes(D tag, const TangentRun& run, int x, V* gradient, V (*beyond)[d]) {
  constexpr int n_beyond = TangentNumbers<d>::n_beyond, n = n_beyond + 1 + d;
  for (int b = 0; b < d; ++b) {
    V mode[n];
    const V first = hn::LoadU(tag, run.u[b] + x);
    mode[0] = hn::Zero(tag);
    for (int corner = 1; corner < n; ++corner)
      mode[corner] = hn::Sub(hn::LoadU(tag, run.u[b] + run.corner[corner] + x), first);
    transform<n>(mode);
    for (int a = 0; a < d; ++a)
      gradient[d * a + b] = hn::Mul(hn::Set(tag, 2 * run.per_length[a] / n), mode[1 << a]);
    for (int k = 0; k < n_beyond; ++k)
      beyond[k][b] = hn::Mul(hn::Set(tag, 1.0 / n), mode[beyond_mode[k]]);
  }
}

/// Forces from the derivatives of the energy. @param of_gradient by the mean gradient [N m] @param of_beyond
/// by the other modes [N]
template<int d, class D, class V = hn::VFromD<D>>
HWY_INLINE void put_pulls(D tag, const TangentRun& run, int x, const V* of_gradient, const V (*of_beyond)[d],
                          Pulls& pulls) {
  constexpr int n_beyond = TangentNumbers<d>::n_beyond, n = n_beyond + 1 + d;
  for (int b = 0; b < d; ++b) {
    V pull[n];
    pull[0] = hn::Zero(tag);
    for (int a = 0; a < d; ++a)
      pull[1 << a] = hn::Mul(hn::Set(tag, 2 * run.per_length[a] / n), of_gradient[d * a + b]);
    for (int k = 0; k < n_beyond; ++k)
      pull[beyond_mode[k]] = hn::Mul(hn::Set(tag, 1.0 / n), of_beyond[k][b]);
    for (int m = 0; m < n; ++m)
      pull[m] = bits(m) % 2 != 0 ? hn::Neg(pull[m]) : pull[m];
    transform<n>(pull);
    for (int corner = 0; corner < n; ++corner) {
      const V signed_pull = bits(corner) % 2 != 0 ? hn::Neg(pull[corner]) : pull[corner];
      hn::StoreU(signed_pull, tag, pulls[corner & 1][b][corner >> 1] + x + (corner & 1));
    }
  }
}

/// Calls visit(tag, x) for vectors of cells. Vectors overlap at the end of a run; overlapping cells get the
/// same result twice.
template<class Visit>
HWY_INLINE void for_each_vector(int cells, const Visit& visit) {
  const Many many;
  const int lanes = static_cast<int>(hn::Lanes(many));
  if (cells >= lanes)
    for (int x = 0; x < cells; x += lanes)
      visit(many, x < cells - lanes ? x : cells - lanes);
  else
    for (int x = 0; x < cells; ++x)
      visit(One(), x);
}

/// forces += the forces of at most most_cells cells.
template<int d>
HWY_INLINE void add_pulls(const TangentRun& run, Pulls& pulls) {
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

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#endif
