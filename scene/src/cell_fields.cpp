#include "maille/scene/cell_fields.hpp"

#include "maille/materials/elasticity.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"

#include <Eigen/Eigenvalues>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace maille {

namespace {

/// Voigt strain with engineering shear, 11 22 33 23 13 12.
Vector6 voigt_strain(const Eigen::Matrix3d& g) {
  Vector6 strain;
  strain << g(0, 0), g(1, 1), g(2, 2), g(1, 2) + g(2, 1), g(0, 2) + g(2, 0), g(0, 1) + g(1, 0);
  return strain;
}

/// Voigt 11 22 33 23 13 12 becomes XX YY ZZ XY YZ XZ.
std::array<double, 6> in_order_of_vtk(const Vector6& v, double shear) {
  return {v(0), v(1), v(2), shear * v(5), shear * v(3), shear * v(4)};
}

double von_mises(const Vector6& s) {
  const double normal =
      (s(0) - s(1)) * (s(0) - s(1)) + (s(1) - s(2)) * (s(1) - s(2)) + (s(2) - s(0)) * (s(2) - s(0));
  const double shear = s(3) * s(3) + s(4) * s(4) + s(5) * s(5);
  return std::sqrt(0.5 * normal + 3 * shear);
}

} // namespace

StrainAndStress::StrainAndStress(const Scene& scene, std::int64_t cell)
    : stiffness_(scene.object_stiffness(cell)), active_(scene.object_active_stress(cell)),
      dimension_(scene.dimension()), plane_(scene.plane) {}

std::pair<std::array<double, 6>, std::array<double, 6>>
StrainAndStress::operator()(const Eigen::VectorXd& given) const {
  Vector6 strain = Vector6::Zero();
  if (dimension_ == 3)
    strain = given;
  else if (dimension_ == 2)
    strain << given(0), given(1), 0, 0, 0, given(2);
  else
    strain(0) = given(0);
  release_free_directions(stiffness_, active_, dimension_, plane_, strain);
  return {in_order_of_vtk(strain, 0.5), in_order_of_vtk(stiffness_ * strain + active_, 1)};
}

namespace {

/// Fills the fields of cells from their strains, one after another.
class FieldsOfCells {
public:
  explicit FieldsOfCells(const Scene& scene) : scene_(scene), known_(scene.materials.size()) {
    const auto n = static_cast<std::size_t>(scene.specimen.grid.n_cells());
    fields_ = {std::vector<std::array<double, 6>>(n), std::vector<std::array<double, 6>>(n),
               std::vector<double>(n)};
  }
  void add(std::int64_t cell, Vector6 strain) {
    const Specimen& body = scene_.specimen;
    // With one fibre direction a material has one stiffness in the object's frame.
    auto& kept = known_[body.material(cell)];
    if (!kept || !body.fibres.empty() || !body.stiffness_ratio.empty())
      kept = scene_.object_stiffness(cell);
    const auto c = static_cast<std::size_t>(cell);
    const Vector6 active = scene_.object_active_stress(cell);
    release_free_directions(*kept, active, scene_.dimension(), scene_.plane, strain);
    const Vector6 stress = *kept * strain + active;
    fields_.strain[c] = in_order_of_vtk(strain, 0.5);
    fields_.stress[c] = in_order_of_vtk(stress, 1);
    fields_.von_mises[c] = von_mises(stress);
  }
  CellFields take() { return std::move(fields_); }

private:
  const Scene& scene_;
  std::vector<std::optional<Matrix6>> known_;
  CellFields fields_;
};

} // namespace

CellFields cell_fields(const Scene& scene, const Displacement& in_world) {
  Displacement turned_back;
  const Frame frame = in_blocks(scene) ? Frame{} : object_frame(scene);
  if (frame.is_turned)
    to_object(scene, frame, turned_back = in_world);
  const Displacement& displacement = frame.is_turned ? turned_back : in_world;
  const List<Eigen::Quaterniond> rotation =
      in_blocks(scene) ? block_rotations(scene, in_world) : List<Eigen::Quaterniond>{};
  const Grid& grid = scene.specimen.grid;
  FieldsOfCells fields(scene);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    Eigen::Matrix3d gradient = displacement_gradient(grid, displacement, grid.cell_at(cell));
    if (!rotation.empty())
      gradient = rotation[static_cast<std::size_t>(cell)].toRotationMatrix().transpose() *
                     (Eigen::Matrix3d::Identity() + gradient) -
                 Eigen::Matrix3d::Identity();
    fields.add(cell, voigt_strain(gradient));
  }
  return fields.take();
}

CellFields cell_fields(const Scene& scene, const Answer& answer) {
  return answer.cell_strain.empty() ? cell_fields(scene, answer.displacement)
                                    : cell_fields(scene, answer.cell_strain);
}

CellFields cell_fields(const Scene& scene, const std::vector<std::array<double, 6>>& strains) {
  FieldsOfCells fields(scene);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const auto& e = strains[static_cast<std::size_t>(cell)];
    Vector6 strain;
    strain << e[0], e[1], e[2], 2 * e[4], 2 * e[5], 2 * e[3];
    fields.add(cell, strain);
  }
  return fields.take();
}

double along(const std::array<double, 6>& t, const Vec3& a) {
  return t[0] * a[0] * a[0] + t[1] * a[1] * a[1] + t[2] * a[2] * a[2] +
         2 * (t[3] * a[0] * a[1] + t[4] * a[1] * a[2] + t[5] * a[0] * a[2]);
}

Vec3 principal_values(const std::array<double, 6>& t) {
  Eigen::Matrix3d matrix;
  matrix << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[2], values[1], values[0]};
}

} // namespace maille
