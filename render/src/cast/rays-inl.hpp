// Path of rays through the voxels of a rigid object. Included once per vector target.

#if defined(MAILLE_RAYS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_RAYS_INL_HPP
#undef MAILLE_RAYS_INL_HPP
#else
#define MAILLE_RAYS_INL_HPP
#endif

#include "cast/sampling-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

constexpr float far_away = 1e30f;

/// Rays of a block of pixels: origin + t direction, in one frame; t in metres.
struct Rays {
  V3 origin, direction;
  V across, up, scale; ///< of RayFrame
};

HWY_INLINE V along_frame(V across, V up, float middle, float right, float upwards) {
  return hn::MulAdd(across, set(right), hn::MulAdd(up, set(upwards), set(middle)));
}

HWY_INLINE Rays rays_of(const CastTask& task, const RayFrame& frame, const PixelBlock& block) {
  const DF df;
  Rays rays;
  const V x = hn::ConvertTo(df, hn::LoadU(DI(), block.x.data())),
          y = hn::ConvertTo(df, hn::LoadU(DI(), block.y.data()));
  rays.across = hn::Mul(hn::Sub(x, set(task.middle_x)), set(task.pixel_scale));
  rays.up = hn::Mul(hn::Sub(set(task.middle_y), y), set(task.pixel_scale));
  // In perspective, across and up are slopes relative to the line of sight: directions are normalised.
  const V squared = hn::MulAdd(rays.across, rays.across, hn::MulAdd(rays.up, rays.up, set(1)));
  rays.scale = task.parallel ? set(1) : hn::Div(set(1), hn::Sqrt(squared));
  const auto origin = [&](std::size_t a) HWY_ATTR {
    return along_frame(rays.across, rays.up, frame.origin[a], frame.origin_right[a], frame.origin_up[a]);
  };
  const auto direction = [&](std::size_t a) HWY_ATTR {
    return hn::Mul(along_frame(rays.across, rays.up, frame.ahead[a], frame.right[a], frame.up[a]),
                   rays.scale);
  };
  rays.origin = {origin(0), origin(1), origin(2)};
  rays.direction = {direction(0), direction(1), direction(2)};
  return rays;
}

/// Clips rays by planes, and finds the depth at which a plane opened the body.
HWY_INLINE void clip(const CastTask& task, const Rays& rays, V& begin, V& end, V& cut) {
  for (const RayPlane& plane : task.clips) {
    const V at = along_frame(rays.across, rays.up, plane.origin, plane.origin_right, plane.origin_up);
    const V slope =
        hn::Mul(along_frame(rays.across, rays.up, plane.ahead, plane.right, plane.up), rays.scale);
    const V t = hn::Div(hn::Neg(at), slope);
    const M opens = hn::Gt(slope, set(0)), closes = hn::Lt(slope, set(0));
    const M later = hn::And(opens, hn::Gt(t, begin));
    cut = hn::IfThenElse(later, t, cut);
    begin = hn::IfThenElse(later, t, begin);
    end = hn::IfThenElse(closes, hn::Min(end, t), end);
    const M never = hn::AndNot(hn::Or(opens, closes), hn::Lt(at, set(0)));
    end = hn::IfThenElse(never, set(-far_away), end);
  }
}

/// First and last sample whose centres are between two depths; samples are numbered from the eye.
HWY_INLINE V first_sample(V begin, V inverse_step) {
  return hn::Ceil(hn::Sub(hn::Mul(begin, inverse_step), set(0.5f)));
}
HWY_INLINE V last_sample(V end, V inverse_step) {
  return hn::Floor(hn::Sub(hn::Mul(end, inverse_step), set(0.5f)));
}

/// Replaces ended lanes by lanes of other rays.
class Change {
public:
  /// @param from  per lane of `lanes`: the lane of the other rays that replaces it
  Change(M lanes, const std::int32_t* from) : lanes_(lanes), from_(hn::SetTableIndices(DF(), from)) {}
  M lanes() const { return lanes_; }
  HWY_INLINE void operator()(V& to, V of) const {
    to = hn::IfThenElse(lanes_, hn::TableLookupLanes(of, from_), to);
  }
  HWY_INLINE void operator()(V3& to, const V3& of) const {
    (*this)(to.x, of.x);
    (*this)(to.y, of.y);
    (*this)(to.z, of.z);
  }

private:
  M lanes_;
  decltype(hn::SetTableIndices(DF(), static_cast<const std::int32_t*>(nullptr))) from_;
};

/// Rays through voxels of a rigid object.
class RigidRays {
public:
  /// Rays of a block skip together: ended lanes wait for the others.
  static constexpr bool changes_early = false;
  explicit RigidRays(const CastTask& task) : task_(task) {
    begin = end = cut = sample = hn::Zero(DF());
    last = set(-1);
    rays_.origin = rays_.direction = inverse_ = {begin, begin, begin};
  }

