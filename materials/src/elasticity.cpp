#include "maille/materials/elasticity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <vector>

namespace maille {

namespace {

/// Smallest scaled determinant; below it a material counts as incompressible: its stiffness would lose nine
/// of the sixteen digits of a double.
constexpr double least_determinant = 1e-9;

constexpr std::array<std::array<int, 2>, 6> voigt_pairs{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

/// Rotation of stress in Voigt order: sigma' = M sigma for sigma' = R sigma R^T (Bond 1943).
Matrix6 stress_turn(const Eigen::Matrix3d& R) {
  Matrix6 M;
  for (int row = 0; row < 6; ++row) {
    const auto [i, j] = voigt_pairs[row];
    for (int column = 0; column < 6; ++column) {
      const auto [p, q] = voigt_pairs[column];
      M(row, column) = p == q ? R(i, p) * R(j, q) : R(i, p) * R(j, q) + R(i, q) * R(j, p);
    }
  }
  return M;
}

template<typename Matrix>
Matrix symmetric_part(const Matrix& matrix) {
  return 0.5 * (matrix + matrix.transpose());
}

/// Rows and columns xx, yy, xy.
Eigen::Matrix3d plane_block(const Matrix6& matrix) {
  constexpr std::array<int, 3> kept{0, 1, 5};
  Eigen::Matrix3d block;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      block(row, column) = matrix(kept[row], kept[column]);
    }
  }
  return block;
}

Matrix6 inverse(const Matrix6& matrix) {
  return symmetric_part<Matrix6>(matrix.llt().solve(Matrix6::Identity()));
}

void require_positive(std::vector<std::string>& violated, const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    violated.push_back(fmt::format("{} > 0  ({:.6g} > 0)", name, value));
  }
}

void require_poisson_below(std::vector<std::string>& violated, int i, int j, double poisson_ratio,
                           double ratio_of_moduli) {
  const double bound = std::sqrt(ratio_of_moduli);
  if (!(std::abs(poisson_ratio) < bound)) {
    violated.push_back(fmt::format("|nu{0}{1}| < sqrt(E{0}/E{1})  ({2:.6g} < {3:.6g})", i, j,
                                   std::abs(poisson_ratio), bound));
  }
}

} // namespace

ElasticConstants ElasticConstants::isotropic(double youngs_modulus, double poisson_ratio) {
  const double G = youngs_modulus / (2 * (1 + poisson_ratio));
  return {
      {youngs_modulus, youngs_modulus, youngs_modulus}, poisson_ratio, poisson_ratio, poisson_ratio, G, G, G};
}

ElasticConstants ElasticConstants::transversely_isotropic(double E_fibre, double E_cross, double G_fibre,
                                                          double nu_fibre, double nu_cross) {
  const double G_cross = E_cross / (2 * (1 + nu_cross));
  return {{E_fibre, E_cross, E_cross}, nu_fibre, nu_fibre, nu_cross, G_fibre, G_fibre, G_cross};
}

bool ElasticConstants::is_isotropic() const {
  constexpr double tolerance = 1e-12;
  const auto near = [](double a, double b, double scale) { return std::abs(a - b) <= tolerance * scale; };
  const double E = youngs_modulus[0];
  const double G = E / (2 * (1 + nu12));
  return near(youngs_modulus[1], E, E) && near(youngs_modulus[2], E, E) && near(nu13, nu12, 1) &&
         near(nu23, nu12, 1) && near(G12, G, G) && near(G13, G, G) && near(G23, G, G);
}

std::vector<std::string> violated_inequalities(const ElasticConstants& constants) {
  const auto& [E, nu12, nu13, nu23, G12, G13, G23] = constants;
  std::vector<std::string> violated;
  require_positive(violated, "E1", E[0]);
  require_positive(violated, "E2", E[1]);
  require_positive(violated, "E3", E[2]);
  const bool moduli_are_positive = violated.empty();
  require_positive(violated, "G12", G12);
  require_positive(violated, "G13", G13);
  require_positive(violated, "G23", G23);
  if (!moduli_are_positive) {
    return violated; // the other bounds are ratios of these moduli
  }

  const std::size_t before = violated.size();
  require_poisson_below(violated, 1, 2, nu12, E[0] / E[1]);
  require_poisson_below(violated, 1, 3, nu13, E[0] / E[2]);
  require_poisson_below(violated, 2, 3, nu23, E[1] / E[2]);
  if (violated.size() > before) {
    return violated;
  }
  const double nu21 = nu12 * E[1] / E[0];
  const double nu31 = nu13 * E[2] / E[0];
  const double nu32 = nu23 * E[2] / E[1];
  const double determinant = 1 - nu12 * nu21 - nu23 * nu32 - nu31 * nu13 - 2 * nu21 * nu32 * nu13;
  if (!(determinant > least_determinant)) {
    violated.push_back(fmt::format("1 - nu12 nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 nu32 nu13 > {0:.0e}  "
                                   "({1:.6g} > {0:.0e})",
                                   least_determinant, determinant));
  }
  return violated;
}

