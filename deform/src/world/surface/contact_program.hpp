#pragma once
/// Forces of contacts, from how the bodies give way to them.

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Sets of contacts that are tried without fewer wrong ones before another method takes over. Fewer give up
/// where two edges meet; more cost a factorisation each.
inline constexpr int patience = 5;

/// Finds forces so that gap = gap0 + W force is at least 0 wherever a force may only press, with force >= 0
/// and force * gap = 0 there, and is 0 where it may pull too.
///
/// An active set: forces of which nothing is asked are 0, the others follow from a Cholesky factor; those
/// that come to pull leave it, and contacts whose gap would be less than 0 come in, all at once as long as
/// fewer and fewer are wrong. Where they are not, as where faces lie on faces and many contacts say the same,
/// by an interior point, to 1e-12 of the product of largest force and gap.
///
/// Source  Portugal, Judice and Vicente 1994 (Math. Comp. 63), block principal pivoting; Mehrotra 1992 (SIAM
///         J. Optim. 2), interior points
/// @param compliance symmetric, positive definite [m/N] @param gap0 [m]
/// @param may_pull by contact @param active where to begin; then the active set
/// @return forces [N]; what was found last where 200 sets were not enough
Eigen::VectorXd contact_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                               const std::vector<char>& may_pull, std::vector<char>& active);

} // namespace maille::deform
