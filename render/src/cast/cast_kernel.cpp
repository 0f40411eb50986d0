/// Ray casting of one object, vectorised over rays.
///
/// Each lane carries one ray. A step takes one sample of every lane: locate() finds the place in the volume
/// (through the deformation, if any), look() interpolates the value and reads opacity from the look's table,
/// take() composites front to back: alpha += (1 - alpha) a. A ray ends when its transparency is below
/// `spent`. Its visible stretches are stored as runs (depth, premultiplied colour), which the renderer merges
/// by depth with those of other objects. Lanes whose rays ended are refilled from the block's other pixels.
/// Shading is deferred (Shading), since half of the samples are invisible.
///
/// Exact: samples have fixed depths, (n + 1/2) step, so a picture does not depend on lanes, tiles or order.
/// Approximate: a run of samples has one depth range for merging; interleaved objects are cast again one by
/// one.

#include "cast/cast_task.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cast/cast_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cast/deformed_rays-inl.hpp"
#include "cast/rays-inl.hpp"
#include "cast/sampling-inl.hpp"
#include "cast/shading-inl.hpp"

#include <bit>
#include <cstdint>
#include <span>

// Compiled once per vector target: definitions must be in the target's namespace.

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

/// Transparency at which a ray ends: less than half of 1/255 of any colour.
constexpr float spent = 1.0f / 1024;
/// Number of invisible samples that ends a run.
constexpr float gap = 3.5f;

/// Casts pixels through one object: each lane follows one ray to its end, then takes the next. Rays of a
/// block end at different depths; without refilling, most lanes would be idle at the end.
/// @tparam is_surface  isosurfaces: separate because their state and search would slow down the other modes
template<class Path, bool is_wide, bool is_surface>
class Cast {
public:
  /// One sample of every active ray.
  struct Step {
    M active, there; ///< active rays; rays with possibly visible matter here
    V t, next;       ///< depth; number of the sample after this one
    V3 at;
    Place place;
    V code, alpha;
    VI entry;
  };

  /// @param of_path  further arguments of the path
  template<class... Of>
  Cast(const CastTask& task, std::span<const PixelBlock> blocks, bool one_by_one, RunSink& sink,
       Of&... of_path)
      : task_(task), blocks_(blocks), path_(task, of_path...), started_(task, of_path...),
        one_by_one_(one_by_one), sink_(sink), shading_(task, sink) {
    alive_ = hn::MaskFromVec(hn::Zero(DF()));
    alpha_ = begin_ = end_ = half_ = clear_ = hn::Zero(DF());
    largest_ = {set(-1), alpha_, hn::Zero(DI()), {alpha_, alpha_, alpha_}};
    before_ = {set(-1), set(-1), alpha_};
  }

  /// Casts all rays to their end.
  void run() {
    Step step;
    for (;;) {
      step.active = hn::And(alive_, hn::Le(path_.sample, path_.last));
      if (is_to_change(step.active)) {
        change(hn::AndNot(step.active, alive_));
        if (n_alive_ == 0)
          break;
        continue;
      }
      locate(step);
      if (!hn::AllFalse(DF(), step.there)) {
        look(step);
        take(step);
      }
      advance(step);
    }
    shading_.finish();
  }

