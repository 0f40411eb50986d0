#include "discretization/element.hpp"

#include <deal.II/base/quadrature_lib.h>

namespace maille::fem_ref {

template<int dim>
Element<dim>::Element(int degree, const Vec3& spacing)
    : fe_(static_cast<unsigned>(degree)), spacing_(spacing) {
  for (int i = 0; i < n_nodes(); ++i) {
    const dealii::Point<dim>& at = fe_.unit_support_point(static_cast<unsigned>(i));
    Index3 place{0, 0, 0};
    for (unsigned a = 0; a < dim; ++a)
      place[a] = static_cast<int>(std::lround(degree * at[a]));
    places_.push_back(place);
    std::vector<int> parents;
    for (int corner = 0; corner < (1 << dim); ++corner) {
      bool is_parent = true;
      for (std::size_t a = 0; a < dim; ++a) {
        const int side = degree * ((corner >> a) & 1);
        const bool in_the_middle = place[a] != 0 && place[a] != degree;
        is_parent = is_parent && (in_the_middle || place[a] == side);
      }
      if (is_parent)
        parents.push_back(corner);
    }
    parents_.push_back(std::move(parents));
  }
  make_stiffness_basis();
  make_loads();
}

template<int dim>
Vec3 Element<dim>::offset(int node) const {
  Vec3 x{0, 0, 0};
  for (std::size_t a = 0; a < dim; ++a)
    x[a] = spacing_[a] * place(node)[a] / fe_.degree;
  return x;
}

template<int dim>
void Element<dim>::make_stiffness_basis() {
  const dealii::QGauss<dim> rule(fe_.degree + 1);
  double volume = 1;
  for (std::size_t a = 0; a < dim; ++a)
    volume *= spacing_[a];
  const Eigen::Index n = n_unknowns();
  basis_ = Eigen::MatrixXd::Zero(n * n, n_strains * (n_strains + 1) / 2);
  stress_load_ = Eigen::MatrixXd::Zero(n, n_strains);
  for (unsigned q = 0; q < rule.size(); ++q) {
    Eigen::MatrixXd gradients(n_nodes(), dim);
    for (int i = 0; i < n_nodes(); ++i) {
      const dealii::Tensor<1, dim> gradient = fe_.shape_grad(static_cast<unsigned>(i), rule.point(q));
      for (unsigned a = 0; a < dim; ++a)
        gradients(i, a) = gradient[a] / spacing_[a];
    }
    const Eigen::MatrixXd B = strain_matrix<dim>(gradients);
    stress_load_ += rule.weight(q) * volume * B.transpose();
    Eigen::Index column = 0;
    for (int a = 0; a < n_strains; ++a)
      for (int b = a; b < n_strains; ++b, ++column) {
        Eigen::Map<Eigen::MatrixXd> K(basis_.col(column).data(), n, n);
        const double weight = rule.weight(q) * volume;
        K += weight * B.row(a).transpose() * B.row(b);
        if (a != b)
          K += weight * B.row(b).transpose() * B.row(a);
      }
  }
}

template<int dim>
void Element<dim>::make_loads() {
  const Samples inside = samples(static_cast<int>(fe_.degree) + 1);
  volume_load_ = inside.shape.transpose() *
                 Eigen::Map<const Eigen::VectorXd>(inside.weights.data(), inside.shape.rows());
  for (unsigned axis = 0; axis < dim; ++axis)
    for (const double side : {0.0, 1.0}) {
      Eigen::VectorXd load = Eigen::VectorXd::Zero(n_nodes());
      // A face is the cell with one axis collapsed: the cell's rule, with that axis's weights summing to one.
      const dealii::QGauss<dim> rule(fe_.degree + 1);
      double area = 1;
      for (std::size_t a = 0; a < dim; ++a)
        area *= a == axis ? 1.0 : spacing_[a];
      for (unsigned q = 0; q < rule.size(); ++q) {
        dealii::Point<dim> point = rule.point(q);
        point[axis] = side;
        for (int i = 0; i < n_nodes(); ++i)
          load[i] += area * rule.weight(q) * fe_.shape_value(static_cast<unsigned>(i), point);
      }
      face_load_.push_back(std::move(load));
    }
}

template<int dim>
Samples Element<dim>::samples(int points) const {
  const dealii::QGauss<dim> rule(static_cast<unsigned>(points));
  double volume = 1;
  for (std::size_t a = 0; a < dim; ++a)
    volume *= spacing_[a];
  Samples samples;
  samples.shape.resize(rule.size(), n_nodes());
  for (unsigned q = 0; q < rule.size(); ++q) {
    Vec3 point{0, 0, 0};
    for (unsigned a = 0; a < dim; ++a)
      point[a] = spacing_[a] * rule.point(q)[a];
    samples.points.push_back(point);
    samples.weights.push_back(rule.weight(q) * volume);
    for (int i = 0; i < n_nodes(); ++i)
      samples.shape(q, i) = fe_.shape_value(static_cast<unsigned>(i), rule.point(q));
  }
  return samples;
}

template<int dim>
void Element<dim>::stiffness(const Eigen::MatrixXd& stiffness, double* row_major) const {
  Eigen::Matrix<double, n_strains*(n_strains + 1) / 2, 1> entries;
  Eigen::Index k = 0;
  for (int a = 0; a < n_strains; ++a)
    for (int b = a; b < n_strains; ++b, ++k)
      entries[k] = stiffness(a, b);
  // Row and column major are the same: the matrix is symmetric.
  Eigen::Map<Eigen::VectorXd>(row_major, basis_.rows()).noalias() = basis_ * entries;
}

template class Element<1>;
template class Element<2>;
template class Element<3>;

} // namespace maille::fem_ref
