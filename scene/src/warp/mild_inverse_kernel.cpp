#include "warp/mild_inverse.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "warp/mild_inverse_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

// Compiled once per vector target: definitions must be in the target's namespace.

HWY_BEFORE_NAMESPACE();
namespace maille::warping {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V set(double value) {
  return hn::Set(D(), value);
}
HWY_INLINE V product(const std::array<double, 9>& matrix, std::size_t row, const V3& of) {
  const double* const m = matrix.data() + 3 * row;
  return hn::Add(hn::Add(hn::Mul(set(m[0]), of.x), hn::Mul(set(m[1]), of.y)), hn::Mul(set(m[2]), of.z));
}
HWY_INLINE V3 product(const std::array<double, 9>& matrix, const V3& of) {
  return {product(matrix, 0, of), product(matrix, 1, of), product(matrix, 2, of)};
}
HWY_INLINE V largest(const V3& of) {
  return hn::Max(hn::Abs(of.x), hn::Max(hn::Abs(of.y), hn::Abs(of.z)));
}

/// J^-1 x(s) - s.
HWY_INLINE V3 bent(const MildMap& map, const V3& s) {
  const V st = hn::Mul(s.x, s.y), su = hn::Mul(s.x, s.z), tu = hn::Mul(s.y, s.z), stu = hn::Mul(st, s.z);
  const auto along = [&](std::size_t a) HWY_ATTR {
    const V two = hn::Add(hn::Mul(set(map.st[a]), st), hn::Mul(set(map.su[a]), su));
    return hn::Add(two, hn::Add(hn::Mul(set(map.tu[a]), tu), hn::Mul(set(map.stu[a]), stu)));
  };
  return {along(0), along(1), along(2)};
}

void narrow_in_vectors(const MildMap& map, double slack, PlaceRows& rows) {
  constexpr double too_far = 1e-6, flat = 1e-9; // rows along a face are in the cell entirely or not at all
  const D d;
  std::array<double, 3> per_s, half;
  for (std::size_t a = 0; a < 3; ++a) {
    const double along = map.inverse[3 * a];
    per_s[a] = 1 / (along < 0 ? std::min(along, -flat) : std::max(along, flat));
    half[a] = (0.5 + slack + map.spread[a]) * std::abs(per_s[a]) + too_far;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(rows.n); i += hn::Lanes(d)) {
    const V y = hn::Load(d, &rows.y[i]), z = hn::Load(d, &rows.z[i]);
    V low = set(-1e300), high = set(1e300);
    for (std::size_t a = 0; a < 3; ++a) {
      const V off = hn::Add(hn::Mul(set(map.inverse[3 * a + 1]), y), hn::Mul(set(map.inverse[3 * a + 2]), z));
      const V centre = hn::Mul(off, set(-per_s[a]));
      low = hn::Max(low, hn::Sub(centre, set(half[a])));
      high = hn::Min(high, hn::Add(centre, set(half[a])));
    }
    hn::Store(low, d, &rows.low[i]);
    hn::Store(high, d, &rows.high[i]);
  }
}

/// A vector of places during the iteration.
struct Walk {
  V3 first, s;
  M asked, left_over;

