#include "finite/finite_cell.hpp"

#include <deal.II/base/quadrature_lib.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace maille::fem_ref {

namespace {

/// Indices of the entries of F, by rows, in a scene of `dim` axes.
template<int dim>
constexpr auto entries_of_gradient() {
  std::array<int, dim * dim> entries{};
  for (int i = 0; i < dim * dim; ++i)
    entries[i] = 3 * (i / dim) + i % dim;
  return entries;
}

/// d2J / dF dF, entries by rows.
Eigen::Matrix<double, 9, 9> curvature_of_volume(const Eigen::Matrix3d& F) {
  Eigen::Matrix<double, 9, 9> curvature = Eigen::Matrix<double, 9, 9>::Zero();
  const auto sign = [](int from, int to) { return (to - from + 3) % 3 == 1 ? 1 : -1; };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          if (i != k && j != l)
            curvature(3 * i + j, 3 * k + l) = sign(i, k) * sign(j, l) * F(3 - i - k, 3 - j - l);
  return curvature;
}

} // namespace

template<int dim>
FiniteCell<dim>::FiniteCell(const Element<dim>& element, const Vec3& spacing, PlaneAssumption plane)
    : is_plane_stress_(dim == 2 && plane == PlaneAssumption::stress) {
  const unsigned degree = element.fe().degree;
  const dealii::QGauss<dim> rule(degree + 1);
  const auto n = static_cast<Eigen::Index>(rule.size());
  double volume = 1;
  for (std::size_t a = 0; a < dim; ++a)
    volume *= spacing[a];
  gradients_ = Eigen::MatrixXd::Zero(n_entries * n, element.n_unknowns());
  Eigen::MatrixXd modes(n, degree == 1 ? 1 : 1 + dim); // modes of pressure and theta
  for (Eigen::Index q = 0; q < n; ++q) {
    const dealii::Point<dim>& at = rule.point(static_cast<unsigned>(q));
    weights_.push_back(rule.weight(static_cast<unsigned>(q)) * volume);
    modes(q, 0) = 1;
    for (int a = 0; a < modes.cols() - 1; ++a)
      modes(q, 1 + a) = at[static_cast<unsigned>(a)] - 0.5;
    for (int node = 0; node < element.n_nodes(); ++node) {
      const dealii::Tensor<1, dim> gradient = element.fe().shape_grad(static_cast<unsigned>(node), at);
      for (int c = 0; c < dim; ++c)
        for (int a = 0; a < dim; ++a)
          gradients_(n_entries * q + dim * c + a, dim * node + c) =
              gradient[static_cast<unsigned>(a)] / spacing[a];
    }
  }
  const Eigen::MatrixXd weighted =
      modes.transpose() * Eigen::Map<const Eigen::VectorXd>(weights_.data(), n).asDiagonal();
  projection_ = modes * (weighted * modes).inverse() * weighted;
}

/// Newton's method for zero stress of F13, F23, F33, from an isochoric start; these entries are then
/// condensed out of the response.
template<int dim>
bool FiniteCell<dim>::find_director(const Matter& matter, Eigen::Matrix3d& F, PointResponse& response) const {
  constexpr std::array<int, 3> free{2, 5, 8};
  constexpr int most_steps = 30;
  F(2, 2) = 1 / F.topLeftCorner<2, 2>().determinant();
  for (int step = 0; step < most_steps; ++step) {
    response = respond_at(matter, F, std::nullopt);
    const Eigen::Matrix3d stiffness = response.hessian(free, free);
    const Eigen::Vector3d move = -stiffness.inverse() * response.gradient(free);
    if (!move.allFinite())
      return false;
    if (constexpr double settled = 1e-11; move.norm() < settled * F(2, 2)) {
      const Eigen::Matrix<double, n_point_inputs, 3> coupling = response.hessian(Eigen::all, free);
      response.hessian -= coupling * stiffness.inverse() * coupling.transpose();
      return true;
    }
    const double share = std::min(1.0, move(2) < 0 ? -0.5 * F(2, 2) / move(2) : 1.0); // F33 stays positive
    for (int i = 0; i < 3; ++i)
      F(i, 2) += share * move(i);
  }
  return false;
}

/// Newton step of theta and pressure for the step in u since the last linearisation.
template<int dim>
void FiniteCell<dim>::update(const Eigen::VectorXd& gradient, Fields& fields) const {
  const auto n = static_cast<Eigen::Index>(weights_.size());
  Eigen::VectorXd by_theta(n), dJ(n);
  const Eigen::VectorXd step = gradient - fields.gradient;
  for (Eigen::Index q = 0; q < n; ++q)
    dJ(q) = fields.cofactor.row(q).dot(step.segment(n_entries * q, n_entries));
  const Eigen::VectorXd change = fields.gap + projection_ * dJ;
  for (Eigen::Index q = 0; q < n; ++q)
    by_theta(q) = fields.by_theta(q, n_rows) +
                  fields.by_theta.row(q).head(n_entries).dot(step.segment(n_entries * q, n_entries)) +
                  fields.by_theta(q, n_entries) * change(q);
  fields.theta += change;
  fields.pressure = projection_ * by_theta;
}

