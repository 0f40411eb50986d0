/// Bounds that links impose on their nodes, for a vector of links or a single one. Included once per vector
/// instruction set, by wavefront_kernel.cpp.
#if defined(MAILLE_LINK_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_LINK_BOUNDS_INL
#undef MAILLE_LINK_BOUNDS_INL
#else
#define MAILLE_LINK_BOUNDS_INL
#endif

#include "feasible/wavefront/wavefront_kernel.hpp"

#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace maille::deform::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<std::int32_t, tile_edge>;
using Vector = hn::Vec<Tag>;
constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
static_assert(tile_edge % lanes == 0, "rows of a tile are whole vectors");

template<Way way>
HWY_INLINE Vector better(Vector a, Vector b) {
  return way == Way::raise ? hn::Max(a, b) : hn::Min(a, b);
}
template<Way way>
HWY_INLINE std::int32_t better(std::int32_t a, std::int32_t b) {
  return way == Way::raise ? std::max(a, b) : std::min(a, b);
}

/// Links of one axis whose bounds differ, and links of one axis that are all alike.
template<Way way>
struct LinksInMemory {
  const std::int32_t* low;
  const std::int32_t* high;
  /// Bound of the next node from the value of a node. @param at of the bounds of the link
  HWY_INLINE Vector forth(Vector value, int at) const {
    return hn::Add(value, hn::Load(Tag(), (way == Way::raise ? low : high) + at));
  }
  HWY_INLINE Vector back(Vector value, int at) const {
    return hn::Sub(value, hn::Load(Tag(), (way == Way::raise ? high : low) + at));
  }
  HWY_INLINE std::int32_t forth(std::int32_t value, int at) const {
    return value + (way == Way::raise ? low : high)[at];
  }
  HWY_INLINE std::int32_t back(std::int32_t value, int at) const {
    return value - (way == Way::raise ? high : low)[at];
  }
};
template<Way way>
struct EvenLinks {
  std::int32_t low, high;
  HWY_INLINE Vector forth(Vector value, int) const {
    return hn::Add(value, hn::Set(Tag(), way == Way::raise ? low : high));
  }
  HWY_INLINE Vector back(Vector value, int) const {
    return hn::Sub(value, hn::Set(Tag(), way == Way::raise ? high : low));
  }
  HWY_INLINE std::int32_t forth(std::int32_t value, int) const {
    return value + (way == Way::raise ? low : high);
  }
  HWY_INLINE std::int32_t back(std::int32_t value, int) const {
    return value - (way == Way::raise ? high : low);
  }
};

template<Way way>
LinksInMemory<way> bounds_of(const Visit& visit, int axis, std::true_type) {
  const BlockLayout layout{visit.layers * tile_layer};
  return {visit.bounds + layout.low(axis), visit.bounds + layout.high(axis)};
}
template<Way way>
EvenLinks<way> bounds_of(const Visit& visit, int axis, std::false_type) {
  const auto a = static_cast<std::size_t>(axis);
  return {visit.even.low[a], visit.even.high[a]};
}
template<Way way>
LinksInMemory<way> face_bounds_of(const Visit& visit, int axis, std::true_type) {
  const BlockLayout layout{visit.layers * tile_layer};
  return {visit.bounds + layout.face_low(axis), visit.bounds + layout.face_high(axis)};
}
template<Way way>
EvenLinks<way> face_bounds_of(const Visit& visit, int axis, std::false_type even) {
  return bounds_of<way>(visit, axis, even);
}

} // namespace
} // namespace maille::deform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
