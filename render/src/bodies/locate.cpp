#include "bodies/locate.hpp"
#include "maille/base/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace maille::render {

namespace {

/// Trilinear map of the cell at `rest` [cells]: the point and its derivatives.
std::array<Vec3, 4> mapped(const Deformation& deformation, const Vec3& rest) {
  const Lattice& lattice = deformation.lattice();
  Index3 cell{};
  Vec3 part{};
  for (std::size_t a = 0; a < 3; ++a) {
    cell[a] = static_cast<int>(std::clamp(std::floor(rest[a]), 0.0, lattice.cells[a] - 1.0));
    part[a] = rest[a] - cell[a];
  }
  const Index3 n = lattice.nodes();
  std::array<Vec3, 4> sum{};
  for (int corner = 0; corner < 8; ++corner) {
    std::array<double, 4> weight{1, 1, 1, 1};
    std::int64_t node = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const bool upper = ((corner >> a) & 1) != 0;
      node = node * n[a] + cell[a] + (upper ? 1 : 0);
      for (std::size_t d = 0; d < 4; ++d)
        weight[d] *= d == a + 1 ? (upper ? 1 : -1) : upper ? part[a] : 1 - part[a];
    }
    const Vec3 x = deformation.position(node);
    for (std::size_t d = 0; d < 4; ++d)
      sum[d] = plus(sum[d], times(weight[d], x));
  }
  return sum;
}

/// Newton's method from a guess, which it replaces. @return false where it is lost
bool carry_back(const Deformation& deformation, const Vec3& goal, Vec3& rest) {
  for (int round = 0; round < 20; ++round) {
    const auto [x, dx, dy, dz] = mapped(deformation, rest);
    const double volume = dot(dx, cross(dy, dz));
    if (!(volume > 0))
      return false;
    const Vec3 off = minus(x, goal);
    const Vec3 change{dot(cross(dy, dz), off) / volume, dot(cross(dz, dx), off) / volume,
                      dot(cross(dx, dy), off) / volume};
    double largest = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      rest[a] -= std::clamp(change[a], -1.5, 1.5);
      largest = std::max(largest, std::abs(change[a]));
    }
    if (largest < 1e-9)
      return true;
  }
  return false;
}

} // namespace

std::optional<Vec3> rest_on_ray(const Deformation& deformation, const Ray& ray, const Stretch& stretch,
                                double depth, double stride) {
  Vec3 rest{stretch.entry[0], stretch.entry[1], stretch.entry[2]};
  const double from = stretch.begin;
  const auto steps = static_cast<std::int64_t>(std::max(0.0, std::ceil((depth - from) / stride)));
  for (std::int64_t step = 0; step < steps; ++step)
    carry_back(deformation, plus(ray.origin, times(from + static_cast<double>(step) * stride, ray.direction)),
               rest); // folded cells on the way are passed
  if (!carry_back(deformation, plus(ray.origin, times(depth, ray.direction)), rest))
    return std::nullopt;
  const Lattice& lattice = deformation.lattice();
  for (std::size_t a = 0; a < 3; ++a)
    rest[a] = lattice.origin[a] + lattice.spacing[a] * rest[a];
  return rest;
}

} // namespace maille::render
