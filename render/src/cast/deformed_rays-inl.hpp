// Path of rays in a deformed body, from cell to cell of its lattice. Included once per vector target.

#if defined(MAILLE_DEFORMED_RAYS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_DEFORMED_RAYS_INL_HPP
#undef MAILLE_DEFORMED_RAYS_INL_HPP
#else
#define MAILLE_DEFORMED_RAYS_INL_HPP
#endif

#include "cast/rays-inl.hpp"
#include "cast/sampling-inl.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

// Nodes have four numbers each. In every group of four lanes, vector i holds the node of lane i; after the
// transpose each vector holds one number of all lanes.
constexpr std::size_t n_groups = 4;
#if HWY_TARGET == HWY_SCALAR // one lane: each group is one number of the node
HWY_INLINE V nodes_at(const float* nodes, const std::int32_t* at, std::size_t group) {
  return set(nodes[std::ptrdiff_t{4} * at[0] + static_cast<std::ptrdiff_t>(group)]);
}
template<int group>
HWY_INLINE V of_group(V number) {
  return number;
}
constexpr std::uint64_t lanes_of_group(int /*group*/) {
  return 1;
}
HWY_INLINE V3 of_lanes(const V (&of)[n_groups]) {
  return {of[0], of[1], of[2]};
}
#else
template<class D>
HWY_INLINE hn::Vec<D> node_blocks(D d, const float* nodes, const std::int32_t* at) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, nodes + std::ptrdiff_t{4} * at[0]);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, node_blocks(half, nodes, at + hn::MaxLanes(half)), node_blocks(half, nodes, at));
  }
}
HWY_INLINE V nodes_at(const float* nodes, const std::int32_t* at, std::size_t group) {
  return node_blocks(DF(), nodes, at + group);
}
template<int group>
HWY_INLINE V of_group(V number) {
  return hn::Broadcast<group>(number); // in every four lanes
}
constexpr std::uint64_t lanes_of_group(int group) {
  return 0x1111ull << group;
}
HWY_INLINE V3 of_lanes(const V (&of)[n_groups]) {
  const DF df;
  const V low = hn::InterleaveLower(df, of[0], of[2]), next = hn::InterleaveLower(df, of[1], of[3]);
  return {
      hn::InterleaveLower(df, low, next), hn::InterleaveUpper(df, low, next),
      hn::InterleaveLower(df, hn::InterleaveUpper(df, of[0], of[2]), hn::InterleaveUpper(df, of[1], of[3]))};
}
#endif

/// Rays through a deformed lattice: every sample is mapped back to rest by Newton iteration on the cell's
/// trilinear map, starting from the sample before. A ray passes several stretches of matter.
class DeformedRays {
public:
  static constexpr bool changes_early = true;
  DeformedRays(const CastTask& task, const TileStretches& stretches)
      : task_(task), stretches_(stretches), next_{}, end_{} {
    const V none = hn::Zero(DF());
    begin = end = cut = sample = open_ = close_ = depth_ = beyond_ = none;
    last = set(-1);
    rays_.origin = rays_.direction = rest_ = rate_ = across_x_ = across_y_ = across_z_ = {none, none, none};
  }

  /// Starts the rays of a block; take() sets their stretches.
  HWY_INLINE M start(const PixelBlock& block) {
    rays_ = rays_of(task_, task_.object, block);
    open_ = hn::Zero(DF());
    close_ = set(far_away);
    cut = set(-far_away);
    clip(task_, rays_, open_, close_, cut);
    return hn::FirstN(DF(), static_cast<std::size_t>(block.n));
  }
  HWY_INLINE void take(const Change& change, const DeformedRays& started, const std::int32_t* in_tile) {
    change(rays_.origin, started.rays_.origin);
    change(rays_.direction, started.rays_.direction);
    change(open_, started.open_);
    change(close_, started.close_);
    change(cut, started.cut);
    for_each_lane(change.lanes(), [&](std::size_t lane) {
      const std::size_t pixel = in_tile[lane];
      next_[lane] = stretches_.first[pixel];
      end_[lane] = stretches_.first[pixel + 1];
    });
    end_stretch(change.lanes());
    goes_on(change.lanes());
  }