  HWY_INLINE void locate(Step& step) {
    step.t = hn::Mul(hn::Add(path_.sample, set(0.5f)), set(task_.step));
    step.next = hn::Add(path_.sample, set(1));
    step.there = path_.locate(step.t, step.active, step.at, step.place, step.next);
  }
  HWY_INLINE void look(Step& step) const {
    step.code = between_codes<is_wide>(codes(), step.place, task_.stride);
    step.entry = entry_of(step.code);
    step.alpha = hn::Zero(DF());
    // Half of the vectors are invisible: comparing codes is faster than a table look-up.
    if (!hn::AllFalse(DI(), hn::Gt(step.entry, set_int(task_.last_unseen))))
      step.alpha = gather(task_.alpha, step.entry);
  }
  HWY_INLINE void take(const Step& step) {
    if constexpr (is_surface)
      return take_below_or_inside(step);
    if (task_.mode == LookMode::maximum)
      return take_largest(step, hn::And(step.there, hn::Gt(step.code, largest_.code)));
    const M visible = hn::And(step.there, hn::Gt(step.alpha, set(0)));
    if (!hn::AllFalse(DF(), visible))
      add(step, visible);
  }
  HWY_INLINE void advance(const Step& step) {
    path_.sample = hn::IfThenElse(step.active, step.next, path_.sample);
  }

private:
  /// True if refilling lanes pays off: it costs as much as some samples.
  HWY_INLINE bool is_to_change(M active) const {
    if constexpr (!Path::changes_early)
      return hn::AllFalse(DF(), active);
    constexpr std::size_t lanes = hn::MaxLanes(DF()), few = lanes < 2 ? 1 : lanes / 2;
    const std::size_t n = hn::CountTrue(DF(), active);
    return n == 0 || (has_pixels() ? lanes : n_alive_) - n >= few;
  }
  HWY_INLINE bool has_pixels() const { return left_ != 0 || next_block_ < blocks_.size(); }
  /// Moves rays that have left a part of their object to its next part, and frees the lanes of ended ones.
  HWY_INLINE void change(M ended) {
    if constexpr (is_surface)
      look_at_the_end(ended);
    const M over = hn::AndNot(path_.goes_on(ended), ended);
    const M seen = hn::And(over, hn::Gt(alpha_, set(0)));
    if (task_.mode == LookMode::maximum && !hn::AllFalse(DF(), seen)) {
      open(seen, largest_.t, largest_.t);
      push(seen, largest_.t, largest_.entry, largest_.at, alpha_);
    }
    close(seen);
    alive_ = hn::AndNot(over, alive_);
    n_alive_ = hn::CountTrue(DF(), alive_);
    while (n_alive_ < hn::Lanes(DF()) && has_pixels())
      fill();
  }
  /// Fills free lanes with rays of the current block.
  HWY_INLINE void fill() {
    if (left_ == 0) {
      left_ = bits_of(started_.start(blocks_[next_block_++]));
      return;
    }
    const PixelBlock& block = blocks_[next_block_ - 1];
    HWY_ALIGN std::int32_t from[most_lanes] = {}, is_taken[most_lanes] = {};
    for_each_lane(hn::Not(alive_), [&](std::size_t lane) {
      if (left_ == 0)
        return;
      const int other = std::countr_zero(left_);
      left_ &= left_ - 1;
      from[lane] = other;
      is_taken[lane] = 1;
      in_tile_[lane] = block.in_tile[other];
    });
    const M taken = hn::RebindMask(DF(), hn::Gt(hn::Load(DI(), is_taken), hn::Zero(DI())));
    path_.take(Change(taken, from), started_, in_tile_);
    clear_ = hn::IfThenElse(taken, set(1), clear_);
    largest_.code = hn::IfThenElse(taken, set(-1), largest_.code);
    before_.earlier = hn::IfThenElse(taken, set(-1), before_.earlier);
    before_.code = hn::IfThenElse(taken, set(-1), before_.code);
    alive_ = hn::Or(alive_, taken);
    n_alive_ = hn::CountTrue(DF(), alive_);
  }

  HWY_INLINE const void* codes() const {
    return is_wide ? static_cast<const void*>(task_.codes16) : task_.codes8;
  }
  HWY_INLINE V code_at(const V3& at) const {
    return between_codes<is_wide>(codes(), place_in(at, task_.size, task_.stride), task_.stride);
  }
  HWY_INLINE VI entry_of(V code) const {
    return hn::ConvertTo(DI(), hn::MulAdd(code, set(task_.table_scale), set(0.5f)));
  }
  HWY_INLINE void push(M lanes, V t, VI entry, const V3& at, V weight) {
    shading_.push(lanes, t, entry, at, weight, hn::Load(DI(), run_), path_);
  }

  /// Composites a visible sample in front of the later ones.
  HWY_INLINE void add(const Step& step, M visible) {
    const DF df;
    const V half_step = set(0.5f * task_.step), t = step.t;
    const M has_run = hn::And(visible, hn::Gt(alpha_, set(0)));
    close(one_by_one_ ? has_run : hn::And(has_run, hn::Gt(hn::Sub(t, end_), set((gap - 0.5f) * task_.step))));
    open(hn::AndNot(hn::Gt(alpha_, set(0)), visible), hn::Sub(t, half_step), t);
    const V weight = hn::IfThenElseZero(visible, hn::Mul(hn::Sub(set(1), alpha_), step.alpha));
    push(visible, t, step.entry, step.at, weight);
    const V before = alpha_;
    alpha_ = hn::Add(alpha_, weight);
    end_ = hn::IfThenElse(visible, hn::Add(t, half_step), end_);
    half_ = hn::IfThenElse(hn::And(hn::Lt(before, set(0.5f)), hn::Ge(alpha_, set(0.5f))), t, half_);
    clear_ = hn::IfThenElse(visible, hn::Mul(clear_, hn::Sub(set(1), step.alpha)), clear_);
    const M ends = hn::And(visible, hn::Lt(clear_, set(spent)));
    if (!hn::AllFalse(df, ends))
      path_.end_lanes(ends);
  }

