/// One bound of a sweep through the slabs (planes across z) of a box: separable scans.
///
/// least(x) = max over seeds s of (p_s - d(x, s)), where d is a sum of one term per axis with a slope ahead
/// and one behind. The sweep keeps one slab of numbers. From slab to slab all of them fall by the same slope,
/// which is stored once as a shift; seeds of the new slab are spread along their row, then across rows. A
/// forward and a backward sweep reach all nodes. Cost: O(nodes), whatever the number of seeds; a slab without
/// seeds costs only its clamp.
///
/// Included once per kind of vector, by scan_kernel.cpp; see cone_kernel.cpp for the rules that follow from
/// that.
#if defined(MAILLE_SLAB_BOUND_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_SLAB_BOUND_INL
#undef MAILLE_SLAB_BOUND_INL
#else
#define MAILLE_SLAB_BOUND_INL
#endif

#include "feasible/box/scan_kernel.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE double path(double ahead, double behind, int offset) {
  return offset * (offset >= 0 ? ahead : behind);
}

/// One bound on the present slab, as numbers of a slab plus a shift that grows from slab to slab: a slab
/// without seeds costs nothing.
template<class T>
class SlabBound {
public:
  HWY_INLINE SlabBound(const Sweep<T>& sweep, const Bound<T>& bound, bool forward)
      : sweep_(sweep), bound_(bound), forward_(forward), next_(forward ? 0 : bound.n_seeds - 1) {}

  HWY_INLINE bool has_more_seeds() const { return forward_ ? next_ < bound_.n_seeds : next_ >= 0; }
  /// The slab of the next seed. @pre has_more_seeds()
  HWY_INLINE int next_slab() const { return bound_.seeds[next_].z; }
  HWY_INLINE bool is_open() const { return is_open_; }
  HWY_INLINE bool is_least() const { return bound_.is_least; }
  HWY_INLINE const Bound<T>& bound() const { return bound_; }
  HWY_INLINE T shift() const { return static_cast<T>(shift_); }
  HWY_INLINE T* row(int y) const { return bound_.slab + y * sweep_.slab_row; }
  /// True if seeds of other slabs than the first reach the present one.
  HWY_INLINE bool is_beyond_first(int z) const { return is_open_ && z != first_slab_; }

  /// Goes to slab z and takes up the seeds there.
  HWY_INLINE void enter(int z) {
    if (has_more_seeds() && next_slab() == z) {
      if (!is_open_)
        open(z);
      shift_ = path(bound_.ahead[2], bound_.behind[2], z - first_slab_);
      take_seeds(z);
    } else if (is_open_) {
      shift_ = path(bound_.ahead[2], bound_.behind[2], z - first_slab_);
    }
  }

private:
  HWY_INLINE T better(T a, T b) const { return bound_.is_least ? (a > b ? a : b) : (a < b ? a : b); }
  HWY_INLINE T nothing() const {
    return static_cast<T>(bound_.is_least ? -__builtin_inf() : __builtin_inf());
  }

  HWY_INLINE void open(int z) {
    is_open_ = true;
    first_slab_ = z;
    const T worst = nothing();
    const int64_t count = sweep_.slab_row * sweep_.nodes[1];
    for (int64_t i = 0; i < count; ++i)
      bound_.slab[i] = worst;
  }

  HWY_INLINE void take_seeds(int z) {
    int first_row = -1, last_row = -1;
    while (has_more_seeds() && next_slab() == z) {
      const int y = bound_.seeds[next_].y, sense = forward_ ? 1 : -1;
      const GridSeed* const seeds = bound_.seeds + next_;
      int count = 0;
      for (; has_more_seeds() && next_slab() == z && bound_.seeds[next_].y == y; next_ += sense)
        ++count;
      if (count > seeds_laid_out)
        scan_row(seeds, count, sense, y);
      else
        for (int k = 0; k < count; ++k)
          lay_out(seeds[k * sense], y);
      first_row = first_row < 0 || y < first_row ? y : first_row;
      last_row = y > last_row ? y : last_row;
    }
    spread_over_rows(first_row, last_row);
  }