  HWY_INLINE M locate(V t, M active, V3& at, Place& place, V& /*next*/) {
    V3 rest = predicted(t);
    M found = newton(t, active, rest);
    const M lost = hn::AndNot(found, active);
    if (!hn::AllFalse(DF(), lost))
      found = hn::Or(found, over_fold(t, lost, rest));
    rest_ = {hn::IfThenElse(found, rest.x, rest_.x), hn::IfThenElse(found, rest.y, rest_.y),
             hn::IfThenElse(found, rest.z, rest_.z)};
    depth_ = hn::IfThenElse(found, t, depth_);
    at = in_voxels(rest);
    place = place_in(at, task_.size, task_.stride);
    const M matters = is_matter(rest, at);
    if (task_.leaves_voxels)
      cut_at_border(t, at, found, matters);
    // Before a clip plane that opens the body, rays only track their position.
    return hn::And(hn::And(found, matters), hn::Ge(t, open_));
  }
  /// The same for a point between samples.
  HWY_INLINE M locate_between(V t, M active, V3& at) {
    const V3 rate = rate_, x = across_x_, y = across_y_, z = across_z_;
    V3 rest = predicted(t);
    const M found = newton(t, active, rest);
    rate_ = rate;
    across_x_ = x;
    across_y_ = y;
    across_z_ = z;
    at = in_voxels(rest);
    return hn::And(found, is_matter(rest, at));
  }
  /// Number of values that transform gradients at the last located point.
  static constexpr int n_turning = 9;
  HWY_INLINE V turning(int i) const {
    const V3& row = i < 3 ? across_x_ : i < 6 ? across_y_ : across_z_;
    return i % 3 == 0 ? row.x : i % 3 == 1 ? row.y : row.z;
  }
  /// Transforms a gradient at rest by the deformation to the object's frame, of any length.
  template<class Turning>
  static HWY_INLINE V3 turned(const CastTask& task, const V3& gradient, const Turning& turning) {
    const V x = dot(task.gradient_rows[0], gradient), y = dot(task.gradient_rows[1], gradient),
            z = dot(task.gradient_rows[2], gradient);
    const auto sum = [&](int axis) HWY_ATTR {
      return hn::MulAdd(turning(axis), x, hn::MulAdd(turning(3 + axis), y, hn::Mul(turning(6 + axis), z)));
    };
    return {sum(0), sum(1), sum(2)};
  }
  /// Moves ended lanes to their next stretch. @return lanes that have one
  HWY_INLINE M goes_on(M ended) {
    const DF df;
    HWY_ALIGN float from[most_lanes], to[most_lanes] = {}, x[most_lanes] = {}, y[most_lanes] = {},
                                      z[most_lanes] = {}, opens[most_lanes];
    hn::Store(set(-1), df, from);
    hn::Store(open_, df, opens);
    for_each_lane(ended, [&](std::size_t lane) {
      while (next_[lane] < end_[lane] && stretches_.stretches[next_[lane]].end <= opens[lane])
        ++next_[lane];
      if (next_[lane] >= end_[lane])
        return;
      const Stretch& stretch = stretches_.stretches[next_[lane]++];
      from[lane] = stretch.begin;
      to[lane] = stretch.end;
      x[lane] = stretch.entry[0];
      y[lane] = stretch.entry[1];
      z[lane] = stretch.entry[2];
    });
    const V start = hn::Load(df, from);
    const M taken = hn::Ge(start, set(0));
    if (hn::AllFalse(df, taken))
      return taken;
    const V inverse_step = set(1 / task_.step);
    begin = hn::IfThenElse(taken, hn::Max(start, open_), begin);
    sample = hn::IfThenElse(taken, first_sample(start, inverse_step), sample);
    end = hn::IfThenElse(taken, hn::Min(hn::Load(df, to), close_), end);
    last = hn::IfThenElse(taken, last_sample(end, inverse_step), last);
    depth_ = hn::IfThenElse(taken, start, depth_);
    beyond_ = hn::IfThenZeroElse(taken, beyond_);
    rest_ = {hn::IfThenElse(taken, hn::Load(df, x), rest_.x), hn::IfThenElse(taken, hn::Load(df, y), rest_.y),
             hn::IfThenElse(taken, hn::Load(df, z), rest_.z)};
    rate_ = {hn::IfThenZeroElse(taken, rate_.x), hn::IfThenZeroElse(taken, rate_.y),
             hn::IfThenZeroElse(taken, rate_.z)};
    return taken;
  }
  HWY_INLINE void end_lanes(M lanes) {
    end_stretch(lanes);
    for_each_lane(lanes, [&](std::size_t lane) { next_[lane] = end_[lane]; });
  }

