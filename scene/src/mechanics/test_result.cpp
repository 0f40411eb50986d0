#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille {

namespace {

/// Axis of the right-handed rotation from `axis` towards `along`.
Eigen::Vector3d bending_axis(const StandardTest& test) {
  return Eigen::Vector3d::Unit(test.axis).cross(Eigen::Vector3d::Unit(test.along));
}

/// Force or moment on the moved nodes, along or about an axis of the object.
double on_moves(const Scene& scene, const Answer& answer, Vec3 Resultant::*what,
                const Eigen::Vector3d& axis) {
  const Vec3 in_world = to_world(scene.specimen.placement, {axis[0], axis[1], axis[2]});
  double sum = 0;
  for (const Resultant& resultant : resultants_of(scene, answer).moves)
    for (std::size_t a = 0; a < 3; ++a)
      sum += (resultant.*what)[a] * in_world[a];
  return sum;
}

/// Factor on the test's strain at which 2 % of the tissue exceeds an effective strain sqrt(2 U / E) of 0.7 %,
/// with U the strain energy density.
std::optional<double> factor_to_failure(const Scene& scene, const Answer& answer) {
  constexpr double effective_strain = 0.007, failing = 0.02;
  const CellFields fields = cell_fields(scene, answer);
  std::vector<double> effective;
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const auto& strain = fields.strain[cell];
    const auto& stress = fields.stress[cell];
    double twice_energy = 0;
    for (std::size_t i = 0; i < 6; ++i)
      twice_energy += (i < 3 ? 1 : 2) * strain[i] * stress[i];
    const double modulus = scene.materials[scene.specimen.material(cell)].elasticity.youngs_modulus[0];
    effective.push_back(std::sqrt(std::max(0.0, twice_energy) / modulus));
  }
  const auto n =
      static_cast<std::ptrdiff_t>(std::ceil((1 - failing) * static_cast<double>(effective.size())));
  const auto at = effective.begin() + std::clamp<std::ptrdiff_t>(n - 1, 0, std::ssize(effective) - 1);
  std::ranges::nth_element(effective, at);
  return *at > 0 ? std::optional(effective_strain / *at) : std::nullopt;
}

} // namespace

std::optional<TestResult> test_result(const Scene& scene, const Answer& answer) {
  if (!scene.test || answer.reaction.size() != scene.prescribed.size() || scene.test->strain == 0)
    return std::nullopt;
  const StandardTest& test = *scene.test;
  TestResult result;
  const double displacement = test.displacement();
  switch (test.kind) {
  case TestKind::axial:
  case TestKind::confined:
  case TestKind::shear:
    result.reaction = on_moves(scene, answer, &Resultant::force,
                               Eigen::Vector3d::Unit(test.kind == TestKind::shear ? test.along : test.axis));
    result.stiffness = result.reaction / displacement;
    result.apparent_modulus = result.reaction / (test.area * test.strain);
    break;
  case TestKind::bend:
    result.reaction = on_moves(scene, answer, &Resultant::moment, bending_axis(test));
    result.stiffness = result.reaction / test.angle();
    result.apparent_modulus = result.stiffness * test.length / test.second_moment;
    break;
  case TestKind::indent:
    result.reaction = -on_moves(scene, answer, &Resultant::force, Eigen::Vector3d::Unit(test.axis));
    result.stiffness = result.reaction / displacement;
    if (scene.dimension() == 3)
      result.apparent_modulus = result.stiffness / (2 * test.radius);
    break;
  }
  if (!has_modulus(scene, answer))
    result.apparent_modulus.reset();
  if (test.asks_for_failure)
    if (const auto factor = factor_to_failure(scene, answer))
      result.failure = *factor * result.reaction;
  return result;
}

} // namespace maille
