// Compiled where there is no libbullet, instead of bullet_soft_body.cpp and bullet_voxels.cpp.
#include "rivals/bullet_voxels.hpp"
#include "rivals/lattice_rivals.hpp"

namespace maille::lab {

std::optional<RivalResult> relax_by_bullet(const Scene&, double) {
  return std::nullopt;
}

std::unique_ptr<BulletVoxels> bullet_voxels(const std::vector<Vec3>&, const std::vector<Vec3>&) {
  return nullptr;
}

} // namespace maille::lab
