#include "bodies/surface.hpp"

#include "data/parallel.hpp"
#include "data/vectors.hpp"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace maille::render {

namespace {

constexpr std::uint32_t faces_ahead = 6;  ///< whose corners are asked for while one is at work
constexpr std::size_t faces_at_once = 16; ///< whose nodes are asked for before the first is at work
constexpr int n_chunks = 64;              ///< of faces, whatever the threads: their order is the same
constexpr double snap = 65536;            ///< parts of a pixel
constexpr double nearest = 1e-9;          ///< ahead of the eye [m]; what is nearer is treated ray by ray
constexpr double farthest_off = 1 << 14;  ///< pixels off the picture whose triangles' areas 64 bits hold
constexpr std::int32_t far_off = std::numeric_limits<std::int32_t>::min();

/// Corners (bits: upper along x, y, z) of a face, counterclockwise as seen from outside the cell.
std::array<int, 4> corners_of_face(int axis, bool upper) {
  const int b = 1 << ((axis + 1) % 3), c = 1 << ((axis + 2) % 3), a = upper ? 1 << axis : 0;
  return upper ? std::array{a, a | b, a | b | c, a | c} : std::array{a, a | c, a | b | c, a | b};
}

/// The middle of a face, in cells of the lattice.
std::array<float, 3> entry_at(const SurfaceFace& face, const Index3& n) {
  std::array<float, 3> entry{static_cast<float>(face.cell % n[0]) + 0.5f,
                             static_cast<float>(face.cell / n[0] % n[1]) + 0.5f,
                             static_cast<float>(face.cell / (n[0] * n[1])) + 0.5f};
  entry[face.axis] += face.upper != 0 ? 0.5f : -0.5f;
  return entry;
}

/// The nearest whole number, of numbers below 2^31 in size; std::llround is a call.
std::int32_t rounded(double x) {
  constexpr double shift = 1099511627776.0; // 2^40: what is cut off is then always below
  return static_cast<std::int32_t>(static_cast<std::int64_t>(x + 0.5 + shift) -
                                   static_cast<std::int64_t>(shift));
}

} // namespace

struct SurfaceEvents::Event {
  std::int32_t pixel;
  float t;
  std::int32_t enters; ///< 1 or -1
  std::uint32_t face;
};

SurfaceEvents::SurfaceEvents(const Deformation& deformation, const std::vector<SurfaceFace>& faces,
                             const Pose& pose, const View& view, int threads)
    : deformation_(deformation), faces_(faces), width_(view.width), height_(view.height),
      tiles_x_((view.width + tile_edge - 1) / tile_edge), tiles_y_((view.height + tile_edge - 1) / tile_edge),
      parallel_(view.camera.parallel) {
  const Camera& camera = view.camera;
  const auto axes = camera.axes();
  for (std::size_t row = 0; row < 3; ++row)
    to_camera_[row] = transposed_times(pose.rotation, axes[row]);
  camera_offset_ = times(axes, minus(pose.position, camera.position));
  const double half = 0.5 * height_;
  scale_ = parallel_ ? half / camera.parallel_scale
                     : half / std::tan(0.5 * camera.view_angle * std::numbers::pi / 180);
  // Which faces are in which tile: counted chunk by chunk, then put in order.
  const auto n_faces = faces.size();
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found(n_chunks);
  corners_.resize(n_faces);
  for_each_item(threads, n_chunks, [&](int chunk, int) {
    auto& list = found[static_cast<std::size_t>(chunk)];
    const std::size_t begin = n_faces * static_cast<std::size_t>(chunk) / n_chunks,
                      end = n_faces * (static_cast<std::size_t>(chunk) + 1) / n_chunks;
    std::array<std::array<std::size_t, 4>, faces_at_once> nodes{};
    for (std::size_t first = begin; first < end; first += faces_at_once) {
      const std::size_t n = std::min<std::size_t>(faces_at_once, end - first);
      for (std::size_t f = 0; f < n; ++f) {
        nodes[f] = nodes_of(faces_[first + f]);
        for (const std::size_t node : nodes[f])
          hwy::Prefetch(&deformation_.nodes()[node]); // scattered over a lattice
      }
      for (std::size_t f = 0; f < n; ++f) {
        auto& corners = corners_[first + f];
        std::ranges::transform(nodes[f], corners.begin(), [&](std::size_t node) { return corner(node); });
        std::array<int, 4> range{};
        if (!tiles_of(corners, range))
          continue;
        for (int y = range[2]; y <= range[3]; ++y)
          for (int x = range[0]; x <= range[1]; ++x)
            list.emplace_back(static_cast<std::uint32_t>(x + tiles_x_ * y),
                              static_cast<std::uint32_t>(first + f));
      }
    }
  });
  const auto n_tiles = static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_);
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

