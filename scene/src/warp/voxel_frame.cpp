#include "warp/voxel_frame.hpp"

#include <array>

namespace maille::warping {

namespace {

Eigen::Matrix3d matrix(const std::array<Vec3, 3>& rows) {
  Eigen::Matrix3d m;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t a = 0; a < 3; ++a)
      m(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(a)) = rows[row][a];
  return m;
}

} // namespace

Affine3 voxels_to_world(const ImageInfo& grid) {
  return {matrix(grid.direction) * eigen(grid.spacing).asDiagonal(), eigen(grid.origin)};
}

Affine3 body_to_world(const ImageInfo& grid, const Placement& placement) {
  Affine3 map{matrix(placement.direction), eigen(placement.origin)};
  const bool is_other_world = placement.world != WorldAxes::unknown && grid.world != WorldAxes::unknown &&
                              placement.world != grid.world;
  if (is_other_world) {
    const Eigen::Vector3d turned(-1, -1, 1);
    map = {turned.asDiagonal() * map.linear, turned.asDiagonal() * map.shift};
  }
  return map;
}

Affine3 body_to_voxels(const ImageInfo& grid, const Placement& placement) {
  const Affine3 to_world = body_to_world(grid, placement);
  const Affine3 to_voxels = voxels_to_world(grid).inverse();
  return {to_voxels.linear * to_world.linear, to_voxels.of(to_world.shift)};
}

} // namespace maille::warping
