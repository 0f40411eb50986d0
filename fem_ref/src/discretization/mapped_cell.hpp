#pragma once
/// Integrals over a cell whose nodes stand elsewhere than the grid has them.

#include "discretization/element.hpp"

namespace maille::fem_ref {

/// An isoparametric cell: its shape functions, applied to its nodes' positions, say where its points are.
/// Gauss rules of degree + 2 points per axis.
/// Source  Zienkiewicz and Taylor (2000), chapter 9
template<int dim>
class MappedCell {
public:
  /// @param positions  nodes x dim [m]; must outlive this
  /// @throws std::invalid_argument  the cell is turned inside out
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

/// Gradients of the shape functions at a point of the unit cell, nodes x dim [1/m], and the volume there over
/// that of the unit cell.
template<int dim>
struct Gradients {
  Eigen::MatrixXd of_shape;
  double volume = 0;
};
template<int dim>
Gradients<dim> gradients_at(const Element<dim>& element, const Eigen::MatrixXd& positions,
                            const Vec3& unit_point);

/// The strain of a cell from its nodes' displacements, in the scene's order; columns dim * node + component.
template<int dim>
Eigen::MatrixXd strain_matrix(const Eigen::MatrixXd& gradients);

} // namespace maille::fem_ref
