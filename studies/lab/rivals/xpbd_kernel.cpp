#include "rivals/xpbd_kernel.hpp"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rivals/xpbd_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::lab {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::CappedTag<float, 16>;
using One = hn::CappedTag<float, 1>; // for the ends of rows: the same sums

/// Added to squared lengths: below rounding, but where prescribed ends meet there is a direction to divide
/// by.
constexpr float least_length2 = 1e-12F;

/// 1 / sqrt(x) to rounding, without a root and a quotient: one step of Newton's method after the machine's
/// estimate.
template<class V>
HWY_INLINE V reciprocal_root(V x) {
  const hn::DFromV<V> d;
  const V y = hn::ApproximateReciprocalSqrt(x);
  return hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(hn::Set(d, 0.5F), x), y), y, hn::Set(d, 1.5F)));
}

/// Both ends of some constraints.
template<class D>
struct Ends {
  using V = hn::VFromD<D>;
  V near[3], far[3];
};

/// Edges along a row: every second pair of neighbours, so that no node has two. Reads 2 lanes.
template<class D>
struct Alternate {
  using V = hn::VFromD<D>;
  static constexpr int pace = 2;
  static HWY_INLINE Ends<D> load(const float* const* field, std::ptrdiff_t near, std::ptrdiff_t) {
    Ends<D> ends;
    for (int b = 0; b < 3; ++b)
      hn::LoadInterleaved2(D(), field[b] + near, ends.near[b], ends.far[b]);
    return ends;
  }
  static HWY_INLINE void store(const Ends<D>& ends, float* const* field, std::ptrdiff_t near,
                               std::ptrdiff_t) {
    for (int b = 0; b < 3; ++b)
      hn::StoreInterleaved2(ends.near[b], ends.far[b], D(), field[b] + near);
  }
  static HWY_INLINE V load_one(const float* field, std::ptrdiff_t near) {
    V own, next;
    hn::LoadInterleaved2(D(), field + near, own, next);
    return own;
  }
  static HWY_INLINE void store_one(V own, float* field, std::ptrdiff_t near) {
    V old, next;
    hn::LoadInterleaved2(D(), field + near, old, next);
    hn::StoreInterleaved2(own, next, D(), field + near);
  }
};

/// From row to row: no node has two.
template<class D>
struct Straight {
  using V = hn::VFromD<D>;
  static constexpr int pace = 1;
  static HWY_INLINE Ends<D> load(const float* const* field, std::ptrdiff_t near, std::ptrdiff_t far) {
    Ends<D> ends;
    for (int b = 0; b < 3; ++b) {
      ends.near[b] = hn::LoadU(D(), field[b] + near);
      ends.far[b] = hn::LoadU(D(), field[b] + far);
    }
    return ends;
  }
  static HWY_INLINE void store(const Ends<D>& ends, float* const* field, std::ptrdiff_t near,
                               std::ptrdiff_t far) {
    for (int b = 0; b < 3; ++b) {
      hn::StoreU(ends.near[b], D(), field[b] + near);
      hn::StoreU(ends.far[b], D(), field[b] + far);
    }
  }
  static HWY_INLINE V load_one(const float* field, std::ptrdiff_t near) {
    return hn::LoadU(D(), field + near);
  }
  static HWY_INLINE void store_one(V own, float* field, std::ptrdiff_t near) {
    hn::StoreU(own, D(), field + near);
  }
};

/// Solves constraints that share no node: Macklin et al. 2016, equation 18, with numerator and denominator
/// times stiffness, so that none means no constraint.
struct Solve {
  template<class D, class Access>
  static HWY_INLINE void at(const XpbdState& state, const XpbdDirection& direction, std::ptrdiff_t near,
                            std::ptrdiff_t far) {
    using V = hn::VFromD<D>;
    const D d;
    Ends<D> u = Access::load(state.u, near, far);
    const Ends<D> w = Access::load(state.inverse_mass, near, far);
    V along[3], length2 = hn::Set(d, least_length2), change = hn::Zero(d), mobility = hn::Zero(d);
    for (int b = 0; b < 3; ++b) {
      const V rest = hn::Set(d, direction.rest[b]), difference = hn::Sub(u.far[b], u.near[b]);
      along[b] = hn::Add(rest, difference);
      const V square = hn::Mul(along[b], along[b]);
      length2 = hn::Add(length2, square);
      mobility = hn::MulAdd(square, hn::Add(w.near[b], w.far[b]), mobility);
      change = hn::MulAdd(difference, hn::Add(rest, along[b]), change); // of length^2, without cancellation
    }
    const V stiffness = Access::load_one(direction.stiffness, near),
            multiplier = Access::load_one(direction.multiplier, near);
    // The constraint is change / sum, its gradient along / length; one division serves both.
    const V length = hn::Mul(length2, reciprocal_root(length2)),
            sum = hn::Add(length, hn::Set(d, direction.rest_length));
    const V excess = hn::MulAdd(stiffness, change, hn::Mul(multiplier, sum));
    const V divisor = hn::Mul(sum, hn::MulAdd(stiffness, mobility, length2));
    const V per_length = hn::Neg(hn::Div(hn::Mul(excess, length), divisor));
    Access::store_one(hn::MulAdd(per_length, length, multiplier), direction.multiplier, near);
    for (int b = 0; b < 3; ++b) {
      const V impulse = hn::Mul(per_length, along[b]);
      u.near[b] = hn::NegMulAdd(w.near[b], impulse, u.near[b]);
      u.far[b] = hn::MulAdd(w.far[b], impulse, u.far[b]);
    }
    Access::store(u, state.u, near, far);
  }
};

