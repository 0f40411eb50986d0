#include "feasible/wavefront/wavefront_kernel.hpp"

#include <algorithm>

// Vectors of unknown length cannot be kept in arrays.
#ifndef HWY_DISABLED_TARGETS // cmake/compile_options.cmake, on x86
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "feasible/wavefront/wavefront_kernel.cpp" // NOLINT
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "feasible/wavefront/link_bounds-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace maille::deform::HWY_NAMESPACE {
namespace {

/// Eight lines at once (one per lane): forth, then back. `at` and `stride` address the bounds of the links.
template<Way way, int length, class Bounds>
HWY_INLINE void settle_lines(Vector (&row)[length], const Bounds& bounds, int at, int stride) {
  for (int i = 0; i + 1 < length; ++i)
    row[i + 1] = better<way>(row[i + 1], bounds.forth(row[i], at + stride * i));
  for (int i = length - 2; i >= 0; --i)
    row[i] = better<way>(row[i], bounds.back(row[i + 1], at + stride * i));
}

/// Stores `row` and collects in `change` where it differs from what was there.
HWY_INLINE void store(Vector row, std::int32_t* at, Vector& change) {
  change = hn::Or(change, hn::Xor(row, hn::Load(Tag(), at)));
  hn::Store(row, Tag(), at);
}
HWY_INLINE bool any(Vector change) {
  return !hn::AllTrue(Tag(), hn::Eq(change, hn::Zero(Tag())));
}

/// Lines along y or z: `stride` from node to node of a line, `across` from one group of lines to the next.
template<Way way, int length = tile_edge, class Bounds>
bool settle_along(std::int32_t* values, const Bounds& bounds, int stride, int across, int groups) {
  Vector change = hn::Zero(Tag());
  for (int group = 0; group < groups; ++group)
    for (int x = 0; x < tile_edge; x += lanes) {
      const int at = across * group + x;
      Vector row[length];
      for (int i = 0; i < length; ++i)
        row[i] = hn::Load(Tag(), values + at + stride * i);
      settle_lines<way, length>(row, bounds, at, stride);
      for (int i = 0; i < length; ++i)
        store(row[i], values + at + stride * i, change);
    }
  return any(change);
}

/// A square of `lanes` x `lanes` numbers, rows to columns.
HWY_INLINE void transpose([[maybe_unused]] Vector* r) {
#if HWY_TARGET != HWY_SCALAR
  const Tag d;
  const hn::RepartitionToWide<Tag> w;
  Vector half[lanes], quarter[lanes];
  for (int i = 0; i < lanes; i += 2) {
    half[i] = hn::InterleaveLower(d, r[i], r[i + 1]);
    half[i + 1] = hn::InterleaveUpper(d, r[i], r[i + 1]);
  }
  for (int i = 0; i < lanes; i += 4)
    for (int k = 0; k < 2; ++k) {
      const auto a = hn::BitCast(w, half[i + k]), b = hn::BitCast(w, half[i + k + 2]);
      quarter[i + 2 * k] = hn::BitCast(d, hn::InterleaveLower(w, a, b));
      quarter[i + 2 * k + 1] = hn::BitCast(d, hn::InterleaveUpper(w, a, b));
    }
#if HWY_MAX_BYTES >= 32
  for (int i = 0; i < 4; ++i) {
    r[i] = hn::ConcatLowerLower(d, quarter[4 + i], quarter[i]);
    r[4 + i] = hn::ConcatUpperUpper(d, quarter[4 + i], quarter[i]);
  }
#else
  for (int i = 0; i < lanes; ++i)
    r[i] = quarter[i];
#endif
#endif
}

/// Lines along x: turned, so that the lanes are lines, settled, and turned back.
template<Way way, class Bounds>
bool settle_along_x(std::int32_t* values, const Bounds& bounds, int layers) {
  Vector change = hn::Zero(Tag());
  for (int z = 0; z < layers; ++z)
    for (int y = 0; y < tile_edge; y += lanes) {
      std::int32_t* const corner = values + tile_layer * z + tile_edge * y;
      Vector row[tile_edge];
      for (int x = 0; x < tile_edge; x += lanes) {
        for (int i = 0; i < lanes; ++i)
          row[x + i] = hn::Load(Tag(), corner + tile_edge * i + x);
        transpose(row + x);
      }
      settle_lines<way, tile_edge>(row, bounds, tile_layer * z + y, tile_edge);
      for (int x = 0; x < tile_edge; x += lanes) {
        transpose(row + x);
        for (int i = 0; i < lanes; ++i)
          store(row[x + i], corner + tile_edge * i + x, change);
      }
    }
  return any(change);
}

/// Lines along z: as long as the tile has layers.
template<Way way, class Bounds>
bool settle_along_z(std::int32_t* values, const Bounds& bounds, int layers) {
  return layers == 2   ? settle_along<way, 2>(values, bounds, tile_layer, tile_edge, tile_edge)
         : layers == 4 ? settle_along<way, 4>(values, bounds, tile_layer, tile_edge, tile_edge)
                       : settle_along<way>(values, bounds, tile_layer, tile_edge, tile_edge);
}

template<Way way, class Differ>
void settle_tile(const Visit& visit, Differ differ) {
  const bool is_flat = visit.layers == 1;
  const auto x = bounds_of<way>(visit, 0, differ);
  const auto y = bounds_of<way>(visit, 1, differ);
  const auto z = bounds_of<way>(visit, 2, differ);
  const int axes = is_flat ? 2 : 3;
  for (int axis = 0, quiet = 0; quiet < axes; axis = axis + 1 == axes ? 0 : axis + 1) {
    const bool has_changed = axis == 0 ? settle_along_x<way>(visit.values, x, visit.layers)
                             : axis == 1
                                 ? settle_along<way>(visit.values, y, tile_edge, tile_layer, visit.layers)
                                 : settle_along_z<way>(visit.values, z, visit.layers);
    // Where all links are alike, one pass of every axis is the fixpoint (docs/theory.md, Theorem 4).
    quiet = has_changed && Differ::value ? 1 : quiet + 1;
  }
}

/// Violation of `asked` by `value`.
template<Way way>
HWY_INLINE Vector beyond(Vector asked, Vector value) {
  return way == Way::raise ? hn::Sub(asked, value) : hn::Sub(value, asked);
}

/// Passes one row of a face to the neighbour, along y or z.
template<Way way>
HWY_INLINE void hand_on(Vector asked, std::int32_t* to, Vector& largest) {
  const Vector value = hn::Load(Tag(), to);
  largest = hn::Max(largest, beyond<way>(asked, value));
  hn::Store(better<way>(asked, value), Tag(), to);
}

/// The two faces along y or z. `groups` rows a face, `across` apart; `last` is from the first layer to the
/// last, and `face_across` from row to row of the lower neighbour's bounds.
template<Way way, class Differ>
void hand_on_rows(Visit& visit, Differ differ, int axis, int groups, int across, int last, int face_across) {
  const auto upper = static_cast<std::size_t>(2 * axis + 1), lower = upper - 1;
  if (std::int32_t* const to = visit.neighbours[upper]) {
    const auto bounds = bounds_of<way>(visit, axis, differ);
    Vector largest = hn::Zero(Tag());
    for (int group = 0; group < groups; ++group)
      for (int x = 0; x < tile_edge; x += lanes) {
        const int at = across * group + x;
        hand_on<way>(bounds.forth(hn::Load(Tag(), visit.values + last + at), last + at), to + at, largest);
      }
    visit.violations[upper] = hn::GetLane(hn::MaxOfLanes(Tag(), largest));
  }
  if (std::int32_t* const to = visit.neighbours[lower]) {
    const auto bounds = face_bounds_of<way>(visit, axis, differ);
    Vector largest = hn::Zero(Tag());
    for (int group = 0; group < groups; ++group)
      for (int x = 0; x < tile_edge; x += lanes) {
        const int at = across * group + x;
        hand_on<way>(bounds.back(hn::Load(Tag(), visit.values + at), face_across * group + x), to + last + at,
                     largest);
      }
    visit.violations[lower] = hn::GetLane(hn::MaxOfLanes(Tag(), largest));
  }
}

/// The two faces along x, whose values do not lie side by side.
template<Way way, class Differ>
void hand_on_columns(Visit& visit, Differ differ) {
  constexpr int last = tile_edge - 1;
  const int rows = visit.layers * tile_edge;
  const auto change = [](std::int32_t asked, std::int32_t& value) HWY_ATTR {
    const std::int32_t by = way == Way::raise ? asked - value : value - asked;
    value = better<way>(asked, value);
    return by;
  };
  if (std::int32_t* const to = visit.neighbours[1]) {
    const auto bounds = bounds_of<way>(visit, 0, differ);
    std::int32_t largest = 0;
    for (int row = 0; row < rows; ++row) {
      const int z = row / tile_edge, y = row % tile_edge;
      const std::int32_t asked =
          bounds.forth(visit.values[tile_edge * row + last], tile_layer * z + tile_edge * last + y);
      largest = std::max(largest, change(asked, to[tile_edge * row]));
    }
    visit.violations[1] = largest;
  }
  if (std::int32_t* const to = visit.neighbours[0]) {
    const auto bounds = face_bounds_of<way>(visit, 0, differ);
    std::int32_t largest = 0;
    for (int row = 0; row < rows; ++row)
      largest = std::max(largest,
                         change(bounds.back(visit.values[tile_edge * row], row), to[tile_edge * row + last]));
    visit.violations[0] = largest;
  }
}

template<Way way, class Differ>
void visit_as(Visit& visit, Differ differ) {
  settle_tile<way>(visit, differ);
  visit.violations.fill(0);
  hand_on_columns<way>(visit, differ);
  constexpr int last = tile_edge - 1;
  hand_on_rows<way>(visit, differ, 1, visit.layers, tile_layer, tile_edge * last, tile_edge);
  if (visit.layers == tile_edge)
    hand_on_rows<way>(visit, differ, 2, tile_edge, tile_edge, tile_layer * last, tile_edge);
}

void visit_tile(Visit& visit) {
  const bool up = visit.way == Way::raise;
  if (visit.bounds)
    up ? visit_as<Way::raise>(visit, std::true_type{}) : visit_as<Way::lower>(visit, std::true_type{});
  else
    up ? visit_as<Way::raise>(visit, std::false_type{}) : visit_as<Way::lower>(visit, std::false_type{});
}

} // namespace
} // namespace maille::deform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

namespace {
HWY_EXPORT(visit_tile);
}

VisitTile best_visit_tile() {
  // Dispatches once; the pointer is kept by the caller.
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return HWY_DYNAMIC_DISPATCH(visit_tile);
}

} // namespace maille::deform
#endif
