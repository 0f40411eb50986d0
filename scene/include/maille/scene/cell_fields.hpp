#pragma once
/// Strain and stress at the centres of cells, by one formula for every method.
///
/// The strain is that of the cell's mean displacement gradient (one integration point); the stress is the
/// material's law of it plus active stress. Stored strains (Answer::cell_strain) are used if the method
/// provides them. Exact for linear displacements; first order in the spacing at curved borders.

#include "maille/scene/answer.hpp"

#include <Eigen/Geometry>

#include <optional>
#include <utility>
#include <vector>

namespace maille {

/// Per cell of the grid, in the object's frame (see object_frame); at finite strain in the cell's own frame
/// (see block_rotations), with Biot's strain U - I and Cauchy stress. Mean strain of the cell (one-point,
/// from its corner displacements), and its stress: stiffness times strain plus the active stress of its
/// fibre. Six components in VTK's order XX YY ZZ XY YZ XZ; shear strains are tensor components (half of the
/// engineering shear). Zero in cells without matter. In plane strain the out-of-plane stress is included; in
/// plane stress and 1D the free lateral strains are.
struct CellFields {
  std::vector<std::array<double, 6>> strain;
  std::vector<std::array<double, 6>> stress; ///< [Pa]
  std::vector<double> von_mises;             ///< [Pa]
};

/// Maps a strain in the scene's dimension to all six components of strain and stress, for one cell's matter.
class StrainAndStress {
public:
  StrainAndStress(const Scene& scene, std::int64_t cell);
  /// @param strain  of the scene's dimension, engineering shear: 11; 11 22 12; or 11 22 33 23 13 12
  /// @return strain and stress as in CellFields
  std::pair<std::array<double, 6>, std::array<double, 6>> operator()(const Eigen::VectorXd& strain) const;

private:
  Matrix6 stiffness_;
  Eigen::Matrix<double, 6, 1> active_;
  int dimension_;
  PlaneAssumption plane_;
};

/// The same for one cell at a time: for large bodies, the fields of all cells do not fit in memory.
class FieldsOfCells {
public:
  struct Values {
    std::array<double, 6> strain{}, stress{};
    double von_mises = 0;
  };

  /// The arguments must outlive this.
  FieldsOfCells(const Scene& scene, const Displacement& displacement);
  FieldsOfCells(const Scene& scene, const std::vector<std::array<double, 6>>& strain);
  FieldsOfCells(const Scene& scene, const Answer& answer);
  /// @pre the cell holds matter
  Values operator()(std::int64_t cell);

private:
  Vector6 strain_of(std::int64_t cell) const;
  Values at_finite_strain(std::int64_t cell, const Matrix6& stiffness) const;

  const Scene& scene_;
  const std::vector<std::array<double, 6>>* strain_ = nullptr;
  const Displacement* displacement_ = nullptr;
  std::optional<Displacement> turned_back_; ///< in the object's frame, if that is turned
  List<Eigen::Quaterniond> rotation_;
  std::vector<std::optional<Matrix6>> known_; ///< stiffnesses of materials
};

CellFields cell_fields(const Scene& scene, const Displacement& displacement);
/// The same from strains of cells, in the form of Answer::cell_strain.
CellFields cell_fields(const Scene& scene, const std::vector<std::array<double, 6>>& strain);
/// From Answer::cell_strain if the answer has it, else from its displacement.
CellFields cell_fields(const Scene& scene, const Answer& answer);

/// Other measures of finite strain, in the same frame, from those of CellFields: Green-Lagrange strain (U^2 -
/// I) / 2, logarithmic strain ln U, and nominal stress J (s U^-1 + U^-1 s) / 2 per area at rest (the
/// symmetric part of R^T P, Biot's stress), which is work-conjugate to U - I.
std::array<double, 6> green_lagrange(const std::array<double, 6>& strain);
std::array<double, 6> logarithmic(const std::array<double, 6>& strain);
std::array<double, 6> nominal(const std::array<double, 6>& strain, const std::array<double, 6>& stress);

/// a T a of a tensor in the same order: the strain or stress along a direction.
double along(const std::array<double, 6>& tensor, const Vec3& direction);
/// Eigenvalues of a tensor, largest first.
Vec3 principal_values(const std::array<double, 6>& tensor);
/// The size of the principal value of largest size.
double largest_principal(const std::array<double, 6>& tensor);

/// The length of each cell's mean displacement [m]; 0 without matter.
std::vector<float> lengths_of_cells(const Specimen& body, const Displacement& displacement);

} // namespace maille