Matrix6 compliance(const ElasticConstants& constants) {
  const auto& [E, nu12, nu13, nu23, G12, G13, G23] = constants;
  Matrix6 S = Matrix6::Zero();
  S(0, 0) = 1 / E[0];
  S(1, 1) = 1 / E[1];
  S(2, 2) = 1 / E[2];
  S(0, 1) = S(1, 0) = -nu12 / E[0];
  S(0, 2) = S(2, 0) = -nu13 / E[0];
  S(1, 2) = S(2, 1) = -nu23 / E[1];
  S(3, 3) = 1 / G23;
  S(4, 4) = 1 / G13;
  S(5, 5) = 1 / G12;
  return S;
}

Matrix6 stiffness(const ElasticConstants& constants) {
  assert(violated_inequalities(constants).empty());
  return inverse(compliance(constants));
}

Eigen::Matrix3d axes_from_fibre(const Eigen::Vector3d& fibre) {
  const Eigen::Vector3d f = fibre.stableNormalized();
  // Rodrigues' formula for the rotation about e_x x f, in terms of 1 - f_x and a unit vector across e_x,
  // which avoids cancellation as the fibre approaches -e_x.
  const double across = std::hypot(f.y(), f.z());
  const Eigen::Vector2d c =
      across > 0 ? Eigen::Vector2d(f.y() / across, f.z() / across) : Eigen::Vector2d(1, 0);
  const double k = f.x() < 0 ? 1 - f.x() : across * across / (1 + f.x());
  Eigen::Matrix3d axes;
  axes << f.x(), -f.y(), -f.z(),                        //
      f.y(), 1 - k * c.x() * c.x(), -k * c.x() * c.y(), //
      f.z(), -k * c.x() * c.y(), 1 - k * c.y() * c.y();
  return axes;
}

Matrix6 turned(const Matrix6& C, const Eigen::Matrix3d& axes) {
  const Matrix6 M = stress_turn(axes);
  return symmetric_part<Matrix6>(M * C * M.transpose());
}

Matrix6 turned_compliance(const Matrix6& S, const Eigen::Matrix3d& axes) {
  const Matrix6 M_inverse = stress_turn(axes.transpose());
  return symmetric_part<Matrix6>(M_inverse.transpose() * S * M_inverse);
}

Eigen::MatrixXd reduced_stiffness(const Matrix6& C, int dimension, PlaneAssumption plane) {
  assert(dimension >= 1 && dimension <= 3);
  if (dimension == 3) {
    return C;
  }
  if (dimension == 2 && plane == PlaneAssumption::strain) {
    return plane_block(C);
  }
  const Matrix6 S = inverse(C);
  if (dimension == 1) {
    return Eigen::MatrixXd::Constant(1, 1, 1 / S(0, 0));
  }
  const Eigen::Matrix3d Q = plane_block(S).llt().solve(Eigen::Matrix3d::Identity());
  return symmetric_part<Eigen::Matrix3d>(Q);
}

std::array<double, 3> poisson_ratios_at(const std::array<double, 3>& youngs_modulus, double bulk_modulus) {
  const auto& E = youngs_modulus;
  // With s_ij = nu_ij / E_i: s_12 + s_13 = r_1, s_12 + s_23 = r_2, s_13 + s_23 = r_3.
  const double give = 1 / (3 * bulk_modulus);
  const double r1 = 1 / E[0] - give, r2 = 1 / E[1] - give, r3 = 1 / E[2] - give;
  return {E[0] * (r1 + r2 - r3) / 2, E[0] * (r1 + r3 - r2) / 2, E[1] * (r2 + r3 - r1) / 2};
}

void release_free_directions(const Matrix6& C, const Vector6& active, int dimension, PlaneAssumption plane,
                             Vector6& strain) {
  std::vector<int> free;
  if (dimension == 1)
    free = {1, 2, 3, 4, 5};
  else if (dimension == 2 && plane == PlaneAssumption::stress)
    free = {2, 3, 4};
  if (free.empty())
    return;
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd block(n, n);
  Eigen::VectorXd load(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = free[i];
    load(i) = -C.row(row).dot(strain) - active(row);
    for (Eigen::Index j = 0; j < n; ++j)
      block(i, j) = C(row, free[j]);
  }
  const Eigen::VectorXd released = block.partialPivLu().solve(load);
  for (Eigen::Index i = 0; i < n; ++i)
    strain(free[i]) += released(i);
}

} // namespace maille
