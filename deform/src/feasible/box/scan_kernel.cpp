#include "feasible/box/scan_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/box/scan_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "feasible/box/slab_bound-inl.hpp"

// Compiled once per kind of vector: see cone_kernel.cpp for what that forbids.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Largest violation of the bounds in each lane; negative: inside.
template<class T>
struct Outside {
  using D = hn::CappedTag<T, nodes_per_block>;
  hn::VFromD<D> lanes;
  T rest;

  HWY_INLINE Outside() : lanes(hn::Set(D(), -hwy::HighestValue<T>())), rest(-hwy::HighestValue<T>()) {}

  HWY_INLINE double farthest() const {
    const T of_lanes = hn::GetLane(hn::MaxOfLanes(D(), lanes));
    return double{of_lanes > rest ? of_lanes : rest};
  }
};

/// x = min(max(x, least), greatest) over a row of the strip; without a bound where has_... is false.
template<bool has_least, bool has_greatest, bool tracks, class T>
HWY_INLINE void clamp_row(T* HWY_RESTRICT values, int width, const T* HWY_RESTRICT least, T least_shift,
                          const T* HWY_RESTRICT greatest, T greatest_shift, Outside<T>& outside) {
  const hn::CappedTag<T, nodes_per_block> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto add_least = hn::Set(d, least_shift), add_greatest = hn::Set(d, greatest_shift);
  auto farthest = outside.lanes;
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    auto value = hn::LoadU(d, values + x);
    if (has_least) {
      const auto level = hn::Add(hn::LoadU(d, least + x), add_least);
      if (tracks)
        farthest = hn::Max(farthest, hn::Sub(level, value));
      value = hn::Max(value, level);
    }
    if (has_greatest) {
      const auto level = hn::Add(hn::LoadU(d, greatest + x), add_greatest);
      if (tracks)
        farthest = hn::Max(farthest, hn::Sub(value, level));
      value = hn::Min(value, level);
    }
    hn::StoreU(value, d, values + x);
  }
  outside.lanes = farthest;
  for (; x < width; ++x) {
    if (has_least) {
      const T level = least[x] + least_shift, excess = level - values[x];
      outside.rest = excess > outside.rest ? excess : outside.rest;
      values[x] = values[x] > level ? values[x] : level;
    }
    if (has_greatest) {
      const T level = greatest[x] + greatest_shift, excess = values[x] - level;
      outside.rest = excess > outside.rest ? excess : outside.rest;
      values[x] = values[x] < level ? values[x] : level;
    }
  }
}

/// A sweep through the slabs in one sense.
template<class T>
class Pass {
public:
  HWY_INLINE Pass(const Sweep<T>& sweep, bool forward)
      : sweep_(sweep), forward_(forward), bounds_{{sweep, sweep.bounds[0], forward},
                                                  {sweep, sweep.bounds[sweep.n_bounds - 1], forward}} {}

  HWY_INLINE int64_t clamp_all() {
    const int end = forward_ ? sweep_.nodes[2] : -1, sense = forward_ ? 1 : -1;
    int64_t visited = 0;
    for (int z = next_seeds(end); z != end;) {
      bool is_clear = true;
      const SlabBound<T>*least = nullptr, *greatest = nullptr;
      for (int b = 0; b < sweep_.n_bounds; ++b) {
        bounds_[b].enter(z);
        // The pass forward has dealt with what the first slab's own seeds ask.
        if (forward_ ? bounds_[b].is_open() : bounds_[b].is_beyond_first(z))
          (bounds_[b].is_least() ? least : greatest) = &bounds_[b];
        else if (bounds_[b].is_open())
          is_clear = false;
      }
      if (least != nullptr || greatest != nullptr) {
        if (next_seeds(end) == z + sense)
          is_clear = clamp_slab<false>(least, greatest, z); // no slab to be left out: no need to look
        else
          is_clear = clamp_slab<true>(least, greatest, z) && is_clear;
        visited += (sweep_.x_end - sweep_.x_begin) * int64_t{1} * sweep_.nodes[1];
      }
      z = is_clear ? next_seeds(end) : z + sense; // what is clear stays clear up to the next seeds
    }
    return visited;
  }