  HWY_INLINE void take_largest(const Step& step, M larger) {
    if (hn::AllFalse(DF(), larger))
      return;
    alpha_ = hn::IfThenElse(larger, step.alpha, alpha_);
    largest_.code = hn::IfThenElse(larger, step.code, largest_.code);
    largest_.t = hn::IfThenElse(larger, step.t, largest_.t);
    largest_.entry = hn::IfThenElse(hn::RebindMask(DI(), larger), step.entry, largest_.entry);
    largest_.at = {hn::IfThenElse(larger, step.at.x, largest_.at.x),
                   hn::IfThenElse(larger, step.at.y, largest_.at.y),
                   hn::IfThenElse(larger, step.at.z, largest_.at.z)};
  }

  /// Isosurfaces: a ray may be inside for less than a step, between samples. Searches such parts where
  /// sampled values have a maximum.
  HWY_INLINE void take_below_or_inside(const Step& step) {
    const V code = hn::IfThenElse(step.there, step.code, set(-1));
    const M follows =
        hn::And(step.there, hn::Lt(hn::Sub(step.t, before_.t), set(1.5f * task_.step))); // no skip between
    const M hit = look_around_before(hn::IfThenElse(follows, code, set(-1)));
    const M inside = hn::AndNot(hit, hn::And(step.there, hn::Ge(code, set(task_.isocode))));
    take_surface(step.t, inside, code);
    before_.earlier = hn::IfThenElse(follows, before_.code, set(-1));
    before_.code = hn::IfThenElse(hn::Or(hit, inside), set(-1), code);
    before_.t = hn::IfThenElse(step.there, step.t, before_.t);
  }
  HWY_INLINE void look_at_the_end(M ended) {
    const V code = before_.code, earlier = before_.earlier;
    before_.code = hn::IfThenElse(ended, code, set(-1));
    look_around_before(set(-1));
    before_.code = hn::IfThenElse(ended, set(-1), code);
    before_.earlier = hn::IfThenElse(ended, set(-1), earlier);
  }
  /// @param after  codes of the samples after the stored ones; -1: none. @return rays that hit the surface
  HWY_INLINE M look_around_before(V after) {
    const DF df;
    const V wanted = set(task_.isocode), middle = before_.code;
    // Assumes that values rise by at most twice the difference to the samples around; unknown ones (-1) allow
    // more.
    const V rise = hn::Max(hn::Sub(middle, before_.earlier), hn::Sub(middle, after));
    M looked = hn::And(hn::And(hn::Ge(middle, set(0)), hn::Lt(middle, wanted)),
                       hn::And(hn::Ge(middle, before_.earlier), hn::Ge(middle, after)));
    looked = hn::And(looked, hn::Ge(hn::MulAdd(rise, set(2), middle), wanted));
    M hit = hn::MaskFromVec(hn::Zero(df));
    if (hn::AllFalse(df, looked))
      return hit;
    V best = middle, best_t = before_.t, apart = set(0.5f * task_.step);
    constexpr int rounds = 5; // finds parts inside that last 1/32 step
    for (int round = 0; round < rounds; ++round, apart = hn::Mul(apart, set(0.5f))) {
      const V centre = best_t;
      for (const float side : {-1.0f, 1.0f}) {
        const V t = hn::Min(hn::Max(hn::MulAdd(apart, set(side), centre), path_.begin), path_.end);
        V3 at;
        const M there = path_.locate_between(t, looked, at);
        const V code = hn::IfThenElse(there, code_at(at), set(-1));
        const M is_higher = hn::Gt(code, best);
        best = hn::IfThenElse(is_higher, code, best);
        best_t = hn::IfThenElse(is_higher, t, best_t);
      }
    }
    hit = hn::And(looked, hn::Ge(best, wanted));
    take_surface(best_t, hit, best);
    return hit;
  }

