#include "maille/scene/cell_fields.hpp"

#include "maille/materials/elasticity.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"

#include <Eigen/Eigenvalues>

#include <array>
#include <cmath>
#include <cstdint>

namespace maille {

namespace {

/// Voigt strain with engineering shear, 11 22 33 23 13 12.
Vector6 voigt_strain(const Eigen::Matrix3d& g) {
  Vector6 strain;
  strain << g(0, 0), g(1, 1), g(2, 2), g(1, 2) + g(2, 1), g(0, 2) + g(2, 0), g(0, 1) + g(1, 0);
  return strain;
}

/// Reorders Voigt 11 22 33 23 13 12 to XX YY ZZ XY YZ XZ.
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

FieldsOfCells::FieldsOfCells(const Scene& scene, const Displacement& displacement)
    : scene_(scene), displacement_(&displacement), known_(scene.materials.size()) {
  if (in_blocks(scene))
    rotation_ = block_rotations(scene, displacement);
  else if (const Frame frame = object_frame(scene); frame.is_turned)
    to_object(scene, frame, turned_back_.emplace(displacement));
}

FieldsOfCells::FieldsOfCells(const Scene& scene, const std::vector<std::array<double, 6>>& strain)
    : scene_(scene), strain_(&strain), known_(scene.materials.size()) {}

FieldsOfCells::FieldsOfCells(const Scene& scene, const Answer& answer)
    : FieldsOfCells(answer.cell_strain.empty() ? FieldsOfCells(scene, answer.displacement)
                                               : FieldsOfCells(scene, answer.cell_strain)) {}

Vector6 FieldsOfCells::strain_of(std::int64_t cell) const {
  if (strain_ != nullptr) {
    const auto& e = (*strain_)[cell];
    Vector6 strain;
    strain << e[0], e[1], e[2], 2 * e[4], 2 * e[5], 2 * e[3];
    return strain;
  }
  const Grid& grid = scene_.specimen.grid;
  Eigen::Matrix3d gradient =
      displacement_gradient(grid, turned_back_ ? *turned_back_ : *displacement_, grid.cell_at(cell));
  if (!rotation_.empty())
    gradient = rotation_[cell].toRotationMatrix().transpose() * (Eigen::Matrix3d::Identity() + gradient) -
               Eigen::Matrix3d::Identity();
  return voigt_strain(gradient);
}

FieldsOfCells::Values FieldsOfCells::operator()(std::int64_t cell) {
  const Specimen& body = scene_.specimen;
  // With one fibre direction a material has one stiffness in the object's frame.
  auto& kept = known_[body.material(cell)];
  if (!kept || !body.fibres.empty() || !body.stiffness_ratio.empty())
    kept = scene_.object_stiffness(cell);
  const Vector6 active = scene_.object_active_stress(cell);
  if (scene_.strain == Strain::finite)
    return at_finite_strain(cell, *kept);
  Vector6 strain = strain_of(cell);
  release_free_directions(*kept, active, scene_.dimension(), scene_.plane, strain);
  const Vector6 stress = *kept * strain + active;
  return {in_order_of_vtk(strain, 0.5), in_order_of_vtk(stress, 1), von_mises(stress)};
}

/// Cauchy stress in the cell's frame is U S U / J; free strains follow from E = (U^2 - I) / 2.
FieldsOfCells::Values FieldsOfCells::at_finite_strain(std::int64_t cell, const Matrix6& stiffness) const {
  using Eigen::Matrix3d;
  const Specimen& body = scene_.specimen;
  const Matrix3d biot = as_strain(strain_of(cell));
  Matrix3d E = biot + 0.5 * biot * biot;
  const Vec3 fibre = body.fibre_of(cell);
  double active = 0;
  const LawResponse response = respond({scene_.materials[body.material(cell)],
                                        stiffness,
                                        {fibre[0], fibre[1], fibre[2]},
                                        scene_.active_stress.empty() ? 0 : scene_.active_stress[cell]},
                                       scene_.dimension(), scene_.plane, E, active);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(E);
  const Eigen::Vector3d stretch = (1 + 2 * principal.eigenvalues().array()).sqrt();
  const Matrix3d &Q = principal.eigenvectors(), U = Q * stretch.asDiagonal() * Q.transpose();
  const Vector6 stress = maille::stress_of(U * as_stress(response.stress) * U / stretch.prod());
  return {in_order_of_vtk(maille::strain_of(U - Matrix3d::Identity()), 0.5), in_order_of_vtk(stress, 1),
          von_mises(stress)};
}

namespace {

CellFields all_of(const Scene& scene, FieldsOfCells of) {
  const auto n = static_cast<std::size_t>(scene.specimen.grid.n_cells());
  CellFields fields{std::vector<std::array<double, 6>>(n), std::vector<std::array<double, 6>>(n),
                    std::vector<double>(n)};
  for (std::size_t c = 0; c < n; ++c)
    if (const auto cell = static_cast<std::int64_t>(c); scene.specimen.is_matter(cell)) {
      const FieldsOfCells::Values values = of(cell);
      fields.strain[c] = values.strain;
      fields.stress[c] = values.stress;
      fields.von_mises[c] = values.von_mises;
    }
  return fields;
}

} // namespace

CellFields cell_fields(const Scene& scene, const Displacement& displacement) {
  return all_of(scene, FieldsOfCells(scene, displacement));
}

CellFields cell_fields(const Scene& scene, const std::vector<std::array<double, 6>>& strain) {
  return all_of(scene, FieldsOfCells(scene, strain));
}

CellFields cell_fields(const Scene& scene, const Answer& answer) {
  return all_of(scene, FieldsOfCells(scene, answer));
}

double along(const std::array<double, 6>& t, const Vec3& a) {
  return t[0] * a[0] * a[0] + t[1] * a[1] * a[1] + t[2] * a[2] * a[2] +
         2 * (t[3] * a[0] * a[1] + t[4] * a[1] * a[2] + t[5] * a[0] * a[2]);
}

namespace {

Eigen::Matrix3d matrix_of(const std::array<double, 6>& t) {
  Eigen::Matrix3d matrix;
  matrix << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  return matrix;
}

std::array<double, 6> tensor_of(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2)};
}

} // namespace

