#include "maille/scene/block_frames.hpp"

#include <algorithm>

namespace maille {

namespace {

/// Difference of displacement along an edge [m].
Eigen::Vector3d difference(const Displacement& u, std::int64_t tail, std::int64_t head) {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (std::size_t b = 0; b < u.n_components(); ++b)
    d[static_cast<Eigen::Index>(b)] = u(b, head) - u(b, tail);
  return d;
}

} // namespace

Eigen::Matrix3d displacement_gradient(const Grid& grid, const Displacement& u, const Index3& cell) {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  const int d = grid.dimension();
  const double share = 2.0 / grid.corners_per_cell();
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
    const std::int64_t node = grid.corner(cell, corner);
    for (int axis = 0; axis < d; ++axis) {
      const double weight = (corner >> axis & 1 ? share : -share) / grid.spacing()[axis];
      for (int b = 0; b < d; ++b)
        gradient(b, axis) += weight * u(b, node);
    }
  }
  return gradient;
}

List<Eigen::Quaterniond> block_rotations(const Scene& scene, const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  List<Eigen::Quaterniond> rotation(static_cast<std::size_t>(grid.n_cells()), Eigen::Quaterniond::Identity());
  if (scene.dimension() == 1)
    return rotation;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      rotation[cell] = nearest_rotation(scene.dimension(),
                                        Eigen::Matrix3d::Identity() +
                                            displacement_gradient(grid, displacement, grid.cell_at(cell)),
                                        Eigen::Quaterniond::Identity());
  return rotation;
}

double largest_violation_in_blocks(const Scene& scene, const LinkLimits& limits,
                                   const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  const List<Eigen::Quaterniond> rotation = block_rotations(scene, displacement);
  double largest = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const double rest = grid.spacing()[axis];
    const Eigen::Vector3d at_rest = rest * Eigen::Vector3d::Unit(axis);
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      if (at[axis] + 1 >= grid.nodes()[axis])
        continue;
      const auto link = limits.intervals(at, axis);
      if (!link)
        continue;
      const Eigen::Vector3d now = at_rest + difference(displacement, node, node + grid.stride(axis));
      MeanRotation mean;
      scene.specimen.for_each_cell_at_link(at, axis, [&](std::int64_t cell) { mean.add(rotation[cell]); });
      const Eigen::Vector3d change = mean.value().conjugate() * now - at_rest;
      for (int b = 0; b < grid.dimension(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        largest = std::max({largest, (link->low[i] - change[b]) / rest, (change[b] - link->high[i]) / rest});
      }
    }
  }
  return largest;
}

} // namespace maille
