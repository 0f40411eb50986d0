#include "conditions/voxelise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace maille::reader {

namespace {

struct Box {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  void add(const Vec3& x) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
    }
  }
};

Box box_of(const std::vector<std::vector<Triangle>>& surfaces) {
  Box box;
  for (const auto& triangles : surfaces)
    for (const Triangle& triangle : triangles)
      for (const Vec3& corner : triangle)
        box.add(corner);
  return box;
}

/// Which rows of voxels along x a triangle crosses, and where.
class Crossings {
public:
  Crossings(const ImageInfo& grid, const Vec3& low)
      : size_(grid.size), spacing_(grid.spacing), low_(low),
        rows_(static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2])) {}

  void add(const Triangle& triangle) {
    Box box;
    for (const Vec3& corner : triangle)
      box.add(corner);
    for (int k = first(box.low[2], 2); k <= last(box.high[2], 2); ++k)
      for (int j = first(box.low[1], 1); j <= last(box.high[1], 1); ++j)
        if (const auto crossing = crossed(triangle, middle(j, 1), middle(k, 2)))
          row(j, k).push_back(*crossing);
  }

  /// Where a line goes through the surface, and whether inwards by the order of the triangle's corners.
  struct Crossing {
    double x = 0;
    int step = 0; ///< 1: inwards, -1: outwards
  };
  std::vector<Crossing>& row(int j, int k) {
    return rows_[static_cast<std::size_t>(j) +
                 static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(k)];
  }
  /// A little beside it, so that no line meets an edge.
  double middle(int i, std::size_t axis) const {
    constexpr std::array<double, 3> beside{0, 0.61803e-6, 0.41421e-6};
    return low_[axis] + (i + 0.5 + beside[axis]) * spacing_[axis];
  }

private:
  int first(double x, std::size_t axis) const {
    return static_cast<int>(
        std::clamp(std::floor((x - low_[axis]) / spacing_[axis] - 0.5), 0.0, size_[axis] - 1.0));
  }
  int last(double x, std::size_t axis) const {
    return static_cast<int>(
        std::clamp(std::ceil((x - low_[axis]) / spacing_[axis] - 0.5), 0.0, size_[axis] - 1.0));
  }
  /// Where a line along x through (y, z) goes through a triangle. An edge belongs to the triangle that is
  /// to the side of larger y, of edges along y of larger z: two triangles that share one never both have
  /// it.
  static std::optional<Crossing> crossed(const Triangle& triangle, double y, double z) {
    bool is_in = false;
    for (std::size_t c = 0; c < 3; ++c) { // crossings of the edges by a half-line along y
      const Vec3 &a = triangle[c], &b = triangle[(c + 1) % 3];
      if ((a[2] > z) != (b[2] > z) && y < a[1] + (z - a[2]) / (b[2] - a[2]) * (b[1] - a[1]))
        is_in = !is_in;
    }
    if (!is_in)
      return std::nullopt;
    const Vec3 &o = triangle[0], &p = triangle[1], &q = triangle[2];
    const double n_x = (p[1] - o[1]) * (q[2] - o[2]) - (p[2] - o[2]) * (q[1] - o[1]);
    const double n_y = (p[2] - o[2]) * (q[0] - o[0]) - (p[0] - o[0]) * (q[2] - o[2]);
    const double n_z = (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
    if (n_x == 0)
      return std::nullopt;
    return Crossing{o[0] - (n_y * (y - o[1]) + n_z * (z - o[2])) / n_x, n_x < 0 ? 1 : -1};
  }

  Index3 size_;
  Vec3 spacing_, low_;
  std::vector<std::vector<Crossing>> rows_;
};

} // namespace

std::array<double, 3> voxels_of(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing) {
  const Box box = box_of(surfaces);
  std::array<double, 3> n{};
  for (std::size_t a = 0; a < 3; ++a)
    n[a] = std::max(1.0, std::ceil((box.high[a] - box.low[a]) / spacing[a] - 1e-6));
  return n;
}

OrFault<Image> voxelised(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing) {
  const Box box = box_of(surfaces);
  const auto n = voxels_of(surfaces, spacing);
  Image image;
  image.info.spacing = spacing;
  for (std::size_t a = 0; a < 3; ++a) {
    image.info.size[a] = static_cast<int>(n[a]);
    image.info.origin[a] = box.low[a] + spacing[a] / 2;
  }
  image.values.assign(static_cast<std::size_t>(image.info.n_voxels()), 0);
  const Index3& size = image.info.size;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    Crossings crossings(image.info, box.low);
    for (const Triangle& triangle : surfaces[s])
      crossings.add(triangle);
    bool holds_any = false, is_oriented = true; // each line that enters leaves
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j) {
        int depth = 0;
        for (const auto& crossing : crossings.row(j, k))
          depth += crossing.step;
        is_oriented = is_oriented && depth == 0;
      }
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j) {
        auto& row = crossings.row(j, k);
        if (row.size() % 2 != 0)
          return RegionFault{
              "a closed surface",
              fmt::format("surface {} with a hole: a line along x at y = {:.6g}, z = {:.6g} m crosses "
                          "it {} times",
                          s + 1, crossings.middle(j, 1), crossings.middle(k, 2), row.size())};
        std::ranges::sort(row, {}, [](const auto& crossing) { return crossing.x; });
        int depth = 0;
        for (std::size_t c = 0; c + 1 < row.size(); ++c) {
          depth += is_oriented ? row[c].step : c % 2 == 0 ? 1 : -1;
          for (int i = 0; i < size[0] && depth != 0; ++i)
            if (const double x = crossings.middle(i, 0); x >= row[c].x && x < row[c + 1].x) {
              image.values[static_cast<std::size_t>(
                  i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k))] = static_cast<float>(s + 1);
              holds_any = true;
            }
        }
      }
    if (!holds_any)
      return RegionFault{"a closed surface around the middle of at least one voxel",
                         fmt::format("surface {}, of {} triangles, around none: it is open or thinner than "
                                     "`spacing`",
                                     s + 1, surfaces[s].size())};
  }
  return image;
}

} // namespace maille::reader
