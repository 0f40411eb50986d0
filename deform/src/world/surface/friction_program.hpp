#pragma once
/// Forces of contacts with Coulomb friction, from how the bodies give way to them.

#include <Eigen/Core>

#include <span>
#include <vector>

namespace maille::deform {

/// The rows of one contact that friction acts on.
struct FrictionRows {
  Eigen::Index normal;
  Eigen::Index first; ///< along the first tangent; the second, in three dimensions, is the next
  int n = 1;          ///< tangents
};

/// Finds forces as contact_forces does for the rows of normals and of pulls, and for each contact a force
/// along its tangents, so that it stays where it is (gap 0) with at most `friction` times its normal force,
/// or slips against just that.
///
/// Newton's method on which contacts press, stick and slip, and in which direction; forces of slip go with
/// the normal ones in the same system.
///
/// Source  Alart and Curnier 1991 (Comput. Methods Appl. Mech. Eng. 92); Hueber and others 2008
/// @param compliance symmetric, positive definite [m/N] @param gap0 [m]: of tangents, how far a contact has
///        come from where it holds
/// @param may_pull by row; 0 for normals, ignored for tangents
/// @param contacts those that rub; other rows have no tangents
/// @return forces [N]; what was found last where the states did not settle in 200 rounds
Eigen::VectorXd frictional_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                                  const std::vector<char>& may_pull, std::vector<char>& active,
                                  std::span<const FrictionRows> contacts, double friction);

} // namespace maille::deform
