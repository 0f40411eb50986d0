#include "elastic/multigrid/coarsest_solve.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace maille::deform {

namespace {

/// Inverse on the modes whose eigenvalue exceeds `least` of the largest one; zero on the others.
Eigen::MatrixXd inverse_of_modes(const Eigen::MatrixXd& K, double least) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(K);
  const double smallest = least * modes.eigenvalues()(K.rows() - 1);
  const Eigen::VectorXd inverted =
      modes.eigenvalues().unaryExpr([&](double value) { return value > smallest ? 1 / value : 0.0; });
  return modes.eigenvectors() * inverted.asDiagonal() * modes.eigenvectors().transpose();
}

/// Both of a matrix with ones on its diagonal.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& K) {
  const Eigen::Index n = K.rows();
  const Eigen::LLT<Eigen::MatrixXd> factors(K);
  if (factors.info() == Eigen::Success &&
      factors.matrixLLT().diagonal().array().square().minCoeff() > tolerance)
    return factors.solve(Eigen::MatrixXd::Identity(n, n));
  return inverse_of_modes(K, tolerance);
}

/// Matter that hangs on an edge rotates without energy. Such a mode has only the shift as its stiffness; its
/// inverse would swamp all other modes in float32, so it is left out.
Eigen::MatrixXd shifted_inverse(Eigen::MatrixXd K) {
  Eigen::LLT<Eigen::MatrixXd> factors;
  for (double shift = tolerance; shift < 1; shift *= 10) {
    K.diagonal().array() += shift;
    factors.compute(K);
    if (factors.info() != Eigen::Success)
      continue;
    const double stiffer = 100 * shift; // than a mode with the shift as its only stiffness
    if (factors.matrixLLT().diagonal().array().square().minCoeff() < stiffer)
      return inverse_of_modes(K, stiffer);
    break;
  }
  return factors.solve(Eigen::MatrixXd::Identity(K.rows(), K.rows()));
}

} // namespace

List<std::int32_t> CoarsestSolve::Unknowns::numbers(std::size_t field_size) const {
  List<std::int32_t> number(field_size, -1);
  for (std::size_t i = 0; i < place.size(); ++i)
    number[place[i]] = static_cast<std::int32_t>(i);
  return number;
}

bool CoarsestSolve::factor(const std::function<void(const Visit&)>& for_each_entry) {
  std::size_t entries = 0;
  for (std::size_t layer = 0; layer < n_layers(); ++layer)
    entries += static_cast<std::size_t>(size(layer) * (size(layer) + (layer > 0 ? size(layer - 1) : 0)));
  of_matrices_ = {};
  of_matrices_ = Charge(entries * sizeof(double));
  lower_.assign(n_layers(), {});
  beside_.assign(n_layers(), {});
  List<std::size_t> layer_of(unknowns_.place.size());
  for (std::size_t layer = 0; layer < n_layers(); ++layer) {
    lower_[layer] = Eigen::MatrixXd::Zero(size(layer), size(layer));
    beside_[layer] = Eigen::MatrixXd::Zero(size(layer), layer > 0 ? size(layer - 1) : 0);
    std::fill_n(layer_of.begin() + static_cast<std::ptrdiff_t>(unknowns_.first[layer]), size(layer), layer);
  }
  for_each_entry([&](std::size_t row, std::size_t column, double value) {
    const std::size_t layer = layer_of[row], other = layer_of[column];
    const auto i = static_cast<Eigen::Index>(row - unknowns_.first[layer]),
               j = static_cast<Eigen::Index>(column - unknowns_.first[other]);
    if (other == layer)
      lower_[layer](i, j) += value;
    else if (other + 1 == layer)
      beside_[layer](i, j) += value;
  });
  if (n_layers() > 1)
    return factor_layers();
  {
    const Charge while_inverting(4 * entries * sizeof(double));
    invert(std::move(lower_[0]));
  }
  lower_.clear();
  of_matrices_ = {};
  of_matrices_ = Charge(entries * sizeof(float));
  return true;
}

/// Scales the diagonal to 1, so that stiff and soft matter count alike.
void CoarsestSolve::invert(Eigen::MatrixXd K) {
  if (K.rows() == 0)
    return;
  const Eigen::VectorXd unit = K.diagonal().array().rsqrt();
  K = unit.asDiagonal() * (0.5 * (K + K.transpose())).eval() * unit.asDiagonal();
  const Eigen::MatrixXd inverse = unit.asDiagonal() *
                                  (unknowns_.are_rounded ? shifted_inverse(K) : pseudo_inverse(K)) *
                                  unit.asDiagonal();
  inverse_ = (0.5 * (inverse + inverse.transpose())).cast<float>();
}

bool CoarsestSolve::factor_layers() {
  constexpr double nothing = 1e-13; // of a pivot, beside the stiffness of its node
  for (std::size_t layer = 0; layer < n_layers(); ++layer) {
    Eigen::MatrixXd& S = lower_[layer];
    const Eigen::VectorXd diagonal = S.diagonal();
    if (layer > 0 && size(layer) > 0 && size(layer - 1) > 0) {
      beside_[layer] = lower_[layer - 1]
                           .triangularView<Eigen::Lower>()
                           .solve(beside_[layer].transpose())
                           .transpose()
                           .eval();
      S.selfadjointView<Eigen::Lower>().rankUpdate(beside_[layer], -1);
    }
    const Eigen::LLT<Eigen::MatrixXd> factors(S.selfadjointView<Eigen::Lower>());
    if (size(layer) == 0)
      continue;
    if (factors.info() != Eigen::Success)
      return false;
    S = factors.matrixL();
    if ((S.diagonal().array().square() / diagonal.array()).minCoeff() < nothing)
      return false;
  }
  return true;
}

void CoarsestSolve::add_solution(const float* f, float* u) const {
  const auto place = [&](std::size_t layer, Eigen::Index i) {
    return unknowns_.place[unknowns_.first[layer] + static_cast<std::size_t>(i)];
  };
  if (n_layers() == 1) {
    Eigen::VectorXf force(size(0));
    for (Eigen::Index i = 0; i < size(0); ++i)
      force[i] = f[place(0, i)];
    const Eigen::VectorXf found = inverse_ * force;
    for (Eigen::Index i = 0; i < size(0); ++i)
      u[place(0, i)] += found[i];
    return;
  }
  std::vector<Eigen::VectorXd> x(n_layers());
  for (std::size_t layer = 0; layer < n_layers(); ++layer) {
    x[layer].resize(size(layer));
    for (Eigen::Index i = 0; i < size(layer); ++i)
      x[layer][i] = double{f[place(layer, i)]};
    if (layer > 0)
      x[layer].noalias() -= beside_[layer] * x[layer - 1];
    lower_[layer].triangularView<Eigen::Lower>().solveInPlace(x[layer]);
  }
  for (std::size_t layer = n_layers(); layer-- > 0;) {
    if (layer + 1 < n_layers())
      x[layer].noalias() -= beside_[layer + 1].transpose() * x[layer + 1];
    lower_[layer].triangularView<Eigen::Lower>().adjoint().solveInPlace(x[layer]);
    for (Eigen::Index i = 0; i < size(layer); ++i)
      u[place(layer, i)] += static_cast<float>(x[layer][i]);
  }
}

} // namespace maille::deform
