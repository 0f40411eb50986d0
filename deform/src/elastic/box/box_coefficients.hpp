#pragma once
/// The lattice operator of a box of one material as sums of products of operators along its axes.

#include "maille/scene/grid.hpp"

#include <Eigen/Core>

namespace maille::deform {

/// Along one axis, a cell of length h between two nodes with values u, v adds to what pulls at them
///
///   L, link:  (u - v) H / h, (v - u) H / h      M, mass:  (u + v) h / H at both
///   D, difference:  v - u at both               T, its transpose:  -(u + v), u + v
///   E, share:  u h / (2 H), v h / (2 H)
///
/// where H is the regular spacing of the level. The operator of LatticeElasticity is then, for the force
/// along i and the displacement along j,
///
///   sum_a strain[i][a][j][a] L_a M_b M_c  +  sum over a != b of strain[i][a][j][b] T_a D_b M_c
///
/// with edge[i] L_i E_b E_c and twist_self[i] M_i L_b L_c added where i = j, and twist_pair[c] T_j D_i L_c
/// where i != j and c is the third axis. (Of irregular cells the difference across the third axis is thus
/// weighed by H / h: they occur on coarse levels only, which need not be exact.)
///
/// Source  docs/theory.md, section 3 (LAT)
struct BoxCoefficients {
  double strain[3][3][3][3] = {}; ///< [i][a][j][b], of d_a u_i times d_b u_j
  double edge[3] = {};
  double twist_self[3] = {};
  double twist_pair[3] = {};
  bool is_aligned = true; ///< normal strains and the three shears are not coupled with one another

  BoxCoefficients() = default;
  /// @param C 6 x 6 stiffness, order 11 22 33 23 13 12 [Pa]; @param spacing H along the axes [m]; @param unit
  /// what the coefficients are counted in [N/m]
  BoxCoefficients(const Eigen::Matrix<double, 6, 6>& C, const Vec3& spacing, double unit);
};

} // namespace maille::deform