  /// What rows from `first` on ask of those behind, and rows up to `last` of those before. What the loops
  /// need is copied first: they write vectors, which the compiler must take for writes to the bound as well.
  HWY_INLINE void spread_over_rows(int first, int last) const {
    const int64_t stride = sweep_.slab_row;
    const int n = sweep_.nodes[1], width = sweep_.x_end - sweep_.x_begin;
    const bool is_least = bound_.is_least;
    const T ahead = static_cast<T>(bound_.ahead[1]), behind = static_cast<T>(-bound_.behind[1]);
    T* target = bound_.slab + (first + 1) * stride;
    for (int y = first + 1; y < n; ++y, target += stride)
      take_row(is_least, target, target - stride, ahead, width);
    target = bound_.slab + (last - 1) * stride;
    for (int y = last - 1; y >= 0; --y, target -= stride)
      take_row(is_least, target, target + stride, behind, width);
  }

  /// The cone of one seed within its row.
  HWY_INLINE void lay_out(const GridSeed& seed, int y) {
    const T* const offsets = bound_.row + (sweep_.nodes[0] - 1 - seed.x) + sweep_.x_begin;
    take_row(bound_.is_least, row(y), offsets, static_cast<T>(seed.value - shift_ + 0.0),
             sweep_.x_end - sweep_.x_begin);
  }

  /// Many seeds in one row: forward and backward along it, one node after the other.
  HWY_INLINE void scan_row(const GridSeed* seeds, int count, int sense, int y) {
    T* const values = bound_.one_row;
    const int n = (sweep_.nodes[0] + nodes_per_block - 1) / nodes_per_block * nodes_per_block;
    for (int x = 0; x < n; ++x)
      values[x] = nothing();
    for (int k = 0; k < count; ++k) {
      T& value = values[seeds[k * sense].x];
      value = better(value, static_cast<T>(seeds[k * sense].value - shift_ + 0.0));
    }
    const T ahead = static_cast<T>(bound_.ahead[0]), behind = static_cast<T>(bound_.behind[0]);
    for (int x = 1; x < n; ++x)
      values[x] = better(values[x], values[x - 1] + ahead);
    for (int x = n - 2; x >= 0; --x)
      values[x] = better(values[x], values[x + 1] - behind);
    take_row(bound_.is_least, row(y), values + sweep_.x_begin, T{0}, sweep_.x_end - sweep_.x_begin);
  }

  /// target = better(target, source + step) over the strip's width.
  static HWY_INLINE void take_row(bool is_least, T* HWY_RESTRICT target, const T* HWY_RESTRICT source, T step,
                                  int width) {
    if (is_least)
      take_row_by(
          target, source, step, width, [](auto a, auto b) HWY_ATTR { return hn::Max(a, b); },
          [](T a, T b) { return a > b ? a : b; });
    else
      take_row_by(
          target, source, step, width, [](auto a, auto b) HWY_ATTR { return hn::Min(a, b); },
          [](T a, T b) { return a < b ? a : b; });
  }
  template<class OfVectors, class OfNumbers>
  static HWY_INLINE void take_row_by(T* HWY_RESTRICT target, const T* HWY_RESTRICT source, T step, int width,
                                     OfVectors of_vectors, OfNumbers of_numbers) {
    const hn::CappedTag<T, nodes_per_block> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto add = hn::Set(d, step);
    const auto better_of = [&](int x) HWY_ATTR {
      return of_vectors(hn::LoadU(d, target + x), hn::Add(hn::LoadU(d, source + x), add));
    };
    int x = 0;
    for (; x + 4 * lanes <= width; x += 4 * lanes) {
      const auto v0 = better_of(x), v1 = better_of(x + lanes), v2 = better_of(x + 2 * lanes),
                 v3 = better_of(x + 3 * lanes);
      hn::StoreU(v0, d, target + x);
      hn::StoreU(v1, d, target + x + lanes);
      hn::StoreU(v2, d, target + x + 2 * lanes);
      hn::StoreU(v3, d, target + x + 3 * lanes);
    }
    for (; x + lanes <= width; x += lanes)
      hn::StoreU(better_of(x), d, target + x);
    for (; x < width; ++x)
      target[x] = of_numbers(target[x], source[x] + step);
  }

  const Sweep<T>& sweep_;
  const Bound<T>& bound_;
  bool forward_;
  int next_;
  bool is_open_ = false;
  int first_slab_ = 0;
  double shift_ = 0;
};

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#endif
