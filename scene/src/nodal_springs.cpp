#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>

namespace maille {

List<NodalSpring> nodal_springs(const Scene& scene) {
  List<NodalSpring> all;
  const Grid& grid = scene.specimen.grid;
  const int d = grid.dimension(), corners = grid.corners_per_cell();
  for (const FaceSpring& spring : scene.springs) {
    double area = 1;
    for (int a = 0; a < d; ++a)
      area *= a == spring.axis ? 1 : grid.spacing()[static_cast<std::size_t>(a)];
    const double share = spring.stiffness * area * 2 / corners;
    const Eigen::Vector3d n(spring.direction[0], spring.direction[1], spring.direction[2]);
    Eigen::Matrix3d stiffness = share * n * n.transpose();
    if (n.isZero(0))
      stiffness.diagonal().head(d).setConstant(share);
    for (int corner = 0; corner < corners; ++corner)
      if ((corner >> spring.axis & 1) == (spring.upper ? 1 : 0))
        all.push_back({grid.corner(grid.cell_at(spring.cell), corner), stiffness});
  }
  std::ranges::stable_sort(all, {}, &NodalSpring::node);
  std::size_t n = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (n > 0 && all[n - 1].node == all[i].node)
      all[n - 1].stiffness += all[i].stiffness;
    else
      all[n++] = all[i];
  all.resize(n);
  return all;
}

Vec3 pull_of(const NodalSpring& spring, const Displacement& u) {
  const Vec3 at = u.at(spring.node);
  const Eigen::Vector3d pull = -(spring.stiffness * Eigen::Vector3d(at[0], at[1], at[2]));
  return {pull[0], pull[1], pull[2]};
}

double energy_of_springs(const List<NodalSpring>& springs, const Displacement& u) {
  double twice = 0;
  for (const NodalSpring& spring : springs) {
    const Vec3 at = u.at(spring.node);
    const Eigen::Vector3d v(at[0], at[1], at[2]);
    twice += v.dot(spring.stiffness * v);
  }
  return twice / 2;
}

} // namespace maille