  V begin, end, cut, sample, last;

private:
  HWY_INLINE void end_stretch(M lanes) { last = hn::IfThenElse(lanes, set(-1), last); }
  HWY_INLINE V3 predicted(V t) const {
    const V ahead = hn::Sub(t, depth_);
    return {hn::MulAdd(rate_.x, ahead, rest_.x), hn::MulAdd(rate_.y, ahead, rest_.y),
            hn::MulAdd(rate_.z, ahead, rest_.z)};
  }
  HWY_INLINE V3 in_voxels(const V3& rest) const {
    return {hn::Add(dot(task_.voxel_rows[0], rest), set(task_.voxel_offset[0])),
            hn::Add(dot(task_.voxel_rows[1], rest), set(task_.voxel_offset[1])),
            hn::Add(dot(task_.voxel_rows[2], rest), set(task_.voxel_offset[2]))};
  }
  /// Treats the border of an image like a clip plane.
  HWY_INLINE void cut_at_border(V t, const V3& at, M found, M matters) {
    const M enters = hn::And(hn::And(found, matters), hn::Gt(beyond_, set(0)));
    if (!hn::AllFalse(DF(), enters)) {
      const auto since = [&](V along, std::size_t axis) HWY_ATTR { // that axis' border was passed
        const V speed = dot(task_.voxel_rows[axis], rate_);
        const V border =
            hn::IfThenElse(hn::Gt(speed, set(0)), set(0), set(static_cast<float>(task_.size[axis] - 1)));
        const V tiny = set(1e-12f);
        return hn::Div(hn::Sub(along, border), hn::IfThenElse(hn::Lt(hn::Abs(speed), tiny), tiny, speed));
      };
      const V ago = hn::Max(hn::Min(since(at.x, 0), hn::Min(since(at.y, 1), since(at.z, 2))), set(0));
      cut = hn::IfThenElse(enters, hn::Max(cut, hn::Sub(t, ago)), cut); // or a plane behind it
    }
    beyond_ = hn::IfThenElse(found, hn::IfThenElse(matters, set(0), set(1)), beyond_);
  }
  static HWY_INLINE M is_between(V at, float low, float high) {
    return hn::And(hn::Ge(at, set(low)), hn::Le(at, set(high)));
  }
  /// @param at  the same point in voxels: the sampled region ends at the outermost centres
  HWY_INLINE M is_matter(const V3& rest, const V3& at) const {
    const M in = within(rest);
    if (!task_.leaves_voxels)
      return in;
    return hn::And(in, hn::And(is_between(at.x, 0, static_cast<float>(task_.size[0] - 1)),
                               hn::And(is_between(at.y, 0, static_cast<float>(task_.size[1] - 1)),
                                       is_between(at.z, 0, static_cast<float>(task_.size[2] - 1)))));
  }
  HWY_INLINE M within(const V3& rest) const {
    constexpr float slack = lattice_slack;
    M in = hn::And(is_between(rest.x, -slack, static_cast<float>(task_.cells[0]) + slack),
                   hn::And(is_between(rest.y, -slack, static_cast<float>(task_.cells[1]) + slack),
                           is_between(rest.z, -slack, static_cast<float>(task_.cells[2]) + slack)));
    if (task_.has_crop)
      in = hn::And(in, hn::And(is_between(rest.x, task_.crop_low[0], task_.crop_high[0]),
                               hn::And(is_between(rest.y, task_.crop_low[1], task_.crop_high[1]),
                                       is_between(rest.z, task_.crop_low[2], task_.crop_high[2]))));
    return in;
  }