/// Moves the ends by the multipliers that there are, along the directions at `start`.
struct Push {
  template<class D, class Access>
  static HWY_INLINE void at(const XpbdState& state, const XpbdDirection& direction, std::ptrdiff_t near,
                            std::ptrdiff_t far) {
    using V = hn::VFromD<D>;
    const D d;
    Ends<D> u = Access::load(state.u, near, far);
    const Ends<D> start = Access::load(state.start, near, far),
                  w = Access::load(state.inverse_mass, near, far);
    V along[3], length2 = hn::Set(d, least_length2);
    for (int b = 0; b < 3; ++b) {
      along[b] = hn::Add(hn::Set(d, direction.rest[b]), hn::Sub(start.far[b], start.near[b]));
      length2 = hn::MulAdd(along[b], along[b], length2);
    }
    const V per_length = hn::Mul(Access::load_one(direction.multiplier, near), reciprocal_root(length2));
    for (int b = 0; b < 3; ++b) {
      const V impulse = hn::Mul(per_length, along[b]);
      u.near[b] = hn::NegMulAdd(w.near[b], impulse, u.near[b]);
      u.far[b] = hn::MulAdd(w.far[b], impulse, u.far[b]);
    }
    Access::store(u, state.u, near, far);
  }
};

/// The constraints of one direction that start at nodes first, first + pace, ... < last of a row.
template<class Do, template<class> class Access>
HWY_INLINE void along_row(const XpbdState& state, const XpbdDirection& direction, std::ptrdiff_t row,
                          std::ptrdiff_t offset, int first, int last) {
  constexpr int pace = Access<One>::pace;
  const int stride = static_cast<int>(hn::Lanes(Wide())) * pace;
  int x = first;
  // Of pairs, the last one's far end lies one further.
  for (; x + stride <= last + pace - 1; x += stride)
    Do::template at<Wide, Access<Wide>>(state, direction, row + x, row + x + offset);
  for (; x < last; x += pace)
    Do::template at<One, Access<One>>(state, direction, row + x, row + x + offset);
}

template<class Do>
HWY_INLINE void in_row(const XpbdState& state, const XpbdDirection& direction, int y, int z) {
  const int* n = state.nodes;
  const int* step = direction.step;
  if (y + step[1] < 0 || y + step[1] >= n[1] || z + step[2] >= n[2])
    return;
  const auto node = [n](int at_x, int at_y, int at_z) {
    return at_x + std::ptrdiff_t{n[0]} * (at_y + std::ptrdiff_t{n[1]} * at_z);
  };
  const std::ptrdiff_t row = node(0, y, z), offset = node(step[0], step[1], step[2]);
  const int first = step[0] < 0 ? 1 : 0, last = step[0] > 0 ? n[0] - 1 : n[0];
  if (step[1] == 0 && step[2] == 0) {
    along_row<Do, Alternate>(state, direction, row, offset, 0, last);
    along_row<Do, Alternate>(state, direction, row, offset, 1, last);
  } else {
    along_row<Do, Straight>(state, direction, row, offset, first, last);
  }
}

/// All constraints that start in one plane, direction by direction. Those of a direction share no node, but
/// for neighbouring rows of one plane: of these, every second row and then the others. So a machine that
/// looks ahead finds work that does not wait for the row before.
template<class Do>
HWY_INLINE void in_plane(const XpbdState& state, const XpbdDirection& direction, int z) {
  const bool stays_in_plane = direction.step[1] == 1 && direction.step[2] == 0;
  const int n_rounds = stays_in_plane ? 2 : 1;
  for (int round = 0; round < n_rounds; ++round)
    for (int y = round; y < state.nodes[1]; y += n_rounds)
      in_row<Do>(state, direction, y, z);
}

