#include "cast/cast_task.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cast/cast_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cast/rays-inl.hpp"
#include "cast/sampling-inl.hpp"

#include <cstdint>

// Compiled once per kind of vector: nothing but what is in the target's namespace may be defined here.

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

/// Transparency of which nothing is seen any more: less than half of a 255th of any colour.
constexpr float spent = 1.0f / 1024;
/// Samples without anything to see that end a run.
constexpr float gap = 3.5f;

/// One block of pixels on its way through one object.
template<class Path, bool is_wide>
class Cast {
public:
  Cast(const CastTask& task, const PixelBlock& block, Path path, bool one_by_one, RunSink& sink)
      : task_(task), block_(block), path_(path), one_by_one_(one_by_one), sink_(sink) {}

  void run() {
    const DF df;
    reset();
    const M pixels = hn::FirstN(df, static_cast<std::size_t>(block_.n));
    for (;;) {
      const M active = hn::And(pixels, hn::Le(path_.sample, path_.last));
      if (hn::AllFalse(df, active)) {
        if (!path_.goes_on(hn::AndNot(active, pixels)))
          break;
        continue;
      }
      const V t = hn::Mul(hn::Add(path_.sample, set(0.5f)), set(task_.step));
      V next = hn::Add(path_.sample, set(1));
      V3 at;
      const M there = path_.locate(t, active, at, next);
      if (!hn::AllFalse(df, there))
        take(t, there, at);
      path_.sample = hn::IfThenElse(active, next, path_.sample);
    }
    emit(hn::Gt(alpha_, set(0)));
  }

private:
  HWY_INLINE void reset() {
    const V none = hn::Zero(DF());
    light_ = {none, none, none};
    alpha_ = begin_ = end_ = half_ = none;
    clear_ = set(1);
    largest_ = set(-1);
  }
  HWY_INLINE V code_at(const V3& at) const {
    const void* codes = is_wide ? static_cast<const void*>(task_.codes16) : task_.codes8;
    return between_codes<is_wide>(codes, place_in(at, task_.size, task_.stride), task_.stride);
  }
  HWY_INLINE VI entry_of(V code) const {
    return hn::ConvertTo(DI(), hn::MulAdd(code, set(task_.table_scale), set(0.5f)));
  }
  HWY_INLINE V3 colour_of(VI entry, const V3& at) const {
    if (task_.paint_numbers != nullptr || task_.paint_pixels != nullptr)
      return painted(task_, at);
    return {gather(task_.colour[0], entry), gather(task_.colour[1], entry), gather(task_.colour[2], entry)};
  }
  /// The colour of a point with its light and the depth cue.
  HWY_INLINE V3 shown(V t, VI entry, const V3& at) const {
    V3 colour = colour_of(entry, at);
    if (task_.shaded) {
      const V3 gradient =
          between_gradients(task_.gradients, place_in(at, task_.size, task_.stride), task_.stride);
      const V steepness = hn::Mul(hn::Sqrt(dot(gradient, gradient)), set(1.0f / 127));
      const M is_cut = hn::Lt(hn::Sub(t, path_.cut), set(task_.step));
      colour = lit(task_, colour, path_.gradient(gradient), steepness, is_cut);
    }
    const V cue =
        hn::Min(hn::Max(hn::MulAdd(t, set(task_.cue_slope), set(task_.cue_offset)), set(0)), set(1));
    return {hn::Mul(colour.x, cue), hn::Mul(colour.y, cue), hn::Mul(colour.z, cue)};
  }

  HWY_INLINE void take(V t, M there, const V3& at) {
    const V code = code_at(at);
    if (task_.mode == LookMode::isosurface)
      return take_surface(t, hn::And(there, hn::Ge(code, set(task_.isocode))), code);
    const VI entry = entry_of(code);
    if (task_.mode == LookMode::maximum)
      return take_largest(t, hn::And(there, hn::Gt(code, largest_)), code, entry, at);
    const V alpha = gather(task_.alpha, entry);
    const M visible = hn::And(there, hn::Gt(alpha, set(0)));
    if (!hn::AllFalse(DF(), visible))
      add(t, visible, alpha, shown(t, entry, at));
  }