  /// At the first sample inside: finds the intersection between it and the sample before.
  HWY_INLINE void take_surface(V t, M inside, V code) {
    const DF df;
    if (hn::AllFalse(df, inside))
      return;
    V low = hn::Max(hn::Sub(t, set(task_.step)), path_.begin), high = t;
    V3 at;
    const M is_below = path_.locate_between(low, inside, at);
    V code_low = hn::IfThenElse(is_below, code_at(at), set(-1)), code_high = code;
    const V wanted = set(task_.isocode);
    const M is_cut = hn::Ge(code_low, wanted); // already inside at the start of the ray
    V hit = hn::IfThenElse(is_cut, low, high);
    for (int round = 0; round < 4; ++round) {
      const V part = hn::Div(hn::Sub(wanted, code_low), hn::Max(hn::Sub(code_high, code_low), set(1e-6f)));
      // Stays away from the ends, where rounding could stall the search.
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
    path_.end_lanes(inside);
    if (!(task_.surface_alpha > 0))
      return;
    open(inside, hit, hit);
    alpha_ = hn::IfThenElse(inside, set(task_.surface_alpha), alpha_);
    push(inside, hit, entry_of(wanted), at, alpha_);
  }

  /// Opens runs for rays without one.
  HWY_INLINE void open(M lanes, V begin, V end) {
    const DF df;
    if (hn::AllFalse(df, lanes))
      return;
    begin_ = hn::IfThenElse(lanes, begin, begin_);
    end_ = hn::IfThenElse(lanes, end, end_);
    half_ = hn::IfThenElse(lanes, end, half_);
    std::size_t number = sink_.runs.size();
    sink_.runs.resize(number + hn::CountTrue(df, lanes));
    for_each_lane(lanes, [&](std::size_t lane) {
      run_[lane] = static_cast<std::int32_t>(number);
      sink_.runs[number++].first = in_tile_[lane];
    });
  }
  /// Closes runs; only shading may still be pending.
  HWY_INLINE void close(M lanes) {
    const DF df;
    if (hn::AllFalse(df, lanes))
      return;
    HWY_ALIGN float a[most_lanes] = {}, begin[most_lanes] = {}, end[most_lanes] = {}, half[most_lanes] = {};
    hn::Store(alpha_, df, a);
    hn::Store(begin_, df, begin);
    hn::Store(end_, df, end);
    hn::Store(half_, df, half);
    for_each_lane(lanes, [&](std::size_t lane) {
      Run& run = sink_.runs[run_[lane]].second;
      run.begin = begin[lane];
      run.end = end[lane];
      run.half = half[lane];
      run.rgba[3] = a[lane];
    });
    alpha_ = hn::IfThenZeroElse(lanes, alpha_);
  }

  const CastTask& task_;
  std::span<const PixelBlock> blocks_;
  std::size_t next_block_ = 0;
  std::uint64_t left_ = 0; ///< rays of the current block without a lane, one bit each
  Path path_, started_;
  bool one_by_one_;
  RunSink& sink_;
  Shading<Path> shading_;
  M alive_; ///< lanes that have a ray
  std::size_t n_alive_ = 0;
  V alpha_, begin_, end_, half_; ///< of the open run
  V clear_;                      ///< remaining transparency of the ray
  struct {
    V code, t;
    VI entry;
    V3 at;
  } largest_; ///< maximum mode: largest sample so far
  struct {
    V earlier, code, t;
  } before_;                                        ///< isosurfaces: the last two samples; codes -1: none
  HWY_ALIGN std::int32_t run_[most_lanes] = {};     ///< numbers of the open runs
  HWY_ALIGN std::int32_t in_tile_[most_lanes] = {}; ///< the pixels of the lanes
};

template<bool is_wide, bool is_surface>
void cast_wide(const CastTask& task, std::span<const PixelBlock> blocks, const TileStretches* stretches,
               bool one_by_one, RunSink& sink) {
  if (stretches == nullptr)
    return Cast<RigidRays, is_wide, is_surface>(task, blocks, one_by_one, sink).run();
  Cast<DeformedRays, is_wide, is_surface>(task, blocks, one_by_one, sink, *stretches).run();
}

std::int64_t lanes() {
  return static_cast<std::int64_t>(hn::Lanes(DF()));
}

void cast(const CastTask& task, std::span<const PixelBlock> blocks, const TileStretches* stretches,
          bool one_by_one, RunSink& sink) {
  const bool is_wide = task.codes16 != nullptr, is_surface = task.mode == LookMode::isosurface;
  const auto chosen = is_wide      ? is_surface ? cast_wide<true, true> : cast_wide<true, false>
                           : is_surface ? cast_wide<false, true>
                                   : cast_wide<false, false>;
  chosen(task, blocks, stretches, one_by_one, sink);
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

void cast_blocks(const CastTask& task, std::span<const PixelBlock> blocks, const TileStretches* stretches,
                 bool one_by_one, RunSink& sink) {
  HWY_DYNAMIC_DISPATCH(cast)(task, blocks, stretches, one_by_one, sink);
}

} // namespace maille::render
#endif