  HWY_INLINE void begin(const MildMap& map, const Places& places, std::size_t i) {
    const D d;
    first = product(map.inverse,
                    {hn::Load(d, &places.x[i]), hn::Load(d, &places.y[i]), hn::Load(d, &places.z[i])});
    s = first;
    const auto n = static_cast<std::size_t>(places.n);
    asked = left_over = hn::FirstN(d, n > i ? n - i : 0);
  }
  HWY_INLINE void step(const MildMap& map, V near_enough) {
    const V3 off = bent(map, s);
    const V3 next{hn::Sub(first.x, off.x), hn::Sub(first.y, off.y), hn::Sub(first.z, off.z)};
    const V3 change{hn::Sub(next.x, s.x), hn::Sub(next.y, s.y), hn::Sub(next.z, s.z)};
    s = {hn::IfThenElse(left_over, next.x, s.x), hn::IfThenElse(left_over, next.y, s.y),
         hn::IfThenElse(left_over, next.z, s.z)};
    left_over = hn::And(left_over, hn::Gt(largest(change), near_enough));
  }
};

void invert_in_vectors(const MildMap& map, double slack, Places& places) {
  constexpr double tolerance = 1e-8; // [voxels], as CellMap has it
  constexpr int most_steps = 30;
  constexpr double tiny = 1e-3;
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  // Within a cell bent(s) changes by at most `shrinks` times the change of s, which bounds the error.
  const double shrinks = std::max(tiny, 6 * std::max({map.spread[0], map.spread[1], map.spread[2]}));
  const V near_enough = set(tolerance / map.largest_row * (1 - shrinks) / shrinks);
  std::size_t n = 0;
  const auto keep = [&](const Walk& walk, std::size_t i) HWY_ATTR {
    const M inside =
        hn::And(hn::AndNot(walk.left_over, walk.asked), hn::Le(largest(walk.s), set(0.5 + slack)));
    HWY_ALIGN double x[hn::MaxLanes(D())], y[hn::MaxLanes(D())], z[hn::MaxLanes(D())];
    hn::Store(walk.s.x, d, x);
    hn::Store(walk.s.y, d, y);
    hn::Store(walk.s.z, d, z);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, inside, bits);
    // Bit by bit: hn::Compress copies its table to the stack each time (Highway 1.0.3).
    for (unsigned left = bits[0]; left != 0; left &= left - 1, ++n) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      places.x[n] = x[lane];
      places.y[n] = y[lane];
      places.z[n] = z[lane];
      places.number[n] = places.number[i + lane];
    }
  };
  // Two vectors at a time, because each step depends on the one before.
  for (std::size_t i = 0; i < static_cast<std::size_t>(places.n); i += 2 * lanes) {
    static_assert(Places::most % (2 * hn::MaxLanes(D())) == 0, "the second vector is within the lists");
    Walk one, other;
    one.begin(map, places, i);
    other.begin(map, places, i + lanes);
    for (int step = 0; step < most_steps; ++step) {
      one.step(map, near_enough);
      other.step(map, near_enough);
      if (hn::AllFalse(d, hn::Or(one.left_over, other.left_over)))
        break;
    }
    keep(one, i);
    keep(other, i + lanes);
  }
  places.n = static_cast<int>(n);
}

void take_to_rest_in_vectors(const RestMap& map, Places& places) {
  const D d;
  const V most = set(map.within), least = set(-map.within), half = set(0.5), zero = hn::Zero(d);
  for (std::size_t i = 0; i < static_cast<std::size_t>(places.n); i += hn::Lanes(d)) {
    const V3 s{hn::Load(d, &places.x[i]), hn::Load(d, &places.y[i]), hn::Load(d, &places.z[i])};
    const auto kept = [&](V along) HWY_ATTR { return hn::Max(hn::Min(along, most), least); };
    const V3 from_middle = product(map.linear, {kept(s.x), kept(s.y), kept(s.z)});
    const V3 rest{hn::Add(set(map.middle[0]), from_middle.x), hn::Add(set(map.middle[1]), from_middle.y),
                  hn::Add(set(map.middle[2]), from_middle.z)};
    M is_inside = hn::FirstN(d, hn::Lanes(d));
    const auto index = [&](V along, double size) HWY_ATTR {
      const V at = hn::Add(along, half);
      is_inside = hn::And(is_inside, hn::And(hn::Ge(at, zero), hn::Lt(at, set(size))));
      return hn::Floor(at);
    };
    const V x = index(rest.x, map.size[0]), y = index(rest.y, map.size[1]), z = index(rest.z, map.size[2]);
    const V row = hn::Add(y, hn::Mul(z, set(map.size[1])));
    hn::Store(hn::IfThenElse(is_inside, hn::Add(x, hn::Mul(row, set(map.size[0]))), set(-1)), d,
              &places.source[i]);
    hn::Store(largest(s), d, &places.depth[i]);
    hn::Store(rest.x, d, &places.x[i]);
    hn::Store(rest.y, d, &places.y[i]);
    hn::Store(rest.z, d, &places.z[i]);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::warping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::warping {

HWY_EXPORT(narrow_in_vectors);
HWY_EXPORT(invert_in_vectors);
HWY_EXPORT(take_to_rest_in_vectors);

void narrow(const MildMap& map, double slack, PlaceRows& rows) {
  HWY_DYNAMIC_DISPATCH(narrow_in_vectors)(map, slack, rows);
}

void invert(const MildMap& map, double slack, Places& places) {
  HWY_DYNAMIC_DISPATCH(invert_in_vectors)(map, slack, places);
}

void take_to_rest(const RestMap& map, Places& places) {
  HWY_DYNAMIC_DISPATCH(take_to_rest_in_vectors)(map, places);
}

} // namespace maille::warping
#endif