  /// A sample of some opacity in front of what the ray has not reached yet.
  HWY_INLINE void add(V t, M visible, V alpha, const V3& colour) {
    const DF df;
    const V half_step = set(0.5f * task_.step);
    const M has_run = hn::Gt(alpha_, set(0));
    if (one_by_one_)
      emit(hn::And(visible, has_run));
    else
      emit(hn::And(hn::And(visible, has_run), hn::Gt(hn::Sub(t, end_), set((gap - 0.5f) * task_.step))));
    const M is_new = hn::AndNot(hn::Gt(alpha_, set(0)), visible);
    begin_ = hn::IfThenElse(is_new, hn::Sub(t, half_step), begin_);
    half_ = hn::IfThenElse(is_new, t, half_);
    const V weight = hn::IfThenElseZero(visible, hn::Mul(hn::Sub(set(1), alpha_), alpha));
    light_.x = hn::MulAdd(weight, colour.x, light_.x);
    light_.y = hn::MulAdd(weight, colour.y, light_.y);
    light_.z = hn::MulAdd(weight, colour.z, light_.z);
    const V before = alpha_;
    alpha_ = hn::Add(alpha_, weight);
    end_ = hn::IfThenElse(visible, hn::Add(t, half_step), end_);
    half_ = hn::IfThenElse(hn::And(hn::Lt(before, set(0.5f)), hn::Ge(alpha_, set(0.5f))), t, half_);
    clear_ = hn::IfThenElse(visible, hn::Mul(clear_, hn::Sub(set(1), alpha)), clear_);
    const M ends = hn::And(visible, hn::Lt(clear_, set(spent)));
    if (!hn::AllFalse(df, ends))
      path_.end_lanes(ends);
  }

  HWY_INLINE void take_largest(V t, M larger, V code, VI entry, const V3& at) {
    if (hn::AllFalse(DF(), larger))
      return;
    const V3 colour = shown(t, entry, at);
    const V alpha = gather(task_.alpha, entry);
    largest_ = hn::IfThenElse(larger, code, largest_);
    alpha_ = hn::IfThenElse(larger, alpha, alpha_);
    light_.x = hn::IfThenElse(larger, hn::Mul(alpha, colour.x), light_.x);
    light_.y = hn::IfThenElse(larger, hn::Mul(alpha, colour.y), light_.y);
    light_.z = hn::IfThenElse(larger, hn::Mul(alpha, colour.z), light_.z);
    begin_ = hn::IfThenElse(larger, t, begin_);
    end_ = half_ = begin_;
  }

  /// The first sample that is not outside: where between it and the one before does the ray meet the surface?
  HWY_INLINE void take_surface(V t, M inside, V code) {
    const DF df;
    if (hn::AllFalse(df, inside))
      return;
    V low = hn::Max(hn::Sub(t, set(task_.step)), path_.begin), high = t;
    V3 at;
    const M is_below = path_.locate_between(low, inside, at);
    V code_low = hn::IfThenElse(is_below, code_at(at), set(-1)), code_high = code;
    const V wanted = set(task_.isocode);
    const M is_cut = hn::Ge(code_low, wanted); // already inside where the ray begins
    V hit = hn::IfThenElse(is_cut, low, high);
    for (int round = 0; round < 4; ++round) {
      const V part = hn::Div(hn::Sub(wanted, code_low), hn::Max(hn::Sub(code_high, code_low), set(1e-6f)));
      // Never at an end: rounding must not stop the search.
      const V inner = hn::Min(hn::Max(part, set(0.05f)), set(0.95f));
      const V middle = hn::IfThenElse(is_cut, low, lerp(low, high, inner));
      const M found = path_.locate_between(middle, inside, at);
      const V value = hn::IfThenElse(found, code_at(at), set(-1));
      const M is_high = hn::Ge(value, wanted);
      hit = hn::IfThenElse(is_cut, hit, hn::IfThenElse(is_high, middle, hit));
      high = hn::IfThenElse(is_high, middle, high);
      code_high = hn::IfThenElse(is_high, value, code_high);
      low = hn::IfThenElse(is_high, low, middle);
      code_low = hn::IfThenElse(is_high, code_low, value);
    }
    path_.locate_between(hit, inside, at);
    const V3 colour = shown(hit, entry_of(wanted), at);
    const V alpha = set(task_.surface_alpha);
    light_.x = hn::IfThenElse(inside, hn::Mul(alpha, colour.x), light_.x);
    light_.y = hn::IfThenElse(inside, hn::Mul(alpha, colour.y), light_.y);
    light_.z = hn::IfThenElse(inside, hn::Mul(alpha, colour.z), light_.z);
    alpha_ = hn::IfThenElse(inside, alpha, alpha_);
    begin_ = hn::IfThenElse(inside, hit, begin_);
    end_ = half_ = begin_;
    path_.end_lanes(inside);
  }

