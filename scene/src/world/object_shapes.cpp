#include "world/object_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::reader {

namespace {

using std::numbers::pi;

/// Cells whose middle `is_inside` says yes to. @param is_inside of x and y from the box's axis along z, and
/// of z from its floor [m]
template<class IsInside>
std::vector<std::uint8_t> cells_inside(const Grid& box, IsInside&& is_inside) {
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(box.n_cells()), no_material);
  for (std::int64_t cell = 0; cell < box.n_cells(); ++cell) {
    const Index3 at = box.cell_at(cell);
    const Vec3& h = box.spacing();
    const double x = (at[0] + 0.5 - 0.5 * box.cells()[0]) * h[0],
                 y = (at[1] + 0.5 - 0.5 * box.cells()[1]) * h[1];
    if (is_inside(x, y, (at[2] + 0.5) * h[2]))
      cells[static_cast<std::size_t>(cell)] = 0;
  }
  return cells;
}

/// Half of the distance between two opposite corners of the hexagon in the box.
double half_width(const Grid& box) {
  return 0.5 * std::min(box.cells()[0] * box.spacing()[0], box.cells()[1] * box.spacing()[1]);
}

/// A regular hexagon with two of its corners on the x axis.
bool is_in_hexagon(double x, double y, double corner) {
  const double side = std::sqrt(3.0) / 2 * corner;
  return std::abs(y) <= side && std::abs(std::sqrt(3.0) / 2 * x + y / 2) <= side &&
         std::abs(std::sqrt(3.0) / 2 * x - y / 2) <= side;
}

/// Where a point is in the turn of the thread that it lies in, 0 to 1: ridges of the bolt are below one half
/// of it.
double phase(double x, double y, double z, const Thread& thread) {
  const double turns = z / thread.pitch - std::atan2(y, x) / (2 * pi);
  return turns - std::floor(turns);
}

/// As good as drawn by lot, and the same everywhere: the last step of MurmurHash3 (A. Appleby; public
/// domain).
std::uint32_t scattered(std::uint32_t number) {
  number ^= number >> 16;
  number *= 0x85ebca6bu;
  number ^= number >> 13;
  number *= 0xc2b2ae35u;
  return number ^ (number >> 16);
}

/// Height over the straight edge of what bulges out of it, in parts of the edge's length. @param along 0 to 1
double bulge(double along, std::uint32_t edge) {
  const std::uint32_t lot = scattered(edge);
  const double middle = 0.36 + 0.28 * ((lot >> 8) % 256) / 255.0, half = 0.24;
  const double off = (along - middle) / half;
  if (std::abs(off) >= 1)
    return 0;
  const double height = 0.18 + 0.08 * ((lot >> 16) % 256) / 255.0;
  return ((lot >> 24) % 2 == 0 ? 1 : -1) * height * std::pow(std::cos(0.5 * pi * off), 2);
}

/// The piece that the middle of a cell lies in.
std::array<int, 2> piece_at(double x, double y, double width, double height,
                            const std::array<int, 2>& pieces) {
  const int column = std::clamp(static_cast<int>(x / width), 0, pieces[0] - 1);
  std::array<int, 2> piece{0, 0};
  const double unit = std::min(width, height);
  for (int k = 1; k < pieces[1]; ++k)
    piece[1] +=
        y > k * height + unit * bulge(x / width - column, static_cast<unsigned>(49 + 13 * k + 101 * column));
  for (int k = 1; k < pieces[0]; ++k)
    piece[0] +=
        x > k * width + (piece[1] == 0 ? unit * bulge(y / height, static_cast<unsigned>(56 + 53 * k)) : 0);
  return piece;
}

/// Rings about two points, in 16 shades.
std::uint8_t shade_at(double x, double y) {
  const double near = std::hypot(x - 0.3, y - 0.6), far = std::hypot(x - 0.8, y - 0.2);
  const double value = 0.5 + 0.25 * std::cos(16 * near) + 0.25 * std::cos(11 * far);
  return static_cast<std::uint8_t>(std::clamp(static_cast<int>(16 * value), 0, 15));
}

} // namespace

std::vector<std::uint8_t> bolt_cells(const Grid& box, const Thread& thread, double head) {
  const double corner = half_width(box);
  return cells_inside(box, [&](double x, double y, double z) {
    if (z < head)
      return is_in_hexagon(x, y, corner);
    const double r = std::hypot(x, y);
    return r <= thread.radius - thread.depth || (r <= thread.radius && phase(x, y, z, thread) < 0.5);
  });
}

std::vector<std::uint8_t> nut_cells(const Grid& box, const Thread& thread) {
  const double corner = half_width(box), play = thread.play / thread.pitch;
  return cells_inside(box, [&](double x, double y, double z) {
    const double r = std::hypot(x, y), turn = phase(x, y, z, thread);
    const bool is_ridge = turn >= 0.5 + play && turn < 1 - play;
    return is_in_hexagon(x, y, corner) && r > thread.radius + thread.play - (is_ridge ? thread.depth : 0);
  });
}

std::vector<std::uint8_t> washer_cells(const Grid& box, double hole_radius) {
  return cells_inside(box, [&](double x, double y, double) {
    const double r = std::hypot(x, y);
    return r <= half_width(box) && r > hole_radius;
  });
}

std::vector<std::uint8_t> drawn_cells(const std::vector<std::string>& lines) {
  std::vector<std::uint8_t> cells;
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    for (const char c : *line)
      cells.push_back(c == ' ' || c == '.' ? no_material : std::uint8_t{0});
  return cells;
}

std::vector<std::uint8_t> puzzle_piece_cells(const Grid& picture, const PuzzleCut& cut) {
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(picture.n_cells()), no_material);
  const Index3& n = picture.cells();
  const double width = static_cast<double>(n[0]) / cut.pieces[0],
               height = static_cast<double>(n[1]) / cut.pieces[1];
  for (std::int64_t cell = 0; cell < picture.n_cells(); ++cell) {
    const Index3 at = picture.cell_at(cell);
    const double x = at[0] + 0.5, y = at[1] + 0.5;
    if (piece_at(x, y, width, height, cut.pieces) == cut.piece)
      cells[static_cast<std::size_t>(cell)] = shade_at(x / n[0], y / n[0]);
  }
  return cells;
}

} // namespace maille::reader
