#include "maille/base/vectors.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/sliding.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace maille {

List<NodalSpring> nodal_springs(const Scene& scene) {
  List<NodalSpring> all;
  const Grid& grid = scene.specimen.grid;
  const int d = grid.dimension(), corners = grid.corners_per_cell();
  for (const FaceSpring& spring : scene.springs) {
    const double share = spring.stiffness * face_area(grid, spring.axis) * 2 / corners;
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

std::vector<SpringPull> pulls_of_springs(const Scene& scene, const Answer& answer,
                                         std::optional<std::int32_t> condition) {
  std::map<std::int32_t, Scene> of_label; // springs on one side of each border
  for (const FaceSpring& spring : scene.springs) {
    if (condition && spring.condition != *condition)
      continue;
    const bool has_sides = !answer.split.empty();
    Scene& alone = of_label[has_sides ? scene.specimen.label[spring.cell] : 0];
    alone.specimen.grid = scene.specimen.grid;
    alone.springs.push_back(spring);
  }
  const DisplacementOfCells u(scene.specimen, answer);
  std::vector<SpringPull> pulls;
  for (const auto& [label, alone] : of_label)
    for (const NodalSpring& spring : nodal_springs(alone)) {
      const Vec3 at = u(spring.node, alone.springs.front().cell);
      const Eigen::Vector3d pull = -(spring.stiffness * Eigen::Vector3d(at[0], at[1], at[2]));
      pulls.push_back({spring.node, {pull[0], pull[1], pull[2]}, spring.stiffness.trace()});
    }
  return pulls;
}

} // namespace maille
