// Values, gradients and colours at points between voxels, one vector of points at a time. Included once per
// vector target; has therefore no include guard.

#if defined(MAILLE_SAMPLING_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_SAMPLING_INL_HPP
#undef MAILLE_SAMPLING_INL_HPP
#else
#define MAILLE_SAMPLING_INL_HPP
#endif

#include "cast/cast_task.hpp"

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, most_lanes>;
using DI = hn::Rebind<std::int32_t, DF>;
using V = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using DU = hn::Rebind<std::uint32_t, DF>;
using M = hn::Mask<DF>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V set(float value) {
  return hn::Set(DF(), value);
}
HWY_INLINE VI set_int(std::int32_t value) {
  return hn::Set(DI(), value);
}
HWY_INLINE V lerp(V a, V b, V part) {
  return hn::MulAdd(hn::Sub(b, a), part, a);
}
HWY_INLINE V dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V dot(const Float3& a, const V3& b) {
  return hn::MulAdd(set(a[0]), b.x, hn::MulAdd(set(a[1]), b.y, hn::Mul(set(a[2]), b.z)));
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}
/// Gathers numbers; offsets are in numbers or in bytes.
HWY_INLINE V gather(const float* table, VI at) {
  return hn::GatherIndex(DF(), table, at);
}
HWY_INLINE VI gather_bytes(const void* base, VI offset) {
  return hn::GatherOffset(DI(), static_cast<const std::int32_t*>(base), offset);
}

