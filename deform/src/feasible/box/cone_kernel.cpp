#include "feasible/box/scan_kernel.hpp"

#include "maille/deform/plan.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/box/cone_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector. Nothing of the standard library in here, not even std::array: where it is
// not inlined, the linker might pick the copy made for a machine that has more than this one. Additions,
// maxima and minima only, so that every kind gives the same bits.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template<class T>
struct Walk {
  const Cone<T>& cone;

  HWY_INLINE double path(int axis, int offset) const {
    return offset * (offset >= 0 ? cone.ahead[axis] : cone.behind[axis]);
  }
  HWY_INLINE T* row(int y, int z) const {
    return cone.field.data + y * cone.field.row_stride + z * cone.field.slab_stride;
  }
  HWY_INLINE T base(int y, int z) const {
    return static_cast<T>(cone.value + path(1, y - cone.handle[1]) + path(2, z - cone.handle[2]));
  }
  /// True if neither the node nor any behind it, seen from the handle, changes.
  HWY_INLINE bool is_clear(int x, int y, int z) const {
    const double inside = double{row(y, z)[x]} - double{base(y, z) + cone.row[x]};
    return cone.raises ? inside > cone.margin : -inside > cone.margin;
  }
  HWY_INLINE bool is_clear(int axis, int i, const int* at) const {
    return is_clear(axis == 0 ? i : at[0], axis == 1 ? i : at[1], axis == 2 ? i : at[2]);
  }

  /// Extent along an axis, from `at` outward to `limit` (exclusive, on either side), of nodes that may
  /// change. Clear nodes stay clear outward, so doubling steps and bisection find it.
  HWY_INLINE int reach(int axis, const int* at, int limit) const {
    const int from = at[axis];
    const int sign = limit > from ? 1 : -1;
    const int count = (limit - from) * sign;
    if (count <= 0)
      return from;
    if (!is_clear(axis, limit - sign, at))
      return limit;
    int blocked = -1, clear = count - 1;
    for (int step = 1; blocked + step < clear; step *= 2) {
      if (is_clear(axis, from + sign * (blocked + step), at)) {
        clear = blocked + step;
        break;
      }
      blocked += step;
    }
    while (clear - blocked > 1) {
      const int middle = (clear + blocked) / 2;
      if (is_clear(axis, from + sign * middle, at))
        clear = middle;
      else
        blocked = middle;
    }
    return from + sign * clear;
  }
  /// Range of nodes that may change around `at` along an axis, within the cone's box.
  HWY_INLINE void range(int axis, const int* at, int& first, int& end) const {
    end = reach(axis, at, cone.end[axis]);
    first = reach(axis, at, cone.begin[axis] - 1) + 1;
    if (end <= at[axis]) // the middle itself is clear
      first = end = at[axis];
  }

  /// True if every node of the cone's box in that slab may change: if no corner of the slab is clear, no node
  /// between the corners and the handle is. Four tests replace tests of each row.
  HWY_INLINE bool is_full(int z) const {
    const int x[2] = {cone.begin[0], cone.end[0] - 1}, y[2] = {cone.begin[1], cone.end[1] - 1};
    return !is_clear(x[0], y[0], z) && !is_clear(x[1], y[0], z) && !is_clear(x[0], y[1], z) &&
           !is_clear(x[1], y[1], z);
  }

  /// values = of(values, from + slope) from begin to end.
  template<class OfVectors, class OfNumbers>
  static HWY_INLINE void bound_row(T* HWY_RESTRICT values, const T* HWY_RESTRICT slope, T from, int begin,
                                   int end, OfVectors of_vectors, OfNumbers of_numbers) {
    const hn::CappedTag<T, nodes_per_block> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto level = hn::Set(d, from);
    const auto bounded = [&](int x) HWY_ATTR {
      return of_vectors(hn::LoadU(d, values + x), hn::Add(level, hn::LoadU(d, slope + x)));
    };
    int x = begin;
    for (; x + 4 * lanes <= end; x += 4 * lanes) { // four loads under way before the first store
      const auto v0 = bounded(x), v1 = bounded(x + lanes), v2 = bounded(x + 2 * lanes),
                 v3 = bounded(x + 3 * lanes);
      hn::StoreU(v0, d, values + x);
      hn::StoreU(v1, d, values + x + lanes);
      hn::StoreU(v2, d, values + x + 2 * lanes);
      hn::StoreU(v3, d, values + x + 3 * lanes);
    }
    for (; x + lanes <= end; x += lanes)
      hn::StoreU(bounded(x), d, values + x);
    for (; x < end; ++x)
      values[x] = of_numbers(values[x], from + slope[x]);
  }

