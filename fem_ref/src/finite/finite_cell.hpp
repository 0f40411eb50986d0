#pragma once
/// A cell of large strain: forces and tangent of its nodes, in total Lagrange.
///
/// Displacements are Q1 or Q2; the dilatation theta is the projection of J = det F onto the constants (Q1-P0)
/// or onto the linear polynomials of the cell (Q2-P1), in L2 at rest. Pressure and theta of the three-field
/// principle are thereby condensed exactly: with theta = M J at the points of the Gauss rule, M the
/// projection, the energy sum_q w_q W(F_q, theta_q) depends on displacements alone. Its gradient is
///
///   sum_q w_q (dW/dF_q : dF_q + dW/dtheta_q dtheta_q),   dtheta = M dJ,   dJ_q = cof F_q : dF_q
///
/// and its second derivative has, beside W's own, sum_r p_r d2J_r with p = M^T (w dW/dtheta).
/// Plane stress has no theta: F13, F23 and F33 are where they have no stress, found by Newton's method at
/// every point, so that J is free.
/// Source  Simo, Taylor, Pister 1985 (Comput. Methods Appl. Mech. Eng. 51); Q2-P1: Brezzi, Fortin 1991

#include "discretization/element.hpp"
#include "finite/energy.hpp"

#include <vector>

namespace maille::fem_ref {

/// dim 2 or 3; all cells of a scene are congruent, and are served by one of these.
template<int dim>
class FiniteCell {
public:
  FiniteCell(const Element<dim>& element, const Vec3& spacing, PlaneAssumption plane);

  struct Response {
    double strain_energy = 0;  ///< [J]
    Eigen::VectorXd force;     ///< gradient of all energy [N], order of Element
    Eigen::MatrixXd stiffness; ///< its derivative [N/m]
  };
  /// @param u displacement of the nodes [m]
  /// @return nothing where the cell is turned inside out at a point of the Gauss rule (3 points per axis Q2,
  /// 2 Q1), or plane stress has no balance there
  std::optional<Response> respond(const Matter& matter, const Eigen::VectorXd& u) const;

private:
  static constexpr int n_entries = dim * dim, n_rows = n_entries + 1; ///< at a point: of F, and theta

  bool find_director(const Matter& matter, Eigen::Matrix3d& F, PointResponse& response) const;

  bool is_plane_stress_;
  std::vector<double> weights_; ///< times volume [m^dim]
  Eigen::MatrixXd gradients_;   ///< points x entries of F, unknowns [1/m]
  Eigen::MatrixXd projection_;  ///< M
};

} // namespace maille::fem_ref
