#include "world/cell_overlap.hpp"

#include "lattice/binned_boxes.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

void add_direction(const Eigen::Vector3d& way, std::vector<Eigen::Vector3d>& known) {
  const double length = way.norm();
  if (!(length > 0))
    return;
  const Eigen::Vector3d unit = way / length;
  if (std::ranges::none_of(known,
                           [&](const Eigen::Vector3d& one) { return one.cross(unit).norm() < tolerance; }))
    known.push_back(unit);
}

} // namespace

ConvexCell::ConvexCell(std::vector<Eigen::Vector3d> corners) : corners_(std::move(corners)) {
  for (const Eigen::Vector3d& corner : corners_)
    box_.extend(corner);
}

void ConvexCell::find_directions() const {
  if (!normals_.empty())
    return;
  const std::size_t n = corners_.size();
  for (std::size_t bit = 1; bit < n; bit *= 2)
    for (std::size_t i = 0; i < n; ++i)
      if ((i & bit) == 0)
        add_direction(corners_[i + bit] - corners_[i], edges_);
  if (n < 8) { // in a plane the edge normals are the only separating directions
    for (const Eigen::Vector3d& edge : edges_)
      add_direction(n == 2 ? edge : Eigen::Vector3d(-edge[1], edge[0], 0), normals_);
    edges_.clear();
    return;
  }
  for (std::size_t b = 1; b < n; b *= 2)
    for (std::size_t c = 2 * b; c < n; c *= 2)
      for (std::size_t i = 0; i < n; ++i)
        if ((i & (b + c)) == 0)
          for (const auto& [from, to] : {std::pair(b, c), std::pair(b, b + c), std::pair(c, b + c)}) {
            add_direction((corners_[i + from] - corners_[i]).cross(corners_[i + to] - corners_[i]), normals_);
            if (from + to == b + c) // the triangle without the first corner
              add_direction(
                  (corners_[i + b] - corners_[i + b + c]).cross(corners_[i + c] - corners_[i + b + c]),
                  normals_);
          }
}

bool may_be_in_one_another(const Eigen::AlignedBox3d& one, const Eigen::AlignedBox3d& other, int dimension,
                           double depth) {
  const Eigen::Vector3d along = (one.max() - other.min()).cwiseMin(other.max() - one.min());
  return along.head(dimension).minCoeff() > depth;
}

bool ConvexCell::overlaps_along(const ConvexCell& other, const Eigen::Vector3d& axis, double depth) const {
  const auto range = [&](const std::vector<Eigen::Vector3d>& corners) {
    std::pair<double, double> ends{axis.dot(corners.front()), axis.dot(corners.front())};
    for (const Eigen::Vector3d& corner : corners) {
      const double x = axis.dot(corner);
      ends = {std::min(ends.first, x), std::max(ends.second, x)};
    }
    return ends;
  };
  const auto [low, high] = range(corners_);
  const auto [other_low, other_high] = range(other.corners_);
  return std::min(high - other_low, other_high - low) > depth;
}

bool ConvexCell::is_deeper_in(const ConvexCell& other, double depth) const {
  if (!may_be_in_one_another(box_, other.box_, std::countr_zero(corners_.size()), depth))
    return false;
  find_directions();
  other.find_directions();
  const auto overlap = [&](const Eigen::Vector3d& axis) { return overlaps_along(other, axis, depth); };
  if (!std::ranges::all_of(normals_, overlap) || !std::ranges::all_of(other.normals_, overlap))
    return false;
  for (const Eigen::Vector3d& edge : edges_)
    for (const Eigen::Vector3d& across : other.edges_)
      if (const Eigen::Vector3d axis = edge.cross(across);
          axis.norm() > negligible && !overlap(axis.normalized()))
        return false;
  return true;
}

bool are_in_one_another(const std::vector<ConvexCell>& one, const std::vector<ConvexCell>& other,
                        double depth) {
  if (one.empty() || other.empty())
    return false;
  double edge = 0;
  for (const ConvexCell& cell : other)
    edge = std::max(edge, cell.box().sizes().maxCoeff());
  BinnedBoxes bins(edge);
  for (std::size_t i = 0; i < other.size(); ++i)
    bins.add(static_cast<std::int32_t>(i), other[i].box());
  bins.sort();
  for (const ConvexCell& cell : one) {
    std::int32_t before = -1;
    bool is_in = false;
    bins.visit(cell.box(), [&](std::int32_t i) {
      const ConvexCell& near = other[i];
      is_in = is_in || (std::exchange(before, i) != i && cell.is_deeper_in(near, depth));
    });
    if (is_in)
      return true;
  }
  return false;
}

namespace {

ConvexCell cell_of(const Grid& grid, const Pose& pose, const Index3& at) {
  std::vector<Eigen::Vector3d> corners;
  for (int corner = 0; corner < 1 << grid.dimension(); ++corner) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int a = 0; a < grid.dimension(); ++a) {
      const auto i = static_cast<std::size_t>(a);
      x[a] = (at[i] + (corner >> a & 1)) * grid.spacing()[i];
    }
    corners.emplace_back(pose.position + pose.rotation * x);
  }
  return ConvexCell(std::move(corners));
}

Eigen::AlignedBox3d box_of(const Grid& grid, const Pose& pose) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 1 << grid.dimension(); ++corner) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int a = 0; a < grid.dimension(); ++a)
      if (const auto i = static_cast<std::size_t>(a); (corner >> a & 1) != 0)
        x[a] = grid.cells()[i] * grid.spacing()[i];
    box.extend(pose.position + pose.rotation * x);
  }
  return box;
}

} // namespace

bool is_matter_in(const Specimen& one, const Pose& pose, const Specimen& other, const Pose& other_pose,
                  double depth) {
  const Grid &grid = one.grid, &other_grid = other.grid;
  if (grid.n_cells() > other_grid.n_cells())
    return is_matter_in(other, other_pose, one, pose, depth);
  if (!box_of(grid, pose).intersects(box_of(other_grid, other_pose)))
    return false;
  const int d = grid.dimension();
  double radius = 0; // of a cell
  for (int a = 0; a < d; ++a)
    radius = std::hypot(radius, 0.5 * grid.spacing()[a]);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!one.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int a = 0; a < d; ++a)
      middle[a] = (at[a] + 0.5) * grid.spacing()[a];
    const Eigen::Vector3d there =
        other_pose.rotation.transpose() * (pose.position + pose.rotation * middle - other_pose.position);
    Index3 first{}, last{}, near{};
    for (int a = 0; a < d; ++a) {
      const auto i = static_cast<std::size_t>(a);
      const double edge = other_grid.spacing()[i], most = other_grid.cells()[i] - 1.0;
      first[i] = static_cast<int>(std::clamp(std::floor((there[a] - radius) / edge), 0.0, most + 1));
      last[i] = static_cast<int>(std::clamp(std::floor((there[a] + radius) / edge), -1.0, most));
    }
    for (near[2] = first[2]; near[2] <= last[2]; ++near[2])
      for (near[1] = first[1]; near[1] <= last[1]; ++near[1])
        for (near[0] = first[0]; near[0] <= last[0]; ++near[0])
          if (other.is_matter(other_grid.cell(near)) &&
              cell_of(grid, pose, at).is_deeper_in(cell_of(other_grid, other_pose, near), depth))
            return true;
  }
  return false;
}

} // namespace maille::deform
