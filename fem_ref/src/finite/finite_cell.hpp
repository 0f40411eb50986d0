#pragma once
/// A cell at large strain: nodal forces and tangent, total Lagrangian.
///
/// Displacements u are Q1 or Q2; dilatation theta and pressure p are constant in a cell (Q1-P0) or linear
/// (Q2-P1), and discontinuous between cells. Equilibrium is a stationary point of
///
///   sum_q w_q (W(F_q, theta_q) + p_q (J_q - theta_q)),   J_q = det F_q
///
/// in u, theta and p, summed over the points q of a Gauss rule. Newton's method for all three: with M the
/// projection onto the fields, dtheta = M (J + dJ) - theta and p = M (linearised dW/dtheta) follow cell by
/// cell from du, so only du is solved for; the tangent is symmetric. At equilibrium theta = M J, and the
/// energy depends on u only. Keeping theta and p as states allows large steps: with theta = M J throughout,
/// the error of a step in J times the bulk modulus would act as a pressure in the next tangent.
/// Plane stress has no theta: Newton's method at every point sets F13, F23 and F33 so that their stresses
/// vanish, and J is free.
/// Source  Simo, Taylor, Pister 1985 (Comput. Methods Appl. Mech. Eng. 51); Q2-P1: Brezzi, Fortin 1991

#include "discretization/element.hpp"
#include "finite/energy.hpp"

#include <vector>

namespace maille::fem_ref {

/// dim 2 or 3; one object serves all cells of a scene, which are congruent.
template<int dim>
class FiniteCell {
public:
  FiniteCell(const Element<dim>& element, const Vec3& spacing, PlaneAssumption plane);

  struct Response {
    double strain_energy = 0;  ///< [J]
    Eigen::VectorXd force;     ///< gradient of the total energy [N], order of Element
    Eigen::MatrixXd stiffness; ///< its derivative [N/m]
  };
  /// Theta and pressure at the points, and the state that they were linearised at. Empty: at rest.
  struct Fields {
    Eigen::VectorXd gradient;             ///< gradient of u, points x entries of F
    Eigen::VectorXd theta, pressure, gap; ///< [1], [Pa], M J - theta
    Eigen::MatrixXd cofactor;             ///< dJ/dF, points x entries of F
    Eigen::MatrixXd by_theta;             ///< d2W/dtheta dF, d2W/dtheta2, dW/dtheta; one row per point
  };
  /// @param u displacement of the nodes [m] @param fields those of the last u; updated @return nothing if the
  /// cell is inverted at a point of the Gauss rule (3 points per axis Q2, 2 Q1), or plane stress has no
  /// equilibrium there
  std::optional<Response> respond(const Matter& matter, const Eigen::VectorXd& u, Fields& fields) const;
  /// Biot strain of the mean gradient, its volume scaled to the mean of theta, which determines the pressure;
  /// VTK's order.
  std::array<double, 6> mean_strain(const Fields& fields) const;

private:
  static constexpr int n_entries = dim * dim, n_rows = n_entries + 1; ///< at a point: of F; with theta

  void update(const Eigen::VectorXd& gradient, Fields& fields) const;
  bool find_director(const Matter& matter, Eigen::Matrix3d& F, PointResponse& response) const;

  bool is_plane_stress_;
  std::vector<double> weights_; ///< times volume [m^dim]
  Eigen::MatrixXd gradients_;   ///< points x entries of F, unknowns [1/m]
  Eigen::MatrixXd projection_;  ///< M
};

} // namespace maille::fem_ref