  HWY_INLINE void sample_all(const Queries& queries) {
    const int sense = forward_ ? 1 : -1;
    const int end = forward_ ? queries.n : -1;
    SlabBound<T>& bound = bounds_[0];
    for (int q = forward_ ? 0 : queries.n - 1; q != end; q += sense) {
      const GridSeed& at = queries.at[q];
      while (bound.has_more_seeds() && (at.z - bound.next_slab()) * sense >= 0)
        bound.enter(bound.next_slab());
      bound.enter(at.z);
      if (!bound.is_open())
        continue;
      const double level = double{bound.row(at.y)[at.x]} + double{bound.shift()};
      double& best = bound.bound().sample[q];
      best = (bound.is_least() ? level > best : level < best) ? level : best;
    }
  }

private:
  /// The next slab with seeds of any bound; `end` without one.
  HWY_INLINE int next_seeds(int end) const {
    int z = end;
    for (int b = 0; b < sweep_.n_bounds; ++b)
      if (bounds_[b].has_more_seeds()) {
        const int other = bounds_[b].next_slab();
        z = z == end || (forward_ ? other < z : other > z) ? other : z;
      }
    return z;
  }
  /// Clamps a slab between its bounds. @return true if violations are tracked and every node was inside by
  /// more than the margin
  template<bool tracks>
  HWY_INLINE bool clamp_slab(const SlabBound<T>* least, const SlabBound<T>* greatest, int z) const {
    Outside<T> outside;
    const int width = sweep_.x_end - sweep_.x_begin, n = sweep_.nodes[1];
    const int64_t field_stride = sweep_.field.row_stride, slab_stride = sweep_.slab_row;
    T* values = sweep_.field.data + z * sweep_.field.slab_stride + sweep_.x_begin;
    const T* const low = least != nullptr ? least->row(0) : nullptr;
    const T* const high = greatest != nullptr ? greatest->row(0) : nullptr;
    const T low_shift = least != nullptr ? least->shift() : T{0},
            high_shift = greatest != nullptr ? greatest->shift() : T{0};
    int64_t at = 0;
    for (int y = 0; y < n; ++y, values += field_stride, at += slab_stride) {
      if (high == nullptr)
        clamp_row<true, false, tracks, T>(values, width, low + at, low_shift, nullptr, T{0}, outside);
      else if (low == nullptr)
        clamp_row<false, true, tracks, T>(values, width, nullptr, T{0}, high + at, high_shift, outside);
      else
        clamp_row<true, true, tracks>(values, width, low + at, low_shift, high + at, high_shift, outside);
    }
    return tracks && -outside.farthest() > sweep_.margin;
  }

  const Sweep<T>& sweep_;
  bool forward_;
  SlabBound<T> bounds_[2];
};

template<class T>
HWY_INLINE int64_t clamp_both_ways(const Sweep<T>& sweep) {
  int64_t visited = 0;
  for (int sense = 0; sense < 2; ++sense) {
    Pass<T> pass(sweep, sense == 0);
    visited += pass.clamp_all();
  }
  return visited;
}

int64_t clamp_float(const Sweep<float>& sweep) {
  return clamp_both_ways(sweep);
}
int64_t clamp_double(const Sweep<double>& sweep) {
  return clamp_both_ways(sweep);
}

void sample(const Sweep<double>& sweep, const Queries& queries) {
  for (int sense = 0; sense < 2; ++sense) {
    Pass<double> pass(sweep, sense == 0);
    pass.sample_all(queries);
  }
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(clamp_float);
HWY_EXPORT(clamp_double);
HWY_EXPORT(sample);

std::int64_t clamp_strip(const Sweep<float>& sweep) {
  return HWY_DYNAMIC_DISPATCH(clamp_float)(sweep);
}
std::int64_t clamp_strip(const Sweep<double>& sweep) {
  return HWY_DYNAMIC_DISPATCH(clamp_double)(sweep);
}
void sample_bound(const Sweep<double>& sweep, const Queries& queries) {
  HWY_DYNAMIC_DISPATCH(sample)(sweep, queries);
}

} // namespace maille::deform
#endif