  /// Hands runs on and begins new ones.
  HWY_INLINE void emit(M lanes) {
    const DF df;
    if (hn::AllFalse(df, lanes))
      return;
    HWY_ALIGN float is_ended[most_lanes], r[most_lanes], g[most_lanes], b[most_lanes], a[most_lanes],
        begin[most_lanes], end[most_lanes], half[most_lanes];
    hn::Store(hn::IfThenElseZero(lanes, set(1)), df, is_ended);
    hn::Store(light_.x, df, r);
    hn::Store(light_.y, df, g);
    hn::Store(light_.z, df, b);
    hn::Store(alpha_, df, a);
    hn::Store(begin_, df, begin);
    hn::Store(end_, df, end);
    hn::Store(half_, df, half);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(block_.n); ++lane)
      if (is_ended[lane] != 0)
        sink_.runs.push_back({block_.in_tile[lane],
                              {begin[lane], end[lane], half[lane], {r[lane], g[lane], b[lane], a[lane]}}});
    light_.x = hn::IfThenZeroElse(lanes, light_.x);
    light_.y = hn::IfThenZeroElse(lanes, light_.y);
    light_.z = hn::IfThenZeroElse(lanes, light_.z);
    alpha_ = hn::IfThenZeroElse(lanes, alpha_);
  }

  const CastTask& task_;
  const PixelBlock& block_;
  Path path_;
  bool one_by_one_;
  RunSink& sink_;
  V3 light_;
  V alpha_, begin_, end_, half_; ///< of the run that is open
  V clear_;                      ///< what is left of the ray's transparency
  V largest_;                    ///< code met so far, of maxima
};

std::int64_t lanes() {
  return static_cast<std::int64_t>(hn::Lanes(DF()));
}

void cast(const CastTask& task, const PixelBlock& block, const TileStretches* stretches, bool one_by_one,
          RunSink& sink) {
  if (stretches == nullptr) {
    const RigidRays path(task, block);
    if (task.codes16 != nullptr)
      Cast<RigidRays, true>(task, block, path, one_by_one, sink).run();
    else
      Cast<RigidRays, false>(task, block, path, one_by_one, sink).run();
    return;
  }
  const DeformedRays path(task, block, *stretches);
  if (task.codes16 != nullptr)
    Cast<DeformedRays, true>(task, block, path, one_by_one, sink).run();
  else
    Cast<DeformedRays, false>(task, block, path, one_by_one, sink).run();
}

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::render {

HWY_EXPORT(lanes);
HWY_EXPORT(cast);

int lanes_of_cast() {
  return static_cast<int>(HWY_DYNAMIC_DISPATCH(lanes)());
}

void cast_block(const CastTask& task, const PixelBlock& block, const TileStretches* stretches,
                bool one_by_one, RunSink& sink) {
  HWY_DYNAMIC_DISPATCH(cast)(task, block, stretches, one_by_one, sink);
}

} // namespace maille::render
#endif