template<int dim>
auto FiniteCell<dim>::respond(const Matter& matter, const Eigen::VectorXd& u, Fields& fields) const
    -> std::optional<Response> {
  constexpr auto of_point = entries_of_gradient<dim>();
  const auto n = static_cast<Eigen::Index>(weights_.size());
  const Eigen::VectorXd gradient = gradients_ * u;
  if (fields.theta.size() > 0)
    update(gradient, fields);
  else
    fields = {gradient,
              Eigen::VectorXd::Ones(n),
              Eigen::VectorXd::Zero(n),
              Eigen::VectorXd::Zero(n),
              Eigen::MatrixXd(n, n_entries),
              Eigen::MatrixXd(n, n_rows + 1)};
  fields.gradient = gradient;
  std::vector<Eigen::Matrix3d> F(weights_.size(), Eigen::Matrix3d::Identity());
  Eigen::VectorXd J(n);
  Eigen::MatrixXd volume(n, u.size()); // dJ/du
  for (Eigen::Index q = 0; q < n; ++q) {
    for (int i = 0; i < n_entries; ++i)
      F[q](of_point[i] / 3, of_point[i] % 3) += gradient(n_entries * q + i);
    J(q) = F[q].determinant();
    if (!(J(q) > 0 && (is_plane_stress_ || fields.theta(q) > 0)))
      return std::nullopt;
    const Eigen::Matrix3d cofactor = J(q) * F[q].inverse(); // transposed: read by columns
    fields.cofactor.row(q) = cofactor.reshaped()(of_point).transpose();
    volume.row(q) = fields.cofactor.row(q) * gradients_.middleRows(n_entries * q, n_entries);
  }
  const Eigen::MatrixXd dilatation = projection_ * volume;
  if (!is_plane_stress_)
    fields.gap = projection_ * J - fields.theta;

  std::array<int, n_rows> rows;
  std::ranges::copy(of_point, rows.begin());
  rows.back() = 9;
  Response response;
  Eigen::MatrixXd inputs(n_rows * n, u.size()), outputs(n_rows * n, u.size());
  Eigen::VectorXd stress(n_rows * n);
  for (Eigen::Index q = 0; q < n; ++q) {
    PointResponse point;
    if (!is_plane_stress_)
      point = respond_at(matter, F[q], fields.theta(q));
    else if (!find_director(matter, F[q], point))
      return std::nullopt;
    response.strain_energy += weights_[q] * point.strain_energy;
    Eigen::Matrix<double, n_rows, n_rows> tangent = point.hessian(rows, rows);
    const Eigen::Vector<double, n_rows> of_energy = point.gradient(rows);
    stress.segment(n_rows * q, n_rows) = weights_[q] * (of_energy + fields.gap(q) * tangent.col(n_entries));
    fields.by_theta.row(q) << tangent.row(n_entries), of_energy(n_entries);
    if (!is_plane_stress_)
      tangent.template topLeftCorner<n_entries, n_entries>() +=
          fields.pressure(q) * curvature_of_volume(F[q])(of_point, of_point);
    auto input = inputs.middleRows(n_rows * q, n_rows);
    input.topRows(n_entries) = gradients_.middleRows(n_entries * q, n_entries);
    input.bottomRows(1) = dilatation.row(q); // multiplied by 0 in plane stress
    outputs.middleRows(n_rows * q, n_rows).noalias() = weights_[q] * tangent * input;
  }
  response.force = inputs.transpose() * stress;
  response.stiffness.noalias() = inputs.transpose() * outputs;
  if (!std::isfinite(response.strain_energy) || !response.stiffness.allFinite())
    return std::nullopt;
  return response;
}

template<int dim>
std::array<double, 6> FiniteCell<dim>::mean_strain(const Fields& fields) const {
  constexpr auto of_point = entries_of_gradient<dim>();
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  double theta = 0, all = 0;
  for (const double weight : weights_)
    all += weight;
  for (std::size_t q = 0; q < weights_.size(); ++q) {
    const double part = weights_[q] / all;
    theta += part * fields.theta(Eigen::Index(q));
    for (int i = 0; i < n_entries; ++i)
      F(of_point[i] / 3, of_point[i] % 3) += part * fields.gradient(n_entries * Eigen::Index(q) + i);
  }
  Eigen::Matrix3d U = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(F.transpose() * F).operatorSqrt();
  if (!is_plane_stress_)
    U.topLeftCorner<dim, dim>() *= std::pow(theta / U.determinant(), 1.0 / dim);
  return {U(0, 0) - 1, U(1, 1) - 1, U(2, 2) - 1, U(0, 1), U(1, 2), U(0, 2)};
}

template class FiniteCell<2>;
template class FiniteCell<3>;

} // namespace maille::fem_ref
