#include "bodies/surface.hpp"
#include "maille/base/vectors.hpp"

#include "data/parallel.hpp"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::render {

namespace {

constexpr std::uint32_t faces_ahead = 6; ///< number of faces whose corners are prefetched
constexpr std::size_t nodes_ahead = 16;  ///< scattered over a lattice
constexpr int n_chunks = 64;     ///< chunks of faces, independent of threads, so that the order is fixed
constexpr double snap = 65536;   ///< subdivisions of a pixel
constexpr double nearest = 1e-9; ///< distance from the eye [m]; nearer faces are treated ray by ray
constexpr double farthest_off = 1 << 14; ///< [pixels] off the picture; areas of triangles fit into 64 bits
constexpr std::int32_t far_off = std::numeric_limits<std::int32_t>::min();

/// The middle of a face, in cells of the lattice.
std::array<float, 3> entry_at(const SurfaceFace& face) {
  std::array<float, 3> entry{static_cast<float>(face.cell[0]) + 0.5f, static_cast<float>(face.cell[1]) + 0.5f,
                             static_cast<float>(face.cell[2]) + 0.5f};
  entry[face.axis] += face.upper != 0 ? 0.5f : -0.5f;
  return entry;
}

/// Nearest whole number for |x| < 2^31; std::llround would be a function call.
std::int32_t rounded(double x) {
  constexpr double shift = 1099511627776.0; // 2^40: makes truncation a floor
  return static_cast<std::int32_t>(static_cast<std::int64_t>(x + 0.5 + shift) -
                                   static_cast<std::int64_t>(shift));
}

} // namespace

/// Intersections of the rays of a tile with faces, by pixel, nearest first. Events of equal depth (bodies
/// that touch themselves) keep their order.
class SurfaceEvents::Events {
public:
  struct Event {
    float t;
    std::int32_t enters;        ///< 1 or -1
    std::array<float, 3> entry; ///< see entry_at
  };

  Events() { counts_.fill(0); }
  void add(std::size_t pixel, const Event& event) {
    const std::size_t n = counts_[pixel]++;
    if (n < room)
      return put(events_.data() + room * pixel, n, event);
    further_.emplace_back(static_cast<std::uint32_t>(pixel), event);
  }
  /// Events of a pixel; valid until the next call.
  std::span<const Event> of(std::size_t pixel) {
    const std::size_t n = counts_[pixel];
    const Event* const first = events_.data() + room * pixel;
    if (n <= room)
      return {first, n};
    many_.assign(first, first + room);
    many_.resize(n);
    std::size_t there = room;
    for (const auto& [of_pixel, event] : further_)
      if (of_pixel == pixel)
        put(many_.data(), there++, event);
    return many_;
  }

private:
  static void put(Event* events, std::size_t n, const Event& event) {
    for (; n > 0 && event.t < events[n - 1].t; --n)
      events[n] = events[n - 1];
    events[n] = event;
  }

  static constexpr std::size_t room = 4; ///< events per pixel; few rays meet more faces
  std::array<std::uint32_t, tile_pixels> counts_;
  std::array<Event, room * tile_pixels> events_;
  std::vector<std::pair<std::uint32_t, Event>> further_;
  std::vector<Event> many_;
};

/// Coefficients for the pixels in a triangle, and for their depths.
struct SurfaceEvents::Covering {
  bool enters;
  /// For each edge: twice the area with a pixel, and its change per pixel.
  std::array<std::int64_t, 3> in_row, beside, below;
  Vec3 normal;
  double offset, least_z, largest_z;
};

