#include "discretization/element.hpp"

#include <Eigen/LU>
#include <cmath>
#include <deal.II/base/quadrature_lib.h>
#include <stdexcept>

namespace maille::fem_ref {

template<int dim>
Eigen::MatrixXd strain_matrix(const Eigen::MatrixXd& gradients) {
  constexpr int shears[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(dim * (dim + 1) / 2, dim * gradients.rows());
  for (Eigen::Index node = 0; node < gradients.rows(); ++node) {
    for (int a = 0; a < dim; ++a)
      B(a, dim * node + a) = gradients(node, a);
    for (int row = dim; row < B.rows(); ++row) {
      const auto& [a, b] = shears[dim == 2 ? 2 : row - 3];
      B(row, dim * node + a) = gradients(node, b);
      B(row, dim * node + b) = gradients(node, a);
    }
  }
  return B;
}

namespace {

template<int dim>
Eigen::MatrixXd unit_gradients(const Element<dim>& element, const dealii::Point<dim>& point) {
  Eigen::MatrixXd gradients(element.n_nodes(), dim);
  for (int i = 0; i < element.n_nodes(); ++i) {
    const dealii::Tensor<1, dim> gradient = element.fe().shape_grad(static_cast<unsigned>(i), point);
    for (unsigned a = 0; a < dim; ++a)
      gradients(i, a) = gradient[a];
  }
  return gradients;
}

template<int dim>
Gradients<dim> gradients_at(const Element<dim>& element, const Eigen::MatrixXd& positions,
                            const dealii::Point<dim>& point) {
  const Eigen::MatrixXd unit = unit_gradients(element, point);
  const Eigen::Matrix<double, dim, dim> jacobian = positions.transpose() * unit; // [position][unit axis]
  Gradients<dim> gradients;
  gradients.volume = jacobian.determinant();
  gradients.of_shape = unit * jacobian.inverse();
  return gradients;
}

} // namespace

template<int dim>
Gradients<dim> gradients_at(const Element<dim>& element, const Eigen::MatrixXd& positions,
                            const Vec3& unit_point) {
  dealii::Point<dim> point;
  for (unsigned a = 0; a < dim; ++a)
    point[a] = unit_point[a];
  return gradients_at(element, positions, point);
}

template<int dim>
MappedCell<dim>::MappedCell(const Element<dim>& element, const Eigen::MatrixXd& positions)
    : element_(element), positions_(positions) {
  for (int corner = 0; corner < (1 << dim); ++corner) {
    const Vec3 at{static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
                  static_cast<double>(corner >> 2 & 1)};
    if (!(gradients_at(element, positions, at).volume > 0))
      throw std::invalid_argument("the shape turns a cell inside out");
  }
}

template<int dim>
Eigen::MatrixXd MappedCell<dim>::stiffness(const Eigen::MatrixXd& C) const {
  const dealii::QGauss<dim> rule(element_.fe().degree + 2);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(element_.n_unknowns(), element_.n_unknowns());
  for (unsigned q = 0; q < rule.size(); ++q) {
    const Gradients<dim> gradients = gradients_at(element_, positions_, rule.point(q));
    const Eigen::MatrixXd B = strain_matrix<dim>(gradients.of_shape);
    K += rule.weight(q) * gradients.volume * (B.transpose() * C * B);
  }
  return 0.5 * (K + K.transpose()); // exactly symmetric, as callers expect
}

template<int dim>
Eigen::VectorXd MappedCell<dim>::volume_load() const {
  const dealii::QGauss<dim> rule(element_.fe().degree + 2);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(element_.n_nodes());
  for (unsigned q = 0; q < rule.size(); ++q) {
    const double weight = rule.weight(q) * gradients_at(element_, positions_, rule.point(q)).volume;
    for (int i = 0; i < element_.n_nodes(); ++i)
      load[i] += weight * element_.fe().shape_value(static_cast<unsigned>(i), rule.point(q));
  }
  return load;
}

template<int dim>
Eigen::MatrixXd MappedCell<dim>::stress_load() const {
  const dealii::QGauss<dim> rule(element_.fe().degree + 2);
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(element_.n_unknowns(), Element<dim>::n_strains);
  for (unsigned q = 0; q < rule.size(); ++q) {
    const Gradients<dim> gradients = gradients_at(element_, positions_, rule.point(q));
    load += rule.weight(q) * gradients.volume * strain_matrix<dim>(gradients.of_shape).transpose();
  }
  return load;
}

/// The area of a face is that of the parallelepiped of its tangents: the root of their Gram determinant.
template<int dim>
Eigen::VectorXd MappedCell<dim>::face_load(int axis, bool upper) const {
  const dealii::QGauss<dim> rule(element_.fe().degree +
                                 2); // the points along the axis collapse; their weights sum to one
  Eigen::VectorXd load = Eigen::VectorXd::Zero(element_.n_nodes());
  for (unsigned q = 0; q < rule.size(); ++q) {
    dealii::Point<dim> point = rule.point(q);
    point[static_cast<unsigned>(axis)] = upper ? 1 : 0;
    const Eigen::Matrix<double, dim, dim> jacobian = positions_.transpose() * unit_gradients(element_, point);
    Eigen::Matrix<double, dim, Eigen::Dynamic> tangents(dim, dim - 1);
    for (int a = 0, column = 0; a < dim; ++a)
      if (a != axis)
        tangents.col(column++) = jacobian.col(a);
    const Eigen::MatrixXd gram = tangents.transpose() * tangents;
    const double area = dim == 1 ? 1 : std::sqrt(gram.determinant());
    for (int i = 0; i < element_.n_nodes(); ++i)
      load[i] += area * rule.weight(q) * element_.fe().shape_value(static_cast<unsigned>(i), point);
  }
  return load;
}

template class MappedCell<1>;
template class MappedCell<2>;
template class MappedCell<3>;
template Gradients<1> gradients_at(const Element<1>&, const Eigen::MatrixXd&, const Vec3&);
template Gradients<2> gradients_at(const Element<2>&, const Eigen::MatrixXd&, const Vec3&);
template Gradients<3> gradients_at(const Element<3>&, const Eigen::MatrixXd&, const Vec3&);
template Eigen::MatrixXd strain_matrix<1>(const Eigen::MatrixXd&);
template Eigen::MatrixXd strain_matrix<2>(const Eigen::MatrixXd&);
template Eigen::MatrixXd strain_matrix<3>(const Eigen::MatrixXd&);

} // namespace maille::fem_ref