std::array<std::size_t, 4> SurfaceEvents::nodes_of(const SurfaceFace& face) const {
  const Index3 n = deformation_.lattice().cells;
  const std::int32_t row = face.cell / n[0], i = face.cell - row * n[0], k = row / n[1], j = row - k * n[1];
  std::array<std::size_t, 4> nodes{};
  std::ranges::transform(corners_of_face(face.axis, face.upper != 0), nodes.begin(), [&](int corner) {
    return static_cast<std::size_t>(
        i + (corner & 1) +
        (n[0] + 1) * (j + ((corner >> 1) & 1) + (n[1] + std::int64_t{1}) * (k + (corner >> 2))));
  });
  return nodes;
}

SurfaceEvents::Corner SurfaceEvents::corner(std::size_t node) const {
  const auto& x = deformation_.nodes()[node];
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

bool SurfaceEvents::tiles_of(const std::array<Corner, 4>& corners, std::array<int, 4>& range) const {
  double least_x = 1e30, largest_x = -1e30, least_y = 1e30, largest_y = -1e30, farthest = -1e30;
  bool is_near = false;
  for (const Corner& corner : corners) {
    farthest = std::max(farthest, corner.z);
    if (!parallel_ && corner.z < nearest) {
      is_near = true;
      continue;
    }
    const auto [x, y] = corner.column == far_off ? in_picture({corner.x, corner.y, corner.z})
                                                 : std::array{corner.column / snap, corner.row / snap};
    least_x = std::min(least_x, x);
    largest_x = std::max(largest_x, x);
    least_y = std::min(least_y, y);
    largest_y = std::max(largest_y, y);
  }
  if (farthest < 0 || std::isnan(largest_x))
    return false;
  if (is_near) { // it may be anywhere
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

void SurfaceEvents::add_triangle(const TileRays& tile, const std::array<Corner, 3>& corners,
                                 std::uint32_t face, std::vector<Event>& events) const {
  std::array<std::int64_t, 3> x{}, y{};
  bool can_snap = true;
  for (std::size_t c = 0; c < 3; ++c) {
    can_snap = can_snap && corners[c].column != far_off;
    x[c] = corners[c].column;
    y[c] = corners[c].row;
  }
  const Vec3 a{corners[0].x, corners[0].y, corners[0].z}, b{corners[1].x, corners[1].y, corners[1].z},
      c{corners[2].x, corners[2].y, corners[2].z};
  const Vec3 normal = cross(minus(b, a), minus(c, a));
  const double offset = dot(normal, a);
  const auto [least_z, largest_z] = std::minmax({corners[0].z, corners[1].z, corners[2].z});
  /// Depth along the ray of a pixel where it meets the plane of the triangle.
  const auto add = [&](int px, int py, bool enters, bool is_exact) {
    const auto i = static_cast<std::size_t>(px - tile.x), j = static_cast<std::size_t>(py - tile.y);
    const double across = tile.across[i], up = tile.up[j];
    double z = parallel_ ? (offset - normal[0] * across - normal[1] * up) / normal[2]
                         : offset / (normal[0] * across + normal[1] * up + normal[2]);
    if (!is_exact) // a triangle on edge
      z = z >= least_z && z <= largest_z ? z : std::clamp(std::isnan(z) ? least_z : z, least_z, largest_z);
    const std::size_t pixel = i + tile_edge * j;
    events.push_back({static_cast<std::int32_t>(pixel), static_cast<float>(z * tile.length[pixel]),
                      enters ? 1 : -1, face});
  };
  if (can_snap) {
    // Rows run downwards: what is counterclockwise from outside has a negative area when it faces the eye.
    std::int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (area == 0)
      return;
    const bool enters = area < 0;
    if (enters) {
      std::swap(x[1], x[2]);
      std::swap(y[1], y[2]);
    }
    const auto [left, right] = std::minmax({x[0], x[1], x[2]});
    const auto [top, bottom] = std::minmax({y[0], y[1], y[2]});
    constexpr auto unit = static_cast<std::int64_t>(snap);
    const auto ceiling = [](std::int64_t v) { return static_cast<int>((v + unit - 1) >> 16); };
    const auto floor = [](std::int64_t v) { return static_cast<int>(v >> 16); };
    const int x0 = std::max(ceiling(left), tile.x),
              x1 = std::min({floor(right), tile.x + tile_edge - 1, width_ - 1});
    const int y0 = std::max(ceiling(top), tile.y),
              y1 = std::min({floor(bottom), tile.y + tile_edge - 1, height_ - 1});
    // Of each edge: twice the area with a pixel, and how it changes from pixel to pixel.
    std::array<std::int64_t, 3> in_row{}, beside{}, below{};
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t to = (e + 1) % 3;
      const std::int64_t dx = x[to] - x[e], dy = y[to] - y[e];
      // Pixels on an edge belong to the triangle whose left or upper edge it is.
      const std::int64_t bias = dy < 0 || (dy == 0 && dx > 0) ? 0 : -1;
      in_row[e] = dx * (y0 * unit - y[e]) - dy * (x0 * unit - x[e]) + bias;
      beside[e] = -dy * unit;
      below[e] = dx * unit;
    }
    for (int py = y0; py <= y1; ++py) {
      auto [a_side, b_side, c_side] = in_row;
      for (int px = x0; px <= x1; ++px) {
        if ((a_side | b_side | c_side) >= 0)
          add(px, py, enters, false);
        a_side += beside[0];
        b_side += beside[1];
        c_side += beside[2];
      }
      for (std::size_t e = 0; e < 3; ++e)
        in_row[e] += below[e];
    }
    return;
  }
  // Near the eye or far off the picture: ray by ray, by the signs of volumes.
  const int y1 = std::min(tile.y + tile_edge, height_), x1 = std::min(tile.x + tile_edge, width_);
  for (int py = tile.y; py < y1; ++py)
    for (int px = tile.x; px < x1; ++px) {
      const double across = tile.across[static_cast<std::size_t>(px - tile.x)],
                   up = tile.up[static_cast<std::size_t>(py - tile.y)];
      const Vec3 from = parallel_ ? Vec3{across, up, 0} : Vec3{0, 0, 0};
      const Vec3 along = parallel_ ? Vec3{0, 0, 1} : Vec3{across, up, 1};
      const Vec3 p = minus(a, from), q = minus(b, from), r = minus(c, from);
      const double u = dot(along, cross(p, q)), v = dot(along, cross(q, r)), w = dot(along, cross(r, p));
      if (!((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)))
        continue;
      const double z = parallel_ ? (offset - normal[0] * across - normal[1] * up) / normal[2]
                                 : offset / dot(normal, along);
      if (z > 0)
        add(px, py, dot(normal, along) > 0, true); // right, up, ahead: a left-handed frame
    }
}

/// Pixel by pixel, nearest first. Events of one depth (bodies that touch themselves) stay in the order of
/// faces.
void SurfaceEvents::put_in_order(std::vector<Event>& events) {
  std::array<std::uint32_t, tile_pixels + 1> from{};
  for (const Event& event : events)
    ++from[static_cast<std::size_t>(event.pixel) + 1];
  for (std::size_t p = 0; p < tile_pixels; ++p)
    from[p + 1] += from[p];
  std::array<std::uint32_t, tile_pixels> count{};
  std::vector<Event> ordered(events.size());
  for (const Event& event : events) {
    const auto p = static_cast<std::size_t>(event.pixel);
    // Few events a pixel: each goes to its place among those that are there.
    std::uint32_t place = from[p] + count[p]++;
    for (; place > from[p] && event.t < ordered[place - 1].t; --place)
      ordered[place] = ordered[place - 1];
    ordered[place] = event;
  }
  events.swap(ordered);
}

void SurfaceEvents::stretches(int tile, TileStretches& out) const {
  std::vector<Event> events;
  const TileRays rays = rays_of(tile);
  const std::uint32_t first = from_[static_cast<std::size_t>(tile)],
                      last = from_[static_cast<std::size_t>(tile) + 1];
  for (std::uint32_t i = first; i < last; ++i) {
    const std::uint32_t face = in_tile_[i];
    const auto& four = corners_[face];
    hwy::Prefetch(&corners_[in_tile_[std::min(i + faces_ahead, last - 1)]]);
    add_triangle(rays, {four[0], four[1], four[2]}, face, events);
    add_triangle(rays, {four[0], four[2], four[3]}, face, events);
  }
  put_in_order(events);
  out.first.assign(tile_pixels + 1, 0);
  out.stretches.clear();
  const Lattice& lattice = deformation_.lattice();
  std::size_t e = 0;
  for (int pixel = 0; pixel < tile_pixels; ++pixel) {
    out.first[static_cast<std::size_t>(pixel)] = static_cast<std::uint32_t>(out.stretches.size());
    int inside = 0;
    for (std::size_t later = e; later < events.size() && events[later].pixel == pixel; ++later)
      inside -= events[later].enters; // other than 0 where the eye is inside
    if (inside != 0)
      out.stretches.push_back({0, 0, entry_at(faces_[events[e].face], lattice.cells)});
    for (; e < events.size() && events[e].pixel == pixel; ++e) {
      const int before = inside;
      inside += events[e].enters;
      const float t = std::max(events[e].t, 0.0f);
      if (before == 0)
        out.stretches.push_back({t, t, entry_at(faces_[events[e].face], lattice.cells)});
      else if (inside == 0)
        out.stretches.back().end = t;
    }
  }
  out.first[tile_pixels] = static_cast<std::uint32_t>(out.stretches.size());
}

} // namespace maille::render
