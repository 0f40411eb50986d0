#include "maille/scene/turn.hpp"

#include <Eigen/Geometry>

namespace maille {

Vec3 Turn::displacement(const Vec3& x, double fraction) const {
  const Eigen::Vector3d along(axis[0], axis[1], axis[2]);
  const Eigen::Vector3d arm(x[0] - about[0], x[1] - about[1], x[2] - about[2]);
  const Eigen::Vector3d turned = Eigen::AngleAxisd(fraction * angle, along) * arm;
  Vec3 u{};
  for (std::size_t b = 0; b < 3; ++b)
    u[b] = fraction * by[b] + (turned[static_cast<Eigen::Index>(b)] - arm[static_cast<Eigen::Index>(b)]);
  return u;
}

} // namespace maille
