#pragma once
/// Contact forces from the compliance of the bodies.

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Active sets without fewer violations before the method changes. A smaller value gives up where two edges
/// meet; a larger one costs a factorisation per set.
inline constexpr int patience = 5;

/// Solves gap = gap0 + W force with gap >= 0, force >= 0 and force * gap = 0 at unilateral contacts, and gap
/// = 0 at contacts that may pull.
///
/// Active-set method: inactive forces are 0, active ones follow from a Cholesky factor. Contacts that pull
/// become inactive and contacts with negative gaps become active, all at once as long as the number of
/// violations decreases. If it stagnates, as for redundant contacts between plane faces, an interior-point
/// method takes over, to 1e-12 of the product of largest force and gap.
///
/// Source  Portugal, Judice and Vicente 1994 (Math. Comp. 63), block principal pivoting; Mehrotra 1992 (SIAM
///         J. Optim. 2), interior points
/// @param compliance symmetric, positive definite [m/N] @param gap0 [m]
/// @param may_pull by contact @param[in,out] active initial, then final active set
/// @return forces [N]; the last iterate if 200 sets were not enough
Eigen::VectorXd contact_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                               const std::vector<char>& may_pull, std::vector<char>& active);

} // namespace maille::deform