std::array<double, 6> green_lagrange(const std::array<double, 6>& strain) {
  const Eigen::Matrix3d biot = matrix_of(strain);
  return tensor_of(biot + 0.5 * biot * biot);
}

std::array<double, 6> logarithmic(const std::array<double, 6>& strain) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(matrix_of(strain));
  const Eigen::Matrix3d& Q = principal.eigenvectors();
  return tensor_of(Q * principal.eigenvalues().array().log1p().matrix().asDiagonal() * Q.transpose());
}

std::array<double, 6> nominal(const std::array<double, 6>& strain, const std::array<double, 6>& stress) {
  const Eigen::Matrix3d U = Eigen::Matrix3d::Identity() + matrix_of(strain),
                        product = U.determinant() * matrix_of(stress) * U.inverse();
  return tensor_of(0.5 * (product + product.transpose()));
}

Vec3 principal_values(const std::array<double, 6>& t) {
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix_of(t), Eigen::EigenvaluesOnly).eigenvalues();
  return {values[2], values[1], values[0]};
}

double largest_principal(const std::array<double, 6>& tensor) {
  const Vec3 values = principal_values(tensor);
  return std::max(std::abs(values[0]), std::abs(values[2]));
}

std::vector<float> lengths_of_cells(const Specimen& body, const Displacement& displacement) {
  const Grid& grid = body.grid;
  std::vector<float> lengths(grid.n_cells(), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    Vec3 mean{};
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const Vec3 u = displacement.at(grid.corner(grid.cell_at(cell), corner));
      for (std::size_t a = 0; a < 3; ++a)
        mean[a] += u[a] / grid.corners_per_cell();
    }
    lengths[cell] = static_cast<float>(std::hypot(mean[0], mean[1], mean[2]));
  }
  return lengths;
}

} // namespace maille