template<class Do>
HWY_INLINE void in_all_planes(const XpbdState& state, bool backward) {
  const int n_planes = state.nodes[2], n_directions = state.n_directions;
  for (int i = 0; i < n_planes; ++i)
    for (int j = 0; j < n_directions; ++j)
      in_plane<Do>(state, state.direction[backward ? n_directions - 1 - j : j],
                   backward ? n_planes - 1 - i : i);
}

void solve_all(const XpbdState& state, bool backward) {
  in_all_planes<Solve>(state, backward);
}

void push_all(const XpbdState& state) {
  in_all_planes<Push>(state, false);
}

template<class D>
HWY_INLINE void coast_at(const XpbdState& state, int b, std::ptrdiff_t i, float keep, bool push_again) {
  const D d;
  const auto u = hn::LoadU(d, state.u[b] + i), w = hn::LoadU(d, state.inverse_mass[b] + i),
             before = hn::LoadU(d, state.before[b] + i);
  auto start = hn::MulAdd(hn::Set(d, keep), hn::Sub(u, before), u);
  if (state.load[b])
    start = hn::MulAdd(hn::LoadU(d, state.load[b] + i), w, start);
  hn::StoreU(u, d, state.before[b] + i);
  const auto pushed = hn::Sub(u, hn::LoadU(d, state.start[b] + i));
  hn::StoreU(start, d, state.start[b] + i);
  hn::StoreU(push_again ? hn::Add(start, pushed) : start, d, state.u[b] + i);
}

template<class D>
HWY_INLINE void progress_at(const XpbdState& state, int b, std::ptrdiff_t i, hn::VFromD<D>& climb,
                            hn::VFromD<D>& motion) {
  const D d;
  const auto u = hn::LoadU(d, state.u[b] + i), step = hn::Sub(u, hn::LoadU(d, state.before[b] + i));
  climb = hn::MulAdd(hn::Sub(hn::LoadU(d, state.start[b] + i), u), step, climb);
  motion = hn::MulAdd(step, step, motion);
}

void coast(const XpbdState& state, float keep, bool push_again) {
  const std::ptrdiff_t n = std::ptrdiff_t{1} * state.nodes[0] * state.nodes[1] * state.nodes[2],
                       lanes = static_cast<std::ptrdiff_t>(hn::Lanes(Wide()));
  for (int b = 0; b < 3; ++b) {
    std::ptrdiff_t i = 0;
    for (; i + lanes <= n; i += lanes)
      coast_at<Wide>(state, b, i, keep, push_again);
    for (; i < n; ++i)
      coast_at<One>(state, b, i, keep, push_again);
  }
}

void progress(const XpbdState& state, XpbdProgress& sums) {
  const std::ptrdiff_t row = state.nodes[0], n = row * state.nodes[1] * state.nodes[2],
                       lanes = static_cast<std::ptrdiff_t>(hn::Lanes(Wide()));
  for (int b = 0; b < 3; ++b)
    for (std::ptrdiff_t first = 0; first < n; first += row) { // float32 within a row, float64 over rows
      auto climb = hn::Zero(Wide()), motion = climb;
      auto last_climb = hn::Zero(One()), last_motion = last_climb;
      std::ptrdiff_t i = first;
      for (; i + lanes <= first + row; i += lanes)
        progress_at<Wide>(state, b, i, climb, motion);
      for (; i < first + row; ++i)
        progress_at<One>(state, b, i, last_climb, last_motion);
      sums.climb += static_cast<double>(hn::GetLane(hn::SumOfLanes(Wide(), climb)) + hn::GetLane(last_climb));
      sums.motion +=
          static_cast<double>(hn::GetLane(hn::SumOfLanes(Wide(), motion)) + hn::GetLane(last_motion));
    }
}

} // namespace HWY_NAMESPACE
} // namespace maille::lab
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::lab {

HWY_EXPORT(coast);
HWY_EXPORT(push_all);
HWY_EXPORT(solve_all);
HWY_EXPORT(progress);

void xpbd_coast(const XpbdState& state, float keep, bool push_again) {
  HWY_DYNAMIC_DISPATCH(coast)(state, keep, push_again);
}
void xpbd_push(const XpbdState& state) {
  HWY_DYNAMIC_DISPATCH(push_all)(state);
}
void xpbd_solve(const XpbdState& state, bool backward) {
  HWY_DYNAMIC_DISPATCH(solve_all)(state, backward);
}
XpbdProgress xpbd_progress(const XpbdState& state) {
  XpbdProgress sums;
  HWY_DYNAMIC_DISPATCH(progress)(state, sums);
  return sums;
}

} // namespace maille::lab
#endif