  /// Starts the rays of a block, all lanes. @return those that meet the volume
  HWY_INLINE M start(const PixelBlock& block) {
    rays_ = rays_of(task_, task_.voxels, block);
    begin = hn::Zero(DF());
    end = set(far_away);
    slab(rays_.origin.x, rays_.direction.x, task_.size[0], begin, end);
    slab(rays_.origin.y, rays_.direction.y, task_.size[1], begin, end);
    slab(rays_.origin.z, rays_.direction.z, task_.size[2], begin, end);
    cut = begin; // the border of an image acts like a clip plane
    clip(task_, rays_, begin, end, cut);
    const V inverse_step = set(1 / task_.step);
    const auto depth = [&](const std::array<float, most_lanes>& ahead)
                           HWY_ATTR { return hn::Div(hn::LoadU(DF(), ahead.data()), rays_.scale); };
    sample = first_sample(hn::Max(begin, depth(block.nearest)), inverse_step);
    last = hn::IfThenElse(hn::Le(begin, end), last_sample(hn::Min(end, depth(block.farthest)), inverse_step),
                          set(-1));
    // Avoids 0 / 0 for rays along a plane of voxels.
    inverse_ = {inverse(rays_.direction.x), inverse(rays_.direction.y), inverse(rays_.direction.z)};
    return hn::And(hn::FirstN(DF(), static_cast<std::size_t>(block.n)), hn::Le(sample, last));
  }
  HWY_INLINE void take(const Change& change, const RigidRays& started, const std::int32_t* /*in_tile*/) {
    change(rays_.origin, started.rays_.origin);
    change(rays_.direction, started.rays_.direction);
    change(inverse_, started.inverse_);
    change(begin, started.begin);
    change(end, started.end);
    change(cut, started.cut);
    change(sample, started.sample);
    change(last, started.last);
  }

  /// Points at depth t. @return lanes of `active` with something visible; `next` skips empty space
  HWY_INLINE M locate(V t, M active, V3& at, Place& place, V& next) {
    at = point(t);
    place = place_in(at, task_.size, task_.stride);
    if (task_.brick_distance == nullptr)
      return active;
    const VI bx = hn::ShiftRight<shift>(place.x), by = hn::ShiftRight<shift>(place.y),
             bz = hn::ShiftRight<shift>(place.z);
    const VI brick = hn::Add(bx, hn::Add(hn::Mul(by, set_int(task_.brick_stride[1])),
                                         hn::Mul(bz, set_int(task_.brick_stride[2]))));
    const VI distance = distances(brick);
    const M empty = hn::RebindMask(DF(), hn::Gt(distance, set_int(0)));
    if (hn::AllFalse(DF(), hn::And(empty, active)))
      return active;
    const V leap = hn::Min(exit(at.x, rays_.direction.x, inverse_.x, bx, distance),
                           hn::Min(exit(at.y, rays_.direction.y, inverse_.y, by, distance),
                                   exit(at.z, rays_.direction.z, inverse_.z, bz, distance)));
    // Minus a thousandth, so that points moved to the border by rounding are sampled again.
    const V target = hn::Ceil(hn::Sub(hn::Mul(hn::Add(t, leap), set(1 / task_.step)), set(0.501f)));
    next = hn::IfThenElse(empty, hn::Max(next, target), next);
    return hn::AndNot(empty, active);
  }
  HWY_INLINE M locate_between(V t, M active, V3& at) {
    at = point(t);
    return active;
  }
  /// Number of values that transform gradients at a point: none for rigid objects.
  static constexpr int n_turning = 0;
  HWY_INLINE V turning(int /*i*/) const { return cut; }
  template<class Turning>
  static HWY_INLINE V3 turned(const CastTask&, const V3& gradient, const Turning&) {
    return gradient;
  }
  HWY_INLINE M goes_on(M /*ended*/) { return hn::MaskFromVec(hn::Zero(DF())); }
  HWY_INLINE void end_lanes(M lanes) { last = hn::IfThenElse(lanes, set(-1), last); }

  V begin, end, cut, sample, last;

private:
  HWY_INLINE V3 point(V t) const {
    return {hn::MulAdd(rays_.direction.x, t, rays_.origin.x),
            hn::MulAdd(rays_.direction.y, t, rays_.origin.y),
            hn::MulAdd(rays_.direction.z, t, rays_.origin.z)};
  }
  static HWY_INLINE V inverse(V direction) {
    const V tiny = set(1e-12f);
    return hn::Div(set(1), hn::IfThenElse(hn::Lt(hn::Abs(direction), tiny), tiny, direction));
  }
  static HWY_INLINE void slab(V origin, V direction, std::int32_t size, V& begin, V& end) {
    const V over = inverse(direction);
    const V a = hn::Mul(hn::Neg(origin), over),
            b = hn::Mul(hn::Sub(set(static_cast<float>(size - 1)), origin), over);
    begin = hn::Max(begin, hn::Min(a, b));
    end = hn::Min(end, hn::Max(a, b));
  }
  /// Lane by lane, as between_codes.
  HWY_INLINE VI distances(VI brick) const {
    HWY_ALIGN std::int32_t at[most_lanes], distance[most_lanes];
    hn::Store(brick, DI(), at);
    for (std::size_t lane = 0; lane < hn::Lanes(DI()); ++lane)
      distance[lane] = task_.brick_distance[at[lane]];
    return hn::Load(DI(), distance);
  }
  /// Distance until a ray leaves the empty bricks around it.
  static HWY_INLINE V exit(V at, V direction, V inverse, VI brick, VI distance) {
    const M rises = hn::Gt(direction, set(0));
    const VI border = hn::IfThenElse(hn::RebindMask(DI(), rises), hn::Add(brick, distance),
                                     hn::Add(hn::Sub(brick, distance), set_int(1)));
    return hn::Mul(hn::Sub(hn::ConvertTo(DF(), hn::ShiftLeft<shift>(border)), at), inverse);
  }

  static constexpr int shift = Volume::brick_shift;

  const CastTask& task_;
  Rays rays_;
  V3 inverse_;
};

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#endif