  /// Trilinear maps of the cells of lanes: points and derivatives along the edges of the cell.
  struct Mapped {
    V3 at, along_x, along_y, along_z;
  };
  /// The same for one group of lanes, not yet transposed.
  struct MappedGroups {
    V at[n_groups], along_x[n_groups], along_y[n_groups], along_z[n_groups];
  };
  template<int group>
  HWY_INLINE void map_group(const std::int32_t* nodes, const V3& part, MappedGroups& out) const {
    const std::ptrdiff_t row = std::ptrdiff_t{4} * task_.node_stride[1],
                         plane = std::ptrdiff_t{4} * task_.node_stride[2];
    const auto corner = [&](std::ptrdiff_t further)
                            HWY_ATTR { return nodes_at(task_.nodes + further, nodes, group); };
    const V x = of_group<group>(part.x), y = of_group<group>(part.y), z = of_group<group>(part.z);
    // Edges along x, then faces, then the cell.
    const V a = corner(0), b = corner(row), c = corner(plane), d = corner(plane + row);
    const V ax = hn::Sub(corner(4), a), bx = hn::Sub(corner(row + 4), b), cx = hn::Sub(corner(plane + 4), c),
            dx = hn::Sub(corner(plane + row + 4), d);
    const V ea = hn::MulAdd(ax, x, a), eb = hn::MulAdd(bx, x, b), ec = hn::MulAdd(cx, x, c),
            ed = hn::MulAdd(dx, x, d);
    const V near = hn::Sub(eb, ea), far = hn::Sub(ed, ec);
    const V low = hn::MulAdd(near, y, ea), high = hn::MulAdd(far, y, ec);
    const V rise = hn::Sub(high, low);
    const V low_x = hn::MulAdd(hn::Sub(bx, ax), y, ax), high_x = hn::MulAdd(hn::Sub(dx, cx), y, cx);
    out.at[group] = hn::MulAdd(rise, z, low);
    out.along_x[group] = hn::MulAdd(hn::Sub(high_x, low_x), z, low_x);
    out.along_y[group] = hn::MulAdd(hn::Sub(far, near), z, near);
    out.along_z[group] = rise;
  }
  HWY_INLINE Mapped map(VI node, const V3& part, M wanted) const {
    HWY_ALIGN std::int32_t nodes[most_lanes];
    hn::Store(node, DI(), nodes);
    const std::uint64_t bits = bits_of(wanted);
    MappedGroups of;
    const V none = hn::Zero(DF());
    for (std::size_t group = 0; group < n_groups; ++group)
      of.at[group] = of.along_x[group] = of.along_y[group] = of.along_z[group] = none;
    if ((bits & lanes_of_group(0)) != 0)
      map_group<0>(nodes, part, of);
    if ((bits & lanes_of_group(1)) != 0)
      map_group<1>(nodes, part, of);
    if ((bits & lanes_of_group(2)) != 0)
      map_group<2>(nodes, part, of);
    if ((bits & lanes_of_group(3)) != 0)
      map_group<3>(nodes, part, of);
    return {of_lanes(of.at), of_lanes(of.along_x), of_lanes(of.along_y), of_lanes(of.along_z)};
  }

  static HWY_INLINE void cell_along(V rest, std::int32_t cells, VI& cell, V& part) {
    const V limit = set(static_cast<float>(cells - 1));
    const V low = hn::Min(hn::Max(hn::Floor(rest), hn::Zero(DF())), limit);
    cell = hn::ConvertTo(DI(), low);
    part = hn::Sub(rest, low);
  }

