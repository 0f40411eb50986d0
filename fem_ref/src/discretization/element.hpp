#pragma once
/// The element shared by all cells of a scene, and integrals over cells whose nodes are displaced from the
/// grid (isoparametric).

#include "maille/base/grid.hpp"

#include <Eigen/Core>
#include <deal.II/fe/fe_q.h>
#include <vector>

namespace maille::fem_ref {

/// Values of all shape functions at the points of a quadrature on the cell.
struct Samples {
  std::vector<Vec3> points;    ///< from the cell's lower corner [m]
  std::vector<double> weights; ///< quadrature weight times volume [m^dim]
  Eigen::MatrixXd shape;       ///< points x nodes
};

/// FE_Q of degree 1 or 2 on a cell of given spacing. All cells of a scene are congruent, so each integral
/// over the cell is computed once.
template<int dim>
class Element {
public:
  static constexpr int n_strains = dim * (dim + 1) / 2;

  Element(int degree, const Vec3& spacing);

  const dealii::FE_Q<dim>& fe() const { return fe_; }
  int n_nodes() const { return static_cast<int>(fe_.n_dofs_per_cell()); }
  int n_unknowns() const { return dim * n_nodes(); }
  /// Place of a node in its cell: 0 ... degree along every axis.
  const Index3& place(int node) const { return places_[node]; }
  /// Offset of a node from the cell's lower corner [m].
  Vec3 offset(int node) const;
  /// Corners whose mean position is the node: the node itself, or the corners of its edge, face or cell.
  /// Corner numbers are those of Grid::corner; corner nodes come first, in the same order.
  const std::vector<int>& parents(int node) const { return parents_[node]; }

  /// Integral of B^T C B over the cell [N/m in 3D], rows and columns dim * node + component.
  ///
  /// The integral is linear in the 1, 6 or 21 entries of C: K = sum of C_ab K_ab. The K_ab are computed once
  /// by a Gauss rule of degree + 1 points per axis, which is exact here. One product of a tall matrix and a
  /// short vector then gives K for any fibre direction.
  /// @param stiffness n_strains x n_strains, symmetric, engineering shear
  void stiffness(const Eigen::MatrixXd& stiffness, double* row_major) const;

  /// Integral of every shape function over the cell, and over one of its faces.
  const Eigen::VectorXd& volume_load() const { return volume_load_; }
  const Eigen::VectorXd& face_load(int axis, bool upper) const { return face_load_[2 * axis + upper]; }
  /// Integral of B^T over the cell, n_unknowns x n_strains. Times a stress: the nodal forces in balance with
  /// that stress.
  const Eigen::MatrixXd& stress_load() const { return stress_load_; }
  /// Shape functions at the points of a Gauss rule of `points` points per axis.
  Samples samples(int points) const;

private:
  void make_stiffness_basis();
  void make_loads();

  dealii::FE_Q<dim> fe_;
  Vec3 spacing_;
  std::vector<Index3> places_;
  std::vector<std::vector<int>> parents_;
  Eigen::MatrixXd basis_; ///< n_unknowns^2 x number of entries of C on and above the diagonal, by rows
  Eigen::MatrixXd stress_load_;
  Eigen::VectorXd volume_load_;
  std::vector<Eigen::VectorXd> face_load_;
};

/// An isoparametric cell: its shape functions map the unit cell by the node positions. Gauss rules of degree
/// + 2 points per axis.
/// Source  Zienkiewicz and Taylor (2000), chapter 9
template<int dim>
class MappedCell {
public:
  /// @param positions  nodes x dim [m]; must outlive this
  /// @throws std::invalid_argument  the cell is inverted
  MappedCell(const Element<dim>& element, const Eigen::MatrixXd& positions);

  /// As Element::stiffness, row or column major.
  Eigen::MatrixXd stiffness(const Eigen::MatrixXd& C) const;
  Eigen::VectorXd volume_load() const;
  Eigen::MatrixXd stress_load() const;
  Eigen::VectorXd face_load(int axis, bool upper) const;

private:
  const Element<dim>& element_;
  const Eigen::MatrixXd& positions_;
};

/// Gradients of the shape functions at a point of the unit cell, nodes x dim [1/m], and the ratio of the cell
/// volume to the unit cell there.
template<int dim>
struct Gradients {
  Eigen::MatrixXd of_shape;
  double volume = 0;
};
template<int dim>
Gradients<dim> gradients_at(const Element<dim>& element, const Eigen::MatrixXd& positions,
                            const Vec3& unit_point);

/// Matrix from nodal displacements to the strain of a cell, in the scene's order; columns dim * node +
/// component.
template<int dim>
Eigen::MatrixXd strain_matrix(const Eigen::MatrixXd& gradients);

} // namespace maille::fem_ref
