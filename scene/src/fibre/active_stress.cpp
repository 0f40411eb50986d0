/// What contracting fibres do to the matter around them.

#include "free_directions.hpp"
#include "maille/scene/scene.hpp"

namespace maille {

Eigen::Matrix<double, 6, 1> Scene::object_active_stress(std::int64_t cell) const {
  if (!contracts())
    return Vector6::Zero();
  const Vec3 a = specimen.fibre_of(cell);
  Vector6 stress;
  stress << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[1] * a[2], a[0] * a[2], a[0] * a[1];
  return active_stress[static_cast<std::size_t>(cell)] * stress;
}

Eigen::VectorXd Scene::cell_active_stress(std::int64_t cell) const {
  Vector6 stress = object_active_stress(cell);
  if (dimension() == 3)
    return stress;
  if (stress.isZero(0))
    return Eigen::VectorXd::Zero(dimension() == 2 ? 3 : 1);
  // What is free gives way to it, and by that pulls at the directions that the scene knows.
  Vector6 strain = Vector6::Zero();
  const Matrix6 C = object_stiffness(cell);
  release_free_directions(C, stress, dimension(), plane, strain);
  stress += C * strain;
  if (dimension() == 1)
    return stress.head<1>();
  return Eigen::Vector3d(stress(0), stress(1), stress(5));
}

} // namespace maille
