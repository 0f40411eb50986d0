#include "geometry/border_normals.hpp"

#include <algorithm>
#include <cmath>

namespace maille {

Vec3 BorderNormals::middle(const Grid& grid, const OrientedFace& face) {
  const Index3 at = grid.cell_at(face.cell);
  Vec3 middle{};
  for (int a = 0; a < grid.dimension(); ++a)
    middle[a] = at[a] + (static_cast<int>(a) == face.axis ? (face.upper ? 1.0 : 0.0) : 0.5);
  return middle;
}

BorderNormals::BorderNormals(const Grid& grid, const std::vector<OrientedFace>& faces)
    : spacing_(grid.spacing()) {
  const int d = grid.dimension();
  double volume = 1;
  for (int a = 0; a < 3; ++a)
    if (a >= d)
      spacing_[a] = 1;
    else
      volume *= spacing_[a];
  radius_ = reach * *std::max_element(spacing_.begin(), spacing_.begin() + d);
  for (const OrientedFace& face : faces) {
    Patch patch{middle(grid, face), {}};
    const auto axis = static_cast<std::size_t>(face.axis);
    patch.area[axis] = (face.upper ? 1 : -1) * volume / spacing_[axis];
    patches_[bucket(patch.middle)].push_back(patch);
  }
}

Index3 BorderNormals::bucket(const Vec3& place) const {
  Index3 at{};
  for (std::size_t a = 0; a < 3; ++a)
    at[a] = static_cast<int>(std::floor(place[a] * spacing_[a] / radius_));
  return at;
}

Vec3 BorderNormals::at(const Vec3& place) const {
  Vec3 sum{};
  const Index3 here = bucket(place);
  for (int way = 0; way < 27; ++way) {
    const auto found =
        patches_.find({here[0] + way % 3 - 1, here[1] + way / 3 % 3 - 1, here[2] + way / 9 - 1});
    if (found == patches_.end())
      continue;
    for (const Patch& patch : found->second) {
      double squared = 0;
      for (std::size_t a = 0; a < 3; ++a)
        squared += std::pow((patch.middle[a] - place[a]) * spacing_[a] / radius_, 2);
      const double weight = squared < 1 ? std::pow(1 - squared, 2) : 0;
      for (std::size_t a = 0; a < 3; ++a)
        sum[a] += weight * patch.area[a];
    }
  }
  const double length = std::hypot(sum[0], sum[1], sum[2]);
  if (!(length > 0))
    return {};
  for (double& component : sum) {
    component /= length;
    if (std::abs(component) < 1e-12) // makes the normal of a flat border exact
      component = 0;
  }
  return sum;
}

} // namespace maille
