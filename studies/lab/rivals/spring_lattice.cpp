#include "rivals/spring_lattice.hpp"

#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maille::lab {

namespace {

/// mu / E of the only isotropic solid that springs can be.
double shear_over_youngs_modulus(const Scene& scene) {
  if (scene.dimension() == 1)
    return 1.0 / 3; // lambda + 2 mu = E
  return scene.dimension() == 2 && scene.plane == PlaneAssumption::stress ? 3.0 / 8 : 2.0 / 5;
}

double youngs_modulus(const Material& material) {
  const auto& E = material.elasticity.youngs_modulus;
  return std::accumulate(E.begin(), E.end(), 0.0) / 3;
}

double cell_volume(const Grid& grid) {
  double volume = 1;
  for (int a = 0; a < grid.dimension(); ++a)
    volume *= grid.spacing()[static_cast<std::size_t>(a)];
  return volume;
}

/// Corners of a cell at which a spring of this direction starts: on the lower side of the axes that it
/// climbs, the upper side of those that it descends, either side of the others.
std::vector<Index3> starts_in_cell(int dimension, const Index3& step) {
  std::vector<Index3> starts;
  for (int corner = 0; corner < 1 << dimension; ++corner) {
    const Index3 at{corner & 1, corner >> 1 & 1, corner >> 2 & 1};
    bool inside = true;
    for (std::size_t a = 0; a < 3; ++a)
      inside = inside && at[a] + step[a] >= 0 && at[a] + step[a] <= 1;
    if (inside)
      starts.push_back(at);
  }
  return starts;
}

std::string what_is_lost(const Scene& scene) {
  const double nu = scene.dimension() == 2 && scene.plane == PlaneAssumption::stress ? 1.0 / 3 : 1.0 / 4;
  for (const Material& material : scene.materials) {
    if (!material.elasticity.is_isotropic())
      return fmt::format("springs are isotropic; {} is not", material.name);
    if (scene.dimension() > 1 && std::abs(material.elasticity.nu12 - nu) > 1e-9)
      return fmt::format("springs have Poisson ratio {:.3g}; {} has {:.3g}", nu, material.name,
                         material.elasticity.nu12);
  }
  return "";
}

} // namespace

double SpringLattice::edge_factor(const Grid& grid, std::size_t axis) const {
  const Vec3& h = grid.spacing();
  double factor = 3;
  for (std::size_t b = 0; b < static_cast<std::size_t>(grid.dimension()); ++b)
    factor -= b == axis ? 0 : h[axis] * h[axis] / (h[b] * h[b]);
  return factor;
}

SpringLattice::SpringLattice(const Scene& scene)
    : unit_of_length_(scene.specimen.grid.spacing()[0]), note_(what_is_lost(scene)) {
  const Grid& grid = scene.specimen.grid;
  const auto dimension = static_cast<std::size_t>(grid.dimension());
  for (std::size_t a = 0; a < dimension; ++a)
    if (edge_factor(grid, a) < 0)
      refusal_ =
          fmt::format("cells are too oblong: springs along axis {} would need a negative stiffness", a);
  if (!refusal_.empty())
    return;
  // Every direction leads to a higher node number: rows are visited in that order.
  for (std::size_t a = 0; a < dimension; ++a) {
    Index3 step{};
    step[a] = 1;
    add_direction(scene, step);
    for (std::size_t b = 0; b < a; ++b)
      for (const int sign : {1, -1}) {
        step[b] = sign;
        add_direction(scene, step);
        step[b] = 0;
      }
  }
  float stiffest = 0;
  for (const SpringDirection& direction : directions_)
    stiffest = std::max(stiffest, *std::ranges::max_element(direction.stiffness));
  unit_of_stiffness_ = double{stiffest};
  for (SpringDirection& direction : directions_)
    for (float& k : direction.stiffness)
      k /= stiffest;
}

void SpringLattice::add_direction(const Scene& scene, const Index3& step) {
  const Grid& grid = scene.specimen.grid;
  const Vec3& h = grid.spacing();
  SpringDirection direction;
  direction.step = step;
  direction.stiffness.assign(static_cast<std::size_t>(grid.n_nodes()), 0);
  double length2 = 0, product2 = 1;
  int n_axes = 0;
  std::size_t last_axis = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    direction.offset += step[a] * grid.stride(static_cast<int>(a));
    direction.rest[a] = step[a] * h[a] / unit_of_length_;
    if (step[a] == 0)
      continue;
    length2 += h[a] * h[a];
    product2 *= h[a] * h[a];
    ++n_axes;
    last_axis = a;
  }
  const double shape = n_axes == 2 ? length2 / (2 * product2) : edge_factor(grid, last_axis) / length2;
  add_cells(scene, direction, shear_over_youngs_modulus(scene) * cell_volume(grid) * shape);
  directions_.push_back(std::move(direction));
}

void SpringLattice::add_cells(const Scene& scene, SpringDirection& direction,
                              double stiffness_per_modulus) const {
  const Specimen& body = scene.specimen;
  const auto starts = starts_in_cell(scene.dimension(), direction.step);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    // Inside the body a spring is shared by as many cells as a cell has parallel springs.
    const double part = stiffness_per_modulus * youngs_modulus(scene.materials[body.material(cell)]) /
                        static_cast<double>(starts.size());
    const Index3 at = body.grid.cell_at(cell);
    for (const Index3& start : starts)
      direction.stiffness[static_cast<std::size_t>(body.grid.node(
          {at[0] + start[0], at[1] + start[1], at[2] + start[2]}))] += static_cast<float>(part);
  }
}

std::vector<float> SpringLattice::stiffness_at_nodes() const {
  std::vector<float> sum(directions_.empty() ? 0 : directions_[0].stiffness.size(), 0);
  for (const SpringDirection& direction : directions_)
    for (std::size_t i = 0; i < sum.size(); ++i)
      if (const float k = direction.stiffness[i]; k > 0) {
        sum[i] += k;
        sum[i + static_cast<std::size_t>(direction.offset)] += k;
      }
  return sum;
}

double SpringLattice::strain_energy(const Displacement& displacement) const {
  double energy = 0;
  for (const SpringDirection& direction : directions_)
    for (std::size_t i = 0; i < direction.stiffness.size(); ++i) {
      if (direction.stiffness[i] == 0)
        continue;
      const std::size_t j = i + static_cast<std::size_t>(direction.offset);
      double rest2 = 0, change = 0; // change: of the squared length, without cancellation
      for (std::size_t b = 0; b < displacement.n_components(); ++b) {
        const double rest = direction.rest[b] * unit_of_length_, u = displacement(b, j) - displacement(b, i);
        rest2 += rest * rest;
        change += u * (2 * rest + u);
      }
      const double excess = change / (std::sqrt(rest2 + change) + std::sqrt(rest2));
      energy += 0.5 * double{direction.stiffness[i]} * unit_of_stiffness_ * excess * excess;
    }
  return energy;
}

} // namespace maille::lab