SurfaceEvents::SurfaceEvents(const Deformation& deformation, const Surface& surface, const Pose& pose,
                             const View& view, int threads)
    : deformation_(deformation), surface_(surface), width_(view.width), height_(view.height),
      tiles_x_((view.width + tile_edge - 1) / tile_edge), tiles_y_((view.height + tile_edge - 1) / tile_edge),
      parallel_(view.camera.parallel) {
  const Camera& camera = view.camera;
  const auto axes = camera.axes();
  for (std::size_t row = 0; row < 3; ++row)
    to_camera_[row] = transposed_times(pose.rotation, axes[row]);
  camera_offset_ = times(axes, minus(pose.position, camera.position));
  scale_ = 0.5 * height_ / camera.half_height();
  const auto in_chunks = [&](std::size_t n, auto&& act) {
    for_each_item(threads, n_chunks, [&](int chunk, int) {
      const std::size_t c = chunk;
      act(c, n * c / n_chunks, n * (c + 1) / n_chunks);
    });
  };
  corners_.resize(surface.nodes.size());
  in_chunks(corners_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    const auto node = [&](std::size_t i) -> const std::array<float, 4>& {
      return deformation_.nodes()[surface.nodes[i]];
    };
    for (std::size_t i = begin; i < end; ++i) {
      hwy::Prefetch(&node(std::min(i + nodes_ahead, end - 1)));
      corners_[i] = corner(node(i));
    }
  });
  // Assigns faces to tiles: counted per chunk, then sorted.
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found(n_chunks);
  in_chunks(surface.faces.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    auto& list = found[chunk];
    list.reserve(2 * (end - begin));
    std::array<int, 4> range{};
    for (std::size_t face = begin; face < end; ++face)
      if (tiles_of(surface.faces[face], range))
        for (int y = range[2]; y <= range[3]; ++y)
          for (int x = range[0]; x <= range[1]; ++x)
            list.emplace_back(static_cast<std::uint32_t>(x + tiles_x_ * y), static_cast<std::uint32_t>(face));
  });
  const auto n_tiles = static_cast<std::size_t>(tiles_x_) * tiles_y_;
  from_.assign(n_tiles + 1, 0);
  for (const auto& list : found)
    for (const auto& [tile, face] : list)
      ++from_[tile + 1];
  for (std::size_t tile = 0; tile < n_tiles; ++tile)
    from_[tile + 1] += from_[tile];
  in_tile_.resize(from_.back());
  std::vector<std::uint32_t> place(from_.begin(), from_.end() - 1);
  for (const auto& list : found)
    for (const auto& [tile, face] : list)
      in_tile_[place[tile]++] = face;
}

SurfaceEvents::Corner SurfaceEvents::corner(const std::array<float, 4>& x) const {
  const Vec3 at = plus(times(to_camera_, Vec3{x[0], x[1], x[2]}), camera_offset_);
  const auto [column, row] = in_picture(at);
  const bool can_snap =
      (parallel_ || at[2] >= nearest) && std::abs(column) < farthest_off && std::abs(row) < farthest_off;
  return {at[0], at[1], at[2], can_snap ? rounded(column * snap) : far_off,
          can_snap ? rounded(row * snap) : far_off};
}

std::array<double, 2> SurfaceEvents::in_picture(const Vec3& at) const {
  const double s = parallel_ ? scale_ : scale_ / at[2];
  return {0.5 * width_ - 0.5 + s * at[0], 0.5 * height_ - 0.5 - s * at[1]};
}

bool SurfaceEvents::tiles_of(const SurfaceFace& face, std::array<int, 4>& range) const {
  std::int32_t left = std::numeric_limits<std::int32_t>::max(), right = far_off, top = left, bottom = far_off;
  double farthest = -1e30;
  for (const std::uint32_t number : face.corners) {
    const Corner& corner = corners_[number];
    if (corner.column == far_off)
      return tiles_of_far_face(face, range);
    left = std::min(left, corner.column);
    right = std::max(right, corner.column);
    top = std::min(top, corner.row);
    bottom = std::max(bottom, corner.row);
    farthest = std::max(farthest, corner.z);
  }
  constexpr auto unit = static_cast<std::int32_t>(snap);
  if (farthest < 0 || right < 0 || bottom < 0 || left > unit * (width_ - 1) || top > unit * (height_ - 1))
    return false;
  const auto tile = [](std::int32_t at, int n) { return std::clamp(at / (unit * tile_edge), 0, n - 1); };
  range = {tile(left, tiles_x_), tile(right, tiles_x_), tile(top, tiles_y_), tile(bottom, tiles_y_)};
  return true;
}

bool SurfaceEvents::tiles_of_far_face(const SurfaceFace& face, std::array<int, 4>& range) const {
  double least_x = 1e30, largest_x = -1e30, least_y = 1e30, largest_y = -1e30, farthest = -1e30;
  bool is_near = false;
  for (const std::uint32_t number : face.corners) {
    const Corner& corner = corners_[number];
    farthest = std::max(farthest, corner.z);
    if (!parallel_ && corner.z < nearest) {
      is_near = true;
      continue;
    }
    const auto [x, y] = in_picture({corner.x, corner.y, corner.z});
    least_x = std::min(least_x, x);
    largest_x = std::max(largest_x, x);
    least_y = std::min(least_y, y);
    largest_y = std::max(largest_y, y);
  }
  if (farthest < 0 || std::isnan(largest_x))
    return false;
  if (is_near) { // may cover any tile
    range = {0, tiles_x_ - 1, 0, tiles_y_ - 1};
    return true;
  }
  if (largest_x < 0 || largest_y < 0 || least_x > width_ - 1 || least_y > height_ - 1)
    return false;
  const auto tile = [](double pixel, int n) {
    return static_cast<int>(std::clamp(pixel / tile_edge, 0.0, n - 1.0));
  };
  range = {tile(least_x, tiles_x_), tile(largest_x, tiles_x_), tile(least_y, tiles_y_),
           tile(largest_y, tiles_y_)};
  return true;
}

