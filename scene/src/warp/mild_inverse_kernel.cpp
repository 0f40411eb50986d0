#include "warp/mild_inverse.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "warp/mild_inverse_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstddef>

// Compiled once per kind of vector: nothing but what is in the target's namespace may be defined here.

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

/// Where the map takes (s, t, u), from the middle.
HWY_INLINE V3 mapped(const MildMap& map, const V3& s) {
  const V st = hn::Mul(s.x, s.y), su = hn::Mul(s.x, s.z), tu = hn::Mul(s.y, s.z), stu = hn::Mul(st, s.z);
  const V3 affine = product(map.jacobian, s);
  const auto along = [&](V first, std::size_t a) HWY_ATTR {
    const V two = hn::Add(hn::Mul(set(map.st[a]), st), hn::Mul(set(map.su[a]), su));
    const V rest = hn::Add(hn::Mul(set(map.tu[a]), tu), hn::Mul(set(map.stu[a]), stu));
    return hn::Add(first, hn::Add(two, rest));
  };
  return {along(affine.x, 0), along(affine.y, 1), along(affine.z, 2)};
}

/// The first guess of places, of those that the rest of the map might bring into the cell; the places go to
/// `goal` in the same order.
void guess(const MildMap& map, double slack, Places& places, Places& goal) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t n = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(places.n); i += lanes) {
    const V3 x{hn::Load(d, &places.x[i]), hn::Load(d, &places.y[i]), hn::Load(d, &places.z[i])};
    const V number = hn::Load(d, &places.number[i]);
    const V3 s = product(map.inverse, x);
    M near = hn::FirstN(d, static_cast<std::size_t>(places.n) - i);
    const auto keep = [&](V along, double spread) HWY_ATTR {
      near = hn::And(near, hn::Le(hn::Sub(hn::Abs(along), set(spread)), set(0.5 + slack)));
    };
    keep(s.x, map.spread[0]);
    keep(s.y, map.spread[1]);
    keep(s.z, map.spread[2]);
    // Never beyond the lists' ends: what was read is at least as much as what has been written.
    hn::StoreU(hn::Compress(x.x, near), d, &goal.x[n]);
    hn::StoreU(hn::Compress(x.y, near), d, &goal.y[n]);
    hn::StoreU(hn::Compress(x.z, near), d, &goal.z[n]);
    hn::StoreU(hn::Compress(s.x, near), d, &places.x[n]);
    hn::StoreU(hn::Compress(s.y, near), d, &places.y[n]);
    hn::StoreU(hn::Compress(s.z, near), d, &places.z[n]);
    hn::StoreU(hn::Compress(number, near), d, &places.number[n]);
    n += hn::CountTrue(d, near);
  }
  places.n = static_cast<int>(n);
}

void invert_in_vectors(const MildMap& map, double slack, Places& places) {
  constexpr double tolerance = 1e-8; // [voxels], as CellMap has it
  constexpr int most_steps = 30;
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  Places goal;
  guess(map, slack, places, goal);
  std::size_t n = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(places.n); i += lanes) {
    const V3 x{hn::Load(d, &goal.x[i]), hn::Load(d, &goal.y[i]), hn::Load(d, &goal.z[i])};
    V3 s{hn::Load(d, &places.x[i]), hn::Load(d, &places.y[i]), hn::Load(d, &places.z[i])};
    const V number = hn::Load(d, &places.number[i]);
    const M asked = hn::FirstN(d, static_cast<std::size_t>(places.n) - i);
    M left_over = asked;
    for (int step = 0; step < most_steps; ++step) {
      const V3 at = mapped(map, s);
      const V3 left{hn::Sub(x.x, at.x), hn::Sub(x.y, at.y), hn::Sub(x.z, at.z)};
      left_over = hn::And(left_over, hn::Gt(largest(left), set(tolerance)));
      if (hn::AllFalse(d, left_over))
        break;
      const V3 change = product(map.inverse, left);
      s = {hn::Add(s.x, hn::IfThenElseZero(left_over, change.x)),
           hn::Add(s.y, hn::IfThenElseZero(left_over, change.y)),
           hn::Add(s.z, hn::IfThenElseZero(left_over, change.z))};
    }
    const M inside = hn::And(hn::AndNot(left_over, asked), hn::Le(largest(s), set(0.5 + slack)));
    hn::StoreU(hn::Compress(s.x, inside), d, &places.x[n]);
    hn::StoreU(hn::Compress(s.y, inside), d, &places.y[n]);
    hn::StoreU(hn::Compress(s.z, inside), d, &places.z[n]);
    hn::StoreU(hn::Compress(number, inside), d, &places.number[n]);
    n += hn::CountTrue(d, inside);
  }
  places.n = static_cast<int>(n);
}

} // namespace HWY_NAMESPACE
} // namespace maille::warping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::warping {

HWY_EXPORT(invert_in_vectors);

void invert(const MildMap& map, double slack, Places& places) {
  HWY_DYNAMIC_DISPATCH(invert_in_vectors)(map, slack, places);
}

} // namespace maille::warping
#endif