  /// Maps the rays' points at depth t back to rest, from a guess. @return lanes that converged
  HWY_INLINE M newton(V t, M active, V3& rest) {
    constexpr float near_enough = 0.01f; // [cells]; quadratic convergence squares it
    constexpr float longest = 1.5f;      // limits a step from a wrong cell
    const V3 goal{hn::MulAdd(rays_.direction.x, t, rays_.origin.x),
                  hn::MulAdd(rays_.direction.y, t, rays_.origin.y),
                  hn::MulAdd(rays_.direction.z, t, rays_.origin.z)};
    M pending = active, found = hn::MaskFromVec(hn::Zero(DF()));
    for (int round = 0; round < 10 && !hn::AllFalse(DF(), pending); ++round) {
      VI cx, cy, cz;
      V3 part;
      cell_along(rest.x, task_.cells[0], cx, part.x);
      cell_along(rest.y, task_.cells[1], cy, part.y);
      cell_along(rest.z, task_.cells[2], cz, part.z);
      const VI node = hn::Add(cx, hn::Add(hn::Mul(cy, set_int(task_.node_stride[1])),
                                          hn::Mul(cz, set_int(task_.node_stride[2]))));
      const Mapped mapped = map(node, part, pending);
      const V3 x = cross(mapped.along_y, mapped.along_z), y = cross(mapped.along_z, mapped.along_x),
               z = cross(mapped.along_x, mapped.along_y);
      const V volume = dot(mapped.along_x, x);
      // Folded or flat cells have no inverse: skips the sample.
      const M is_good = hn::Gt(volume, set(std::numeric_limits<float>::min()));
      const V inverse = hn::Div(set(1), hn::IfThenElse(is_good, volume, set(1)));
      const V3 off{hn::Sub(mapped.at.x, goal.x), hn::Sub(mapped.at.y, goal.y), hn::Sub(mapped.at.z, goal.z)};
      const auto limited = [&](const V3& row) HWY_ATTR {
        return hn::Min(hn::Max(hn::Mul(dot(row, off), inverse), set(-longest)), set(longest));
      };
      const V3 change{limited(x), limited(y), limited(z)};
      pending = hn::And(pending, is_good);
      rest = {hn::IfThenElse(pending, hn::Sub(rest.x, change.x), rest.x),
              hn::IfThenElse(pending, hn::Sub(rest.y, change.y), rest.y),
              hn::IfThenElse(pending, hn::Sub(rest.z, change.z), rest.z)};
      const V largest = hn::Max(hn::Abs(change.x), hn::Max(hn::Abs(change.y), hn::Abs(change.z)));
      const M done = hn::And(pending, hn::Lt(largest, set(near_enough)));
      keep(done, x, across_x_);
      keep(done, y, across_y_);
      keep(done, z, across_z_);
      keep(done,
           {hn::Mul(dot(x, rays_.direction), inverse), hn::Mul(dot(y, rays_.direction), inverse),
            hn::Mul(dot(z, rays_.direction), inverse)},
           rate_);
      found = hn::Or(found, done);
      pending = hn::AndNot(done, pending);
    }
    return found;
  }
  /// At folded cells, restarts from the cells that follow. @return as newton
  HWY_INLINE M over_fold(V t, M lost, V3& rest) {
    const V3 from = predicted(t);
    const V speed =
        hn::Sqrt(hn::MulAdd(rate_.x, rate_.x, hn::MulAdd(rate_.y, rate_.y, hn::Mul(rate_.z, rate_.z))));
    const V cell = hn::Div(set(1), hn::Max(speed, set(1e-6f)));
    M found = hn::MaskFromVec(hn::Zero(DF()));
    for (const float cells : {1.0f, 2.0f, 3.0f}) {
      const V further = hn::Mul(cell, set(cells));
      V3 guess{hn::MulAdd(rate_.x, further, from.x), hn::MulAdd(rate_.y, further, from.y),
               hn::MulAdd(rate_.z, further, from.z)};
      const M now = newton(t, hn::AndNot(found, lost), guess);
      keep(now, guess, rest);
      found = hn::Or(found, now);
      if (hn::AllFalse(DF(), hn::AndNot(found, lost)))
        break;
    }
    return found;
  }
  static HWY_INLINE void keep(M lanes, const V3& from, V3& to) {
    to = {hn::IfThenElse(lanes, from.x, to.x), hn::IfThenElse(lanes, from.y, to.y),
          hn::IfThenElse(lanes, from.z, to.z)};
  }

  const CastTask& task_;
  const TileStretches& stretches_;
  Rays rays_;
  V open_, close_, depth_;
  V beyond_;                          ///< 1: the last point was beyond the end of the image
  V3 rest_, rate_;                    ///< of the last point, and their change with depth [cells, cells/m]
  V3 across_x_, across_y_, across_z_; ///< cofactors of the map's derivative there
  std::array<std::uint32_t, most_lanes> next_, end_;
};

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#endif
