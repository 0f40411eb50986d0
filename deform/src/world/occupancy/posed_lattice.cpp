#include "world/occupancy/posed_lattice.hpp"

#include <algorithm>

namespace maille::deform {

Index3 cell_at(const InCells& place) {
  Index3 cell;
  for (std::size_t a = 0; a < 3; ++a) {
    const double at = std::clamp(place[a], -furthest_cell, furthest_cell);
    cell[a] = static_cast<int>(at); // truncates; std::floor() would be a function call
    cell[a] -= at < cell[a] ? 1 : 0;
  }
  return cell;
}

PosedLattice::PosedLattice(const Specimen& specimen, const Pose& pose, const Vec3& cell_size)
    : pose_(pose), cell_size_(cell_size), dimension_(specimen.grid.dimension()),
      is_turned_(pose.rotation != Eigen::Matrix3d::Identity()) {
  const Grid& grid = specimen.grid;
  voxels_.assign(grid.n_nodes(), -1);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    if (!specimen.is_node(at))
      continue;
    voxels_[node] = n_voxels();
    nodes_.push_back(node);
    const Vec3 x = specimen.position(at);
    const Eigen::Vector3d within(x[0], x[1], x[2]);
    rest_.push_back(is_turned_ ? Eigen::Vector3d(pose.position + pose.rotation * within)
                               : Eigen::Vector3d(pose.position + within));
  }
}

Eigen::Vector3d PosedLattice::position(std::int32_t voxel, const Displacement& displacement) const {
  const Vec3 u = displacement.at(node(voxel));
  const Eigen::Vector3d within(u[0], u[1], u[2]);
  return rest(voxel) + (is_turned_ ? Eigen::Vector3d(pose_.rotation * within) : within);
}

InCells PosedLattice::place(std::int32_t voxel, const Displacement& displacement) const {
  const Eigen::Vector3d x = position(voxel, displacement);
  InCells place{0.5, 0.5, 0.5};
  for (int a = 0; a < dimension_; ++a)
    place[a] = x[a] / cell_size_[a];
  return place;
}

std::vector<InCells> PosedLattice::places(const Displacement& displacement) const {
  std::vector<InCells> places;
  places.reserve(nodes_.size());
  for (std::int32_t voxel = 0; voxel < n_voxels(); ++voxel)
    places.push_back(place(voxel, displacement));
  return places;
}

Vec3 PosedLattice::displacement_at(std::int32_t voxel, const Eigen::Vector3d& position) const {
  const Eigen::Vector3d shift = position - rest(voxel),
                        u = is_turned_ ? Eigen::Vector3d(pose_.rotation.transpose() * shift) : shift;
  return {u[0], u[1], u[2]};
}

Vec3 PosedLattice::moved_along(std::int32_t voxel, const Displacement& displacement, int axis,
                               double to) const {
  Eigen::Vector3d x = position(voxel, displacement);
  x[axis] = to * cell_size_[axis];
  if (is_turned_)
    return displacement_at(voxel, x);
  Vec3 u = displacement.at(node(voxel)); // the other components stay bit-identical
  u[axis] = x[axis] - rest(voxel)[axis];
  return u;
}

std::int64_t PosedLattice::bytes() const {
  return static_cast<std::int64_t>(nodes_.capacity() * sizeof(std::int64_t) +
                                   voxels_.capacity() * sizeof(std::int32_t) +
                                   rest_.capacity() * sizeof(Eigen::Vector3d));
}

} // namespace maille::deform