SurfaceEvents::TileRays SurfaceEvents::rays_of(int tile) const {
  TileRays rays;
  rays.x = tile % tiles_x_ * tile_edge;
  rays.y = tile / tiles_x_ * tile_edge;
  for (std::size_t i = 0; i < tile_edge; ++i) {
    rays.across[i] = (rays.x + static_cast<int>(i) - 0.5 * width_ + 0.5) / scale_;
    rays.up[i] = (0.5 * height_ - 0.5 - (rays.y + static_cast<int>(i))) / scale_;
  }
  for (std::size_t j = 0; j < tile_edge; ++j)
    for (std::size_t i = 0; i < tile_edge; ++i) {
      const double across = rays.across[i], up = rays.up[j];
      rays.length[i + tile_edge * j] = parallel_ ? 1 : std::sqrt(1 + across * across + up * up);
    }
  return rays;
}

void SurfaceEvents::add_face(const TileRays& tile, const SurfaceFace& face, Events& events) const {
  const Entry entry = entry_at(face);
  std::array<const Corner*, 4> corners{};
  std::ranges::transform(face.corners, corners.begin(),
                         [&](std::uint32_t number) { return &corners_[number]; });
  std::array<Triangle, 2> snapped{};
  std::size_t n_snapped = 0;
  for (const Triangle& triangle :
       {Triangle{corners[0], corners[1], corners[2]}, Triangle{corners[0], corners[2], corners[3]}}) {
    if (std::ranges::none_of(triangle, [](const Corner* corner) { return corner->column == far_off; }))
      snapped[n_snapped++] = triangle;
    else
      cast_at(tile, triangle, entry, events);
  }
  rasterise(tile, std::span(snapped).first(n_snapped), entry, events);
}

void SurfaceEvents::rasterise(const TileRays& tile, std::span<const Triangle> triangles, const Entry& entry,
                              Events& events) const {
  constexpr auto unit = static_cast<std::int64_t>(snap);
  std::int32_t left = std::numeric_limits<std::int32_t>::max(), right = far_off, top = left, bottom = far_off;
  for (const Triangle& triangle : triangles)
    for (const Corner* const corner : triangle) {
      left = std::min(left, corner->column);
      right = std::max(right, corner->column);
      top = std::min(top, corner->row);
      bottom = std::max(bottom, corner->row);
    }
  const auto ceiling = [](std::int64_t v) { return static_cast<int>((v + unit - 1) >> 16); };
  const int x0 = std::max(ceiling(left), tile.x),
            x1 = std::min({right >> 16, tile.x + tile_edge - 1, width_ - 1});
  const int y0 = std::max(ceiling(top), tile.y),
            y1 = std::min({bottom >> 16, tile.y + tile_edge - 1, height_ - 1});
  if (x0 > x1 || y0 > y1)
    return;
  std::array<Covering, 2> coverings; // n are used; clearing them would take a tenth of the time
  std::size_t n = 0;
  for (const auto& [one, two, three] : triangles) {
    std::array<std::int64_t, 3> x{one->column, two->column, three->column}, y{one->row, two->row, three->row};
    // Rows run downwards: a counterclockwise triangle that faces the eye has a negative area.
    const std::int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (area == 0)
      continue;
    Covering& of = coverings[n++];
    of.enters = area < 0;
    if (of.enters) {
      std::swap(x[1], x[2]);
      std::swap(y[1], y[2]);
    }
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t to = (e + 1) % 3;
      const std::int64_t dx = x[to] - x[e], dy = y[to] - y[e];
      // A pixel on an edge belongs to the triangle with that left or upper edge.
      const std::int64_t bias = dy < 0 || (dy == 0 && dx > 0) ? 0 : -1;
      of.in_row[e] = dx * (y0 * unit - y[e]) - dy * (x0 * unit - x[e]) + bias;
      of.beside[e] = -dy * unit;
      of.below[e] = dx * unit;
    }
    const Vec3 a{one->x, one->y, one->z}, b{two->x, two->y, two->z}, c{three->x, three->y, three->z};
    of.normal = cross(minus(b, a), minus(c, a));
    of.offset = dot(of.normal, a);
    std::tie(of.least_z, of.largest_z) = std::minmax({one->z, two->z, three->z});
  }
  for (int py = y0; py <= y1; ++py)
    for (std::size_t t = 0; t < n; ++t) {
      Covering& of = coverings[t];
      auto [a_side, b_side, c_side] = of.in_row;
      for (int px = x0; px <= x1; ++px) {
        if ((a_side | b_side | c_side) >= 0) {
          const auto i = static_cast<std::size_t>(px - tile.x), j = static_cast<std::size_t>(py - tile.y);
          const double across = tile.across[i], up = tile.up[j];
          // Depth at the plane; for a triangle seen edge-on clamped to its own depths.
          const double z = parallel_ ? (of.offset - of.normal[0] * across - of.normal[1] * up) / of.normal[2]
                                     : of.offset / (of.normal[0] * across + of.normal[1] * up + of.normal[2]);
          const double depth = z >= of.least_z && z <= of.largest_z ? z
                               : std::isnan(z)                      ? of.least_z
                                                                    : std::clamp(z, of.least_z, of.largest_z);
          const std::size_t pixel = i + tile_edge * j;
          events.add(pixel, {static_cast<float>(depth * tile.length[pixel]), of.enters ? 1 : -1, entry});
        }
        a_side += of.beside[0];
        b_side += of.beside[1];
        c_side += of.beside[2];
      }
      for (std::size_t e = 0; e < 3; ++e)
        of.in_row[e] += of.below[e];
    }
}

