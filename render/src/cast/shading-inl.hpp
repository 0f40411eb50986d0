// Shading of visible samples, in full vectors across rays. Included once per vector target.

#if defined(MAILLE_SHADING_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_SHADING_INL_HPP
#undef MAILLE_SHADING_INL_HPP
#else
#define MAILLE_SHADING_INL_HPP
#endif

#include "cast/packing-inl.hpp"
#include "cast/rays-inl.hpp"
#include "cast/sampling-inl.hpp"

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

/// Queue of samples for shading. Half of a vector's rays are invisible at a time: visible samples are
/// collected and shaded in full vectors, in order of arrival.
template<class Path>
class Shading {
public:
  Shading(const CastTask& task, RunSink& sink) : task_(task), sink_(sink) {}

  /// @param weight of a sample in its run; @param run number in the sink
  HWY_INLINE void push(M lanes, V t, VI entry, const V3& at, V weight, VI run, const Path& path) {
    const DF df;
    const DI di;
    const Packing packing(lanes);
    const auto put = [&](float* to, V from) HWY_ATTR { hn::StoreU(packing.packed(from), df, to + n_); };
    const auto put_int = [&](std::int32_t* to, VI from)
                             HWY_ATTR { hn::StoreU(packing.packed(from), di, to + n_); };
    put(t_, t);
    put(x_, at.x);
    put(y_, at.y);
    put(z_, at.z);
    put(weight_, weight);
    put_int(entry_, entry);
    put_int(run_, run);
    if (task_.shaded) {
      // Independent of the step, so that the visible part of a cut is too.
      const V behind = hn::MulAdd(hn::Sub(t, path.cut), set(task_.cut_scale), set(-1));
      put(from_cut_, hn::Min(hn::Max(behind, hn::Zero(df)), set(1)));
      for (int i = 0; i < Path::n_turning; ++i)
        put(turning_[i], path.turning(i));
    }
    n_ += packing.n();
    const std::size_t full = hn::Lanes(df);
    if (n_ < full)
      return;
    shade(full);
    n_ -= full;
    for (float* list : {t_, x_, y_, z_, weight_, from_cut_})
      hn::StoreU(hn::LoadU(df, list + full), df, list);
    for (std::int32_t* list : {entry_, run_})
      hn::StoreU(hn::LoadU(di, list + full), di, list);
    for (int i = 0; i < Path::n_turning; ++i)
      hn::StoreU(hn::LoadU(df, turning_[i] + full), df, turning_[i]);
  }
  /// Shades the remaining samples.
  HWY_INLINE void finish() {
    // Unused lanes hold old points of the same volume, or zeros.
    if (n_ > 0)
      shade(n_);
    n_ = 0;
  }

private:
  HWY_INLINE V3 colour_of(VI entry, const V3& at) const {
    const bool is_painted = task_.paint_numbers != nullptr || task_.paint_pixels != nullptr;
    if (is_painted && !task_.paint_keeps_own)
      return painted(task_, at, at);
    const V3 own{gather(task_.colour[0], entry), gather(task_.colour[1], entry),
                 gather(task_.colour[2], entry)};
    return is_painted ? painted(task_, at, own) : own;
  }
  /// Colours of points with light and depth cue.
  HWY_INLINE V3 shown() const {
    const DF df;
    const V t = hn::LoadU(df, t_);
    const V3 at{hn::LoadU(df, x_), hn::LoadU(df, y_), hn::LoadU(df, z_)};
    V3 colour = colour_of(hn::LoadU(DI(), entry_), at);
    if (task_.shaded) {
      const V3 gradient =
          between_gradients(task_.gradients, place_in(at, task_.size, task_.stride), task_.stride);
      const V steepness = hn::Mul(hn::Sqrt(dot(gradient, gradient)), set(1.0f / 127));
      const auto turning = [&](int i) HWY_ATTR { return hn::LoadU(df, turning_[i]); };
      colour =
          lit(task_, colour, Path::turned(task_, gradient, turning), steepness, hn::LoadU(df, from_cut_));
    }
    const V cue =
        hn::Min(hn::Max(hn::MulAdd(t, set(task_.cue_slope), set(task_.cue_offset)), set(0)), set(1));
    return {hn::Mul(colour.x, cue), hn::Mul(colour.y, cue), hn::Mul(colour.z, cue)};
  }
  HWY_INLINE void shade(std::size_t n) {
    const DF df;
    const V3 colour = shown();
    const V weight = hn::LoadU(df, weight_);
    HWY_ALIGN float light[4 * most_lanes];
    hn::StoreInterleaved4(hn::Mul(weight, colour.x), hn::Mul(weight, colour.y), hn::Mul(weight, colour.z),
                          hn::Zero(df), df, light);
    const hn::CappedTag<float, 4> part;
    for (std::size_t sample = 0; sample < n; ++sample) {
      float* const rgba = sink_.runs[run_[sample]].second.rgba.data();
      for (std::size_t c = 0; c < 4; c += hn::Lanes(part))
        hn::StoreU(hn::Add(hn::LoadU(part, rgba + c), hn::Load(part, light + 4 * sample + c)), part,
                   rgba + c);
    }
  }

  static constexpr int room = 2 * most_lanes;
  const CastTask& task_;
  RunSink& sink_;
  std::size_t n_ = 0;
  HWY_ALIGN float t_[room] = {}, x_[room] = {}, y_[room] = {}, z_[room] = {}, weight_[room] = {},
                  from_cut_[room] = {}, turning_[Path::n_turning > 0 ? Path::n_turning : 1][room] = {};
  HWY_ALIGN std::int32_t entry_[room] = {}, run_[room] = {};
};

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#endif