/// Reads a number from unaligned memory.
template<class Number>
HWY_INLINE Number loaded(const void* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

/// Mask as one bit per lane.
HWY_INLINE std::uint64_t bits_of(M lanes) {
  HWY_ALIGN std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(DF(), lanes, bytes);
  return loaded<std::uint64_t>(bytes);
}
/// Calls `act` for the lanes of a mask, in order.
template<class Do>
HWY_INLINE void for_each_lane(M lanes, Do&& act) {
  for (std::uint64_t left = bits_of(lanes); left != 0; left &= left - 1)
    act(static_cast<std::size_t>(std::countr_zero(left)));
}

/// The cell between voxels that contains a point, and the position in it.
struct Place {
  VI base; ///< number of its lowest voxel
  V3 part; ///< 0 to 1
  VI x, y, z;
};

HWY_INLINE void place_along(V at, std::int32_t size, VI& low, V& part) {
  const DI di;
  const V inside = hn::Min(hn::Max(at, hn::Zero(DF())), set(static_cast<float>(size - 1)));
  low = hn::Min(hn::ConvertTo(di, inside), set_int(size > 1 ? size - 2 : 0));
  part = hn::Sub(inside, hn::ConvertTo(DF(), low));
}

HWY_INLINE Place place_in(const V3& at, const std::array<std::int32_t, 3>& size,
                          const std::array<std::int32_t, 3>& stride) {
  Place place;
  place_along(at.x, size[0], place.x, place.part.x);
  place_along(at.y, size[1], place.y, place.part.y);
  place_along(at.z, size[2], place.z, place.part.z);
  place.base =
      hn::Add(place.x, hn::Add(hn::Mul(place.y, set_int(stride[1])), hn::Mul(place.z, set_int(stride[2]))));
  return place;
}

/// Interpolated codes of 8 or 16 bits. Lane by lane, because gathering is slower than loading lanes.
template<bool is_wide>
HWY_INLINE V between_codes(const void* codes, const Place& at, const std::array<std::int32_t, 3>& stride) {
  using Pair = std::conditional_t<is_wide, std::uint32_t, std::uint16_t>;
  constexpr std::ptrdiff_t bytes = is_wide ? 2 : 1;
  const std::ptrdiff_t row = bytes * stride[1], plane = bytes * stride[2];
  HWY_ALIGN std::int32_t base[most_lanes];
  hn::Store(at.base, DI(), base);
  HWY_ALIGN std::uint32_t pairs[4][most_lanes]; // of neighbours along x
  for (std::size_t lane = 0; lane < hn::Lanes(DF()); ++lane) {
    const std::uint8_t* const from = static_cast<const std::uint8_t*>(codes) + bytes * base[lane];
    pairs[0][lane] = loaded<Pair>(from);
    pairs[1][lane] = loaded<Pair>(from + row);
    pairs[2][lane] = loaded<Pair>(from + plane);
    pairs[3][lane] = loaded<Pair>(from + plane + row);
  }
  const DI di;
  const DF df;
  const VI mask = set_int(is_wide ? 0xFFFF : 0xFF);
  const auto along_x = [&](const std::uint32_t* of) HWY_ATTR {
    const VI pair = hn::BitCast(di, hn::Load(DU(), of));
    const V low = hn::ConvertTo(df, hn::And(pair, mask));
    const V high = hn::ConvertTo(df, hn::And(hn::ShiftRight < is_wide ? 16 : 8 > (pair), mask));
    return lerp(low, high, at.part.x);
  };
  const V low = lerp(along_x(pairs[0]), along_x(pairs[1]), at.part.y);
  const V high = lerp(along_x(pairs[2]), along_x(pairs[3]), at.part.y);
  return lerp(low, high, at.part.z);
}

/// Interpolated gradients, in 1/127.
HWY_INLINE V3 between_gradients(const std::int8_t* gradients, const Place& at,
                                const std::array<std::int32_t, 3>& stride) {
  static_assert(std::endian::native == std::endian::little);
  const DF df;
  const DI di;
  HWY_ALIGN std::int32_t base[most_lanes];
  hn::Store(at.base, di, base);
  const std::ptrdiff_t further[4] = {0, 3 * std::ptrdiff_t{stride[1]}, 3 * std::ptrdiff_t{stride[2]},
                                     3 * (std::ptrdiff_t{stride[1]} + stride[2])};
  HWY_ALIGN std::uint64_t pairs[4][most_lanes]; // of neighbours along x: three bytes, three bytes
  for (std::size_t lane = 0; lane < hn::Lanes(df); ++lane)
    for (std::size_t row = 0; row < 4; ++row)
      pairs[row][lane] = loaded<std::uint64_t>(gradients + 3 * std::ptrdiff_t{base[lane]} + further[row]);
  V3 sum{hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  const V one = set(1);
  const auto add = [&](VI x, VI y, VI z, V weight) HWY_ATTR {
    sum.x = hn::MulAdd(weight, hn::ConvertTo(df, hn::ShiftRight<24>(x)), sum.x);
    sum.y = hn::MulAdd(weight, hn::ConvertTo(df, hn::ShiftRight<24>(y)), sum.y);
    sum.z = hn::MulAdd(weight, hn::ConvertTo(df, hn::ShiftRight<24>(z)), sum.z);
  };
  for (std::size_t row = 0; row < 4; ++row) {
    const V wy = (row & 1) != 0 ? at.part.y : hn::Sub(one, at.part.y);
    const V wz = (row & 2) != 0 ? at.part.z : hn::Sub(one, at.part.z);
    VI low, high;
    hn::LoadInterleaved2(di, reinterpret_cast<const std::int32_t*>(pairs[row]), low, high);
    // Shifts each byte to the upper end, to keep its sign.
    add(hn::ShiftLeft<24>(low), hn::ShiftLeft<16>(low), hn::ShiftLeft<8>(low),
        hn::Mul(hn::Mul(hn::Sub(one, at.part.x), wy), wz));
    add(low, hn::ShiftLeft<24>(high), hn::ShiftLeft<16>(high), hn::Mul(hn::Mul(at.part.x, wy), wz));
  }
  return sum;
}

HWY_INLINE V3 unpacked(VI bits) {
  const DF df;
  const V scale = set(1.0f / 255);
  const VI byte = set_int(255);
  return {hn::Mul(hn::ConvertTo(df, hn::And(bits, byte)), scale),
          hn::Mul(hn::ConvertTo(df, hn::And(hn::ShiftRight<8>(bits), byte)), scale),
          hn::Mul(hn::ConvertTo(df, hn::And(hn::ShiftRight<16>(bits), byte)), scale)};
}

/// @param own colours of the look
HWY_INLINE V3 painted(const CastTask& task, const V3& voxel, const V3& own) {
  const DI di;
  const V3 at{hn::Add(dot(task.paint_rows[0], voxel), set(task.paint_offset[0])),
              hn::Add(dot(task.paint_rows[1], voxel), set(task.paint_offset[1])),
              hn::Add(dot(task.paint_rows[2], voxel), set(task.paint_offset[2]))};
  if (task.paint_is_field) {
    const Place place = place_in(at, task.paint_size, task.paint_stride);
    const V number = between_codes<false>(task.paint_numbers, place, task.paint_stride);
    return unpacked(gather_bytes(task.palette, hn::ShiftLeft<2>(hn::NearestInt(number))));
  }
  const auto nearest = [&](V along, std::size_t axis) HWY_ATTR {
    const V limit = set(static_cast<float>(task.paint_size[axis] - 1));
    return hn::ConvertTo(di, hn::Floor(hn::Add(hn::Min(hn::Max(along, set(0)), limit), set(0.5f))));
  };
  const VI voxel_number =
      hn::Add(nearest(at.x, 0), hn::Add(hn::Mul(nearest(at.y, 1), set_int(task.paint_stride[1])),
                                        hn::Mul(nearest(at.z, 2), set_int(task.paint_stride[2]))));
  if (task.paint_pixels != nullptr)
    return unpacked(gather_bytes(task.paint_pixels, hn::ShiftLeft<2>(voxel_number)));
  const VI number = hn::And(gather_bytes(task.paint_numbers, voxel_number), set_int(255));
  const V3 colour = unpacked(gather_bytes(task.palette, hn::ShiftLeft<2>(number)));
  if (!task.paint_keeps_own)
    return colour;
  M is_own = hn::RebindMask(DF(), hn::Eq(number, set_int(Paint::own_colour)));
  const auto beyond = [&](V along, std::size_t axis) HWY_ATTR {
    const V limit = set(static_cast<float>(task.paint_size[axis]) - 0.5f);
    return hn::Or(hn::Lt(along, set(-0.5f)), hn::Gt(along, limit));
  };
  is_own = hn::Or(hn::Or(is_own, beyond(at.x, 0)), hn::Or(beyond(at.y, 1), beyond(at.z, 2)));
  return {hn::IfThenElse(is_own, own.x, colour.x), hn::IfThenElse(is_own, own.y, colour.y),
          hn::IfThenElse(is_own, own.z, colour.z)};
}

/// Lit colour of a surface with the given gradient, of any length.
/// @param steepness length of the stored gradient, 0 to 1; @param from_cut 0 on cuts, 1 away from them
HWY_INLINE V3 lit(const CastTask& task, const V3& colour, const V3& gradient, V steepness, V from_cut) {
  const DI di;
  const V squared = hn::Max(dot(gradient, gradient), set(1e-30f));
  const V inverse = hn::Div(set(1), hn::Sqrt(squared));
  const V towards_eye = hn::Mul(dot(task.eye, gradient), inverse);
  // Values may rise or fall into matter: uses the normal that faces the eye, and a blend of both edge-on.
  const V side = hn::Min(hn::Max(hn::Mul(towards_eye, set(8)), set(-1)), set(1));
  const V along = hn::Mul(dot(task.light, gradient), inverse);
  const V front = hn::MulAdd(side, set(0.5f), set(0.5f));
  const V to_light = hn::MulAdd(hn::Max(along, set(0)), front,
                                hn::Mul(hn::Max(hn::Neg(along), set(0)), hn::Sub(set(1), front)));
  const V mirrored =
      hn::Max(hn::MulSub(hn::Mul(set(2), to_light), hn::Abs(towards_eye), set(task.light_eye)), set(0));
  // Nearly flat regions have no direction: lit as if they faced the light, without gloss; the same on cuts.
  V weight = hn::Min(hn::Mul(steepness, set(4)), set(1));
  weight = hn::Mul(weight, from_cut);
  const V part =
      hn::MulAdd(set(task.diffuse), hn::MulAdd(weight, hn::Sub(to_light, set(1)), set(1)), set(task.ambient));
  const VI entry = hn::Min(hn::ConvertTo(di, hn::MulAdd(mirrored, set(gloss_size - 1), set(0.5f))),
                           set_int(gloss_size - 1));
  const V gloss = hn::Mul(gather(task.gloss, entry), weight);
  const V one = set(1);
  return {hn::Min(hn::MulAdd(colour.x, part, gloss), one), hn::Min(hn::MulAdd(colour.y, part, gloss), one),
          hn::Min(hn::MulAdd(colour.z, part, gloss), one)};
}

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#endif