  static HWY_INLINE void clamp_row(bool raises, T* HWY_RESTRICT values, const T* HWY_RESTRICT slope, T from,
                                   int begin, int end) {
    if (raises)
      bound_row(
          values, slope, from, begin, end,
          [](auto value, auto bound) HWY_ATTR { return hn::Max(value, bound); },
          [](T value, T bound) { return value > bound ? value : bound; });
    else
      bound_row(
          values, slope, from, begin, end,
          [](auto value, auto bound) HWY_ATTR { return hn::Min(value, bound); },
          [](T value, T bound) { return value < bound ? value : bound; });
  }

  /// Extends a range to whole cache lines, which are written anyway.
  HWY_INLINE void to_whole_lines(int& x_begin, int& x_end) const {
    x_begin = x_begin / nodes_per_block * nodes_per_block;
    x_end = (x_end + nodes_per_block - 1) / nodes_per_block * nodes_per_block;
    const int width = static_cast<int>(cone.field.row_stride);
    x_end = x_end < width ? x_end : width;
  }

  /// Processes the cone's box in a slab. Operands are copied first, because the compiler must assume that
  /// vector writes alias the cone.
  HWY_INLINE int64_t clamp_full_slab(int z) const {
    int x_begin = cone.begin[0], x_end = cone.end[0];
    to_whole_lines(x_begin, x_end);
    const int y_begin = cone.begin[1], y_end = cone.end[1], handle = cone.handle[1];
    const double value = cone.value, part_z = path(2, z - cone.handle[2]), ahead = cone.ahead[1],
                 behind = cone.behind[1];
    const int64_t stride = cone.field.row_stride;
    const T* const slope = cone.row;
    const bool raises = cone.raises;
    T* values = row(y_begin, z);
    for (int y = y_begin; y < y_end; ++y, values += stride) {
      const int offset = y - handle;
      const double part_y = offset * (offset >= 0 ? ahead : behind);
      clamp_row(raises, values, slope, static_cast<T>(value + part_y + part_z), x_begin, x_end);
    }
    return int64_t{1} * (y_end - y_begin) * (x_end - x_begin);
  }

  HWY_INLINE int64_t clamp_slab(int z) const {
    if (!cone.stops || is_full(z))
      return clamp_full_slab(z);
    int y_begin = cone.begin[1], y_end = cone.end[1];
    const int centre[3] = {cone.handle[0], cone.handle[1], z};
    range(1, centre, y_begin, y_end);
    // To look for the ends of a row takes longer than to clamp a few lines of memory that do not change.
    const bool is_narrow = cone.end[0] - cone.begin[0] <= 4 * nodes_per_block;
    int64_t visited = 0;
    for (int y = y_begin; y < y_end; ++y) {
      int x_begin = cone.begin[0], x_end = cone.end[0];
      const int middle[3] = {cone.handle[0], y, z};
      if (!is_narrow)
        range(0, middle, x_begin, x_end);
      to_whole_lines(x_begin, x_end);
      clamp_row(cone.raises, row(y, z), cone.row, base(y, z), x_begin, x_end);
      visited += x_end - x_begin;
    }
    return visited;
  }
};

template<class T>
HWY_INLINE int64_t apply_slabs(const Cone<T>& cone, int z_begin, int z_end) {
  const Walk<T> walk{cone};
  int64_t visited = 0;
  for (int z = z_begin; z < z_end; ++z)
    visited += walk.clamp_slab(z);
  return visited;
}

template<class T>
HWY_INLINE void enclose_cone(Cone<T>& cone) {
  const Cone<T> whole = cone;
  const Walk<T> walk{whole};
  for (int axis = 0; axis < 3; ++axis)
    walk.range(axis, whole.handle, cone.begin[axis], cone.end[axis]);
}

void enclose_float(Cone<float>& cone) {
  enclose_cone(cone);
}
void enclose_double(Cone<double>& cone) {
  enclose_cone(cone);
}
int64_t apply_float(const Cone<float>& cone, int z_begin, int z_end) {
  return apply_slabs(cone, z_begin, z_end);
}
int64_t apply_double(const Cone<double>& cone, int z_begin, int z_end) {
  return apply_slabs(cone, z_begin, z_end);
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(enclose_float);
HWY_EXPORT(enclose_double);
HWY_EXPORT(apply_float);
HWY_EXPORT(apply_double);

void enclose(Cone<float>& cone) {
  HWY_DYNAMIC_DISPATCH(enclose_float)(cone);
}
void enclose(Cone<double>& cone) {
  HWY_DYNAMIC_DISPATCH(enclose_double)(cone);
}
std::int64_t apply(const Cone<float>& cone, int z_begin, int z_end) {
  return HWY_DYNAMIC_DISPATCH(apply_float)(cone, z_begin, z_end);
}
std::int64_t apply(const Cone<double>& cone, int z_begin, int z_end) {
  return HWY_DYNAMIC_DISPATCH(apply_double)(cone, z_begin, z_end);
}

} // namespace maille::deform
#endif