/// Near the eye or far off the picture: tests ray by ray, by signs of volumes.
void SurfaceEvents::cast_at(const TileRays& tile, const Triangle& triangle, const Entry& entry,
                            Events& events) const {
  const auto& [one, two, three] = triangle;
  const Vec3 a{one->x, one->y, one->z}, b{two->x, two->y, two->z}, c{three->x, three->y, three->z};
  const Vec3 normal = cross(minus(b, a), minus(c, a));
  const double offset = dot(normal, a);
  const int y1 = std::min(tile.y + tile_edge, height_), x1 = std::min(tile.x + tile_edge, width_);
  for (int py = tile.y; py < y1; ++py)
    for (int px = tile.x; px < x1; ++px) {
      const auto i = static_cast<std::size_t>(px - tile.x), j = static_cast<std::size_t>(py - tile.y);
      const double across = tile.across[i], up = tile.up[j];
      const Vec3 from = parallel_ ? Vec3{across, up, 0} : Vec3{0, 0, 0};
      const Vec3 along = parallel_ ? Vec3{0, 0, 1} : Vec3{across, up, 1};
      const Vec3 p = minus(a, from), q = minus(b, from), r = minus(c, from);
      const double u = dot(along, cross(p, q)), v = dot(along, cross(q, r)), w = dot(along, cross(r, p));
      if (!((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)))
        continue;
      const double z = parallel_ ? (offset - normal[0] * across - normal[1] * up) / normal[2]
                                 : offset / dot(normal, along);
      const std::size_t pixel = i + tile_edge * j;
      if (z > 0) // (right, up, ahead) is left-handed
        events.add(pixel,
                   {static_cast<float>(z * tile.length[pixel]), dot(normal, along) > 0 ? 1 : -1, entry});
    }
}

void SurfaceEvents::stretches(int tile, TileStretches& out) const {
  Events events;
  const TileRays rays = rays_of(tile);
  const std::uint32_t first = from_[tile], last = from_[static_cast<std::size_t>(tile) + 1];
  for (std::uint32_t i = first; i < last; ++i) {
    const auto& ahead = surface_.faces[in_tile_[std::min(i + faces_ahead, last - 1)]].corners;
    hwy::Prefetch(&corners_[ahead[0]]);
    hwy::Prefetch(&corners_[ahead[2]]);
    add_face(rays, surface_.faces[in_tile_[i]], events);
  }
  out.first.assign(tile_pixels + 1, 0);
  out.stretches.clear();
  for (std::size_t pixel = 0; pixel < tile_pixels; ++pixel) {
    out.first[pixel] = static_cast<std::uint32_t>(out.stretches.size());
    const auto of_pixel = events.of(pixel);
    int inside = 0;
    for (const auto& event : of_pixel)
      inside -= event.enters; // non-zero if the eye is inside
    if (inside != 0)
      out.stretches.push_back({0, 0, of_pixel.front().entry});
    for (const auto& event : of_pixel) {
      const int before = inside;
      inside += event.enters;
      const float t = std::max(event.t, 0.0f);
      if (before == 0)
        out.stretches.push_back({t, t, event.entry});
      else if (inside == 0)
        out.stretches.back().end = t;
    }
  }
  out.first[tile_pixels] = static_cast<std::uint32_t>(out.stretches.size());
}

} // namespace maille::render
