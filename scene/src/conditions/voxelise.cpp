#include "conditions/voxelise.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <vector>

namespace maille::reader {

namespace {

using Box = Eigen::AlignedBox3d;

Eigen::Vector3d vector(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Box box_of(const std::vector<std::vector<Triangle>>& surfaces) {
  Box box;
  for (const auto& triangles : surfaces)
    for (const Triangle& triangle : triangles)
      for (const Vec3& corner : triangle)
        box.extend(vector(corner));
  return box;
}

/// Intersections of a triangle with rows of voxels along x, which pass slightly beside the voxel centres so
/// that they meet no edge.
class RowsOfTriangle {
public:
  RowsOfTriangle(const Triangle& triangle, const ImageInfo& grid, const Vec3& low)
      : triangle_(triangle), grid_(grid), low_(low) {
    for (const Vec3& corner : triangle)
      box_.extend(vector(corner));
  }
  static double middle(const ImageInfo& grid, const Vec3& low, int i, std::size_t axis) {
    constexpr std::array<double, 3> beside{0, 0.61803e-6, 0.41421e-6};
    return low[axis] + (i + 0.5 + beside[axis]) * grid.spacing[axis];
  }
  int first(std::size_t axis) const { return row_at(std::floor(steps(box_.min()[axis], axis)), axis); }
  int last(std::size_t axis) const { return row_at(std::ceil(steps(box_.max()[axis], axis)), axis); }

  /// Intersection of a line with the surface, and its direction by the orientation of the triangle.
  struct Crossing {
    double x = 0;
    int step = 0; ///< 1: inwards, -1: outwards
    std::uint32_t shell = 0;
  };
  /// Intersection of the row through (y, z) with the triangle. An edge belongs to the triangle on the side of
  /// larger y (edges along y: larger z), so that two triangles never share a crossing.
  std::optional<Crossing> crossed(double y, double z) const {
    bool is_in = false;
    for (std::size_t c = 0; c < 3; ++c) { // crossings of the edges by a half-line along y
      const Vec3 &a = triangle_[c], &b = triangle_[(c + 1) % 3];
      if ((a[2] > z) != (b[2] > z) && y < a[1] + (z - a[2]) / (b[2] - a[2]) * (b[1] - a[1]))
        is_in = !is_in;
    }
    if (!is_in)
      return std::nullopt;
    const Vec3 &o = triangle_[0], &p = triangle_[1], &q = triangle_[2];
    const double n_x = (p[1] - o[1]) * (q[2] - o[2]) - (p[2] - o[2]) * (q[1] - o[1]);
    const double n_y = (p[2] - o[2]) * (q[0] - o[0]) - (p[0] - o[0]) * (q[2] - o[2]);
    const double n_z = (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
    if (n_x == 0)
      return std::nullopt;
    return Crossing{o[0] - (n_y * (y - o[1]) + n_z * (z - o[2])) / n_x, n_x < 0 ? 1 : -1};
  }

private:
  double steps(double x, std::size_t axis) const { return (x - low_[axis]) / grid_.spacing[axis] - 0.5; }
  int row_at(double step, std::size_t axis) const {
    return static_cast<int>(std::clamp(step, 0.0, grid_.size[axis] - 1.0));
  }

  const Triangle& triangle_;
  const ImageInfo& grid_;
  const Vec3& low_;
  Box box_;
};

/// Largest relative difference between the volume of a surface and that of its voxels that border rounding
/// explains.
constexpr double largest_loss = 0.08;

/// Enclosed volume by Gauss' theorem; cavities are subtracted. Nothing if orientations are inconsistent.
std::optional<double> volume_of(const std::vector<Triangle>& triangles) {
  double volume = 0, area = 0;
  Eigen::Vector3d sum(0, 0, 0);
  for (const Triangle& t : triangles) {
    const Eigen::Vector3d a = vector(t[0]), normal = (vector(t[1]) - a).cross(vector(t[2]) - a);
    volume += a.dot(normal) / 6;
    area += normal.norm();
    sum += normal;
  }
  return sum.norm() < 1e-6 * area ? std::optional(std::abs(volume)) : std::nullopt;
}

/// Shell number per triangle: triangles with a common corner belong to one closed shell.
std::vector<std::uint32_t> shells_of(const std::vector<Triangle>& triangles) {
  std::map<Vec3, std::uint32_t> of_corner;
  std::vector<std::uint32_t> root(triangles.size());
  std::iota(root.begin(), root.end(), 0U);
  const auto find = [&](std::uint32_t t) {
    while (root[t] != t)
      t = root[t] = root[root[t]];
    return t;
  };
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (const Vec3& corner : triangles[t])
      root[find(t)] = find(of_corner.emplace(corner, t).first->second);
  for (std::uint32_t t = 0; t < root.size(); ++t)
    root[t] = find(t);
  return root;
}

/// Finds the shells that contain a voxel centre. The others are missing in the body, as are their cavities.
class ShellCensus {
public:
  ShellCensus(const std::vector<Triangle>& triangles, const ImageInfo& grid, const Vec3& low)
      : grid_(grid), low_(low), shell_(shells_of(triangles)), state_(shell_.size()),
        holds_(shell_.size(), false) {}
  std::uint32_t shell_of(std::uint32_t triangle) const { return shell_[triangle]; }
  int depth(std::uint32_t shell) const { return state_[shell].first; }
  /// Processes a crossing; those of a row come in order. @param step  change of the depth in the shell
  void cross(std::uint32_t shell, double x, int step) {
    const auto voxel = [&](double at) { return std::ceil((at - low_[0]) / grid_.spacing[0] - 0.5); };
    auto& [depth, entered] = state_[shell];
    holds_[shell] = holds_[shell] || (depth != 0 && voxel(entered) < voxel(x));
    entered = x;
    depth += step;
  }
  std::size_t lost(std::size_t& all) const {
    std::size_t n = 0;
    all = 0;
    for (std::uint32_t t = 0; t < shell_.size(); ++t)
      if (shell_[t] == t) {
        ++all;
        n += holds_[t] ? 0 : 1;
      }
    return n;
  }

private:
  const ImageInfo& grid_;
  const Vec3& low_;
  std::vector<std::uint32_t> shell_;
  std::vector<std::pair<int, double>> state_; ///< depth, and x where it began
  std::vector<bool> holds_;
};

/// Adds the triangles that begin in a row or layer and removes those that ended before it.
/// @param order   by first row or layer; those before `next` are already added
void move_on(const std::vector<RowsOfTriangle>& triangles, const std::vector<std::uint32_t>& order,
             std::size_t axis, int at, std::size_t& next, std::vector<std::uint32_t>& open) {
  std::erase_if(open, [&](std::uint32_t t) { return triangles[t].last(axis) < at; });
  for (; next < order.size() && triangles[order[next]].first(axis) <= at; ++next)
    open.push_back(order[next]);
}

} // namespace

std::array<double, 3> voxels_of(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing) {
  const Box box = box_of(surfaces);
  std::array<double, 3> n{};
  for (std::size_t a = 0; a < 3; ++a)
    n[a] = std::max(1.0, std::ceil((box.max()[a] - box.min()[a]) / spacing[a] - 1e-6));
  return n;
}

OrFault<Image> voxelised(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing,
                         std::vector<std::string>* lost) {
  const Box box = box_of(surfaces);
  const auto n = voxels_of(surfaces, spacing);
  Image image;
  image.info.spacing = spacing;
  for (std::size_t a = 0; a < 3; ++a) {
    image.info.size[a] = static_cast<int>(n[a]);
    image.info.origin[a] = box.min()[a] + spacing[a] / 2;
  }
  const Vec3 low{box.min()[0], box.min()[1], box.min()[2]};
  image.values.assign(image.info.n_voxels(), 0);
  const Index3& size = image.info.size;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    ShellCensus shells(surfaces[s], image.info, low);
    std::vector<RowsOfTriangle> triangles;
    for (const Triangle& triangle : surfaces[s])
      triangles.emplace_back(triangle, image.info, low);
    const auto middle = [&](int i, std::size_t axis) {
      return RowsOfTriangle::middle(image.info, low, i, axis);
    };
    std::vector<std::uint32_t> order(triangles.size()), in_layer, rows, in_row;
    const auto by_first = [&](std::size_t axis) {
      return [&, axis](std::uint32_t one, std::uint32_t other) {
        return triangles[one].first(axis) < triangles[other].first(axis);
      };
    };
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::sort(order, by_first(2));
    // Visits the crossings row by row, so that memory scales with the triangles.
    const auto for_each_row = [&](const auto& visit) {
      std::vector<RowsOfTriangle::Crossing> row;
      std::size_t next_of_layer = 0;
      in_layer.clear();
      for (int k = 0; k < size[2]; ++k) {
        move_on(triangles, order, 2, k, next_of_layer, in_layer);
        rows = in_layer;
        std::ranges::sort(rows, by_first(1));
        in_row.clear();
        std::size_t next_of_row = 0;
        for (int j = 0; j < size[1]; ++j) {
          move_on(triangles, rows, 1, j, next_of_row, in_row);
          row.clear();
          for (const std::uint32_t triangle : in_row)
            if (auto crossing = triangles[triangle].crossed(middle(j, 1), middle(k, 2))) {
              crossing->shell = shells.shell_of(triangle);
              row.push_back(*crossing);
            }
          visit(row, j, k);
        }
      }
    };
    std::optional<RegionFault> hole;
    std::int64_t n_filled = 0;
    bool is_oriented = true; // each line that enters leaves
    for_each_row([&](const auto& row, int j, int k) {
      int depth = 0;
      for (const auto& crossing : row)
        depth += crossing.step;
      is_oriented = is_oriented && depth == 0;
      if (row.size() % 2 != 0 && !hole)
        hole = RegionFault{
            "a closed surface",
            fmt::format(
                "surface {} with a hole: a line along x at y = {:.6g}, z = {:.6g} m crosses it {} times",
                s + 1, middle(j, 1), middle(k, 2), row.size())};
    });
    if (hole)
      return *hole;
    for_each_row([&](auto& row, int j, int k) {
      std::ranges::sort(row, {}, [](const auto& crossing) { return crossing.x; });
      for (const auto& crossing : row)
        shells.cross(crossing.shell, crossing.x,
                     is_oriented                    ? crossing.step
                     : shells.depth(crossing.shell) ? -1
                                                    : 1);
      int depth = 0;
      for (std::size_t c = 0; c + 1 < row.size(); ++c) {
        depth += is_oriented ? row[c].step : c % 2 == 0 ? 1 : -1;
        for (int i = 0; depth != 0 && row[c].x < row[c + 1].x && i < size[0]; ++i)
          if (const double x = middle(i, 0); x >= row[c].x && x < row[c + 1].x) {
            image.values[i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k)] =
                static_cast<float>(s + 1);
            ++n_filled;
          }
      }
    });
    if (n_filled == 0)
      return RegionFault{"a closed surface around the middle of at least one voxel",
                         fmt::format("surface {}, of {} triangles, around none: it is open or thinner than "
                                     "`spacing`",
                                     s + 1, surfaces[s].size())};
    std::size_t all = 0;
    if (const std::size_t n_lost = shells.lost(all); lost && n_lost > 0)
      lost->push_back(
          fmt::format("surface {}: {} of {} closed shells hold no voxel's middle, as they are thinner "
                      "than `spacing`: they are left out",
                      s + 1, n_lost, all));
    const auto enclosed = volume_of(surfaces[s]);
    const double filled = static_cast<double>(n_filled) * spacing[0] * spacing[1] * spacing[2];
    if (lost && enclosed && std::abs(*enclosed - filled) > largest_loss * *enclosed)
      lost->push_back(
          fmt::format("surface {} encloses {:.4g} mm^3, and its voxels are {:.4g} mm^3: parts are thinner "
                      "than `spacing`, or shells overlap",
                      s + 1, 1e9 * *enclosed, 1e9 * filled));
  }
  return image;
}

} // namespace maille::reader
