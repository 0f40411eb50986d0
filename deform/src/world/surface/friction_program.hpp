#pragma once
/// Contact forces with Coulomb friction from the compliance of the bodies.

#include <Eigen/Core>

#include <span>
#include <vector>

namespace maille::deform {

/// Rows of one contact with friction.
struct FrictionRows {
  Eigen::Index normal;
  Eigen::Index first; ///< along the first tangent; the second, in three dimensions, is the next
  int n = 1;          ///< tangents
};

/// Solves for normal forces and pulls as contact_forces(), and for a tangential force at each contact: the
/// contact sticks (tangential gap 0) with at most `friction` times its normal force, or slips against exactly
/// that force.
///
/// Newton's method on the states (open, stick, slip) and slip directions of contacts. Slip forces are
/// proportional to the normal forces in the same system.
///
/// Source  Alart and Curnier 1991 (Comput. Methods Appl. Mech. Eng. 92); Hueber and others 2008
/// @param compliance symmetric, positive definite [m/N] @param gap0 [m]; in tangential rows the displacement
///        of a contact from its grip
/// @param may_pull by row; 0 for normals, ignored for tangents
/// @param contacts contacts with friction; other contacts have no tangential rows
/// @return forces [N]; the last iterate if the states did not converge in 200 rounds
Eigen::VectorXd frictional_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                                  const std::vector<char>& may_pull, std::vector<char>& active,
                                  std::span<const FrictionRows> contacts, double friction);

} // namespace maille::deform
