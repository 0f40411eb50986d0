#include "elastic/finite/follower_pressure.hpp"

#include <Eigen/Geometry>

#include <array>

namespace maille::deform {

FollowerPressure::FollowerPressure(const Scene& scene)
    : grid_(scene.specimen.grid), origin_(scene.specimen.origin) {
  const int d = grid_.dimension();
  for (const FaceLoad& load : scene.tractions) {
    if (!load.follows || d == 1) // in 1D faces do not turn
      continue;
    const int a = load.axis, b = (a + 1) % d, c = (a + 2) % 3, side = load.upper ? 1 << a : 0;
    // A traction along -normal is a pressure; the lower face's normal is against its axis.
    Face face{{}, -load.traction[a], a};
    const std::vector<int> around =
        d == 3 ? std::vector{0, 1 << b, 1 << b | 1 << c, 1 << c} : std::vector{0, 1 << b};
    for (const int corner : around)
      face.corners.push_back(grid_.corner(grid_.cell_at(load.cell), side | corner));
    faces_.push_back(std::move(face));
  }
}

void FollowerPressure::add_forces(const Displacement& u, Displacement& forces) const {
  const auto place = [&](std::int64_t node) {
    const Index3 at = grid_.node_at(node);
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int k = 0; k < grid_.dimension(); ++k)
      x[k] = origin_[k] + grid_.spacing()[k] * at[k] + u(k, node);
    return x;
  };
  for (const Face& face : faces_) {
    const auto& corner = face.corners;
    const Eigen::Vector3d across = place(corner[corner.size() / 2]) - place(corner[0]);
    Eigen::Vector3d area;
    if (grid_.dimension() == 3)
      area = 0.5 * across.cross(place(corner[3]) - place(corner[1]));
    else // the edge runs along y on faces across x, along x on faces across y
      area = (face.axis == 0 ? 1 : -1) * Eigen::Vector3d(across[1], -across[0], 0);
    for (const std::int64_t node : corner)
      for (int k = 0; k < grid_.dimension(); ++k)
        forces(k, node) -= face.pressure * area[k] / static_cast<double>(corner.size());
  }
}

} // namespace maille::deform
