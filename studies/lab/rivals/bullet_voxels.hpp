#pragma once
/// Bullet's collision detection between bodies of voxels.

#include "maille/base/grid.hpp"

#include <memory>
#include <vector>

namespace maille::lab {

/// Bodies of unit voxels as boxes of Bullet: a still one, and a tool that is tested at poses.
struct BulletVoxels {
  virtual ~BulletVoxels() = default;
  /// Whether the tool, shifted by that many voxels, touches the still body.
  virtual bool touches(double x, double y, double z) = 0;
};
/// @param still, tool centres of voxels @return null where Bullet was not built
std::unique_ptr<BulletVoxels> bullet_voxels(const std::vector<Vec3>& still, const std::vector<Vec3>& tool);

} // namespace maille::lab
