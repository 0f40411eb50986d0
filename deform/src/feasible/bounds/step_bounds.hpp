#pragma once
/// Limits that are the same for all links along an axis, and the shortest paths that they add up to.

#include "maille/scene/link_limits.hpp"

#include <array>

namespace maille::deform {

/// For one displacement component: low[a] <= u_j - u_i <= high[a] for every link i -> j along axis a [m];
/// zero along axes that the grid does not have.
struct StepBounds {
  Vec3 low{}, high{};
};

/// What paths add up to, away from a handle whose displacement is given: the least displacement that it
/// leaves to others (raising: L_i = p - d(i, handle)), or the greatest (U_i = p + d(handle, i)).
enum class Side { least, greatest };

/// How much the bound changes per link, in the direction of the axis (ahead) and against it (behind); a bound
/// at offset o is p + sum_a o_a * (o_a >= 0 ? ahead[a] : behind[a]) on a box (docs/theory.md, Theorem 2).
struct Slopes {
  Vec3 ahead{}, behind{};

  Slopes(const StepBounds& bounds, Side side)
      : ahead(side == Side::least ? bounds.low : bounds.high),
        behind(side == Side::least ? bounds.high : bounds.low) {}
  double along(std::size_t axis, int offset) const {
    return offset * (offset >= 0 ? ahead[axis] : behind[axis]);
  }
};

/// Per component. @pre limits.is_homogeneous()
std::array<StepBounds, 3> step_bounds(const Scene& scene, const LinkLimits& limits);

/// The largest d(i, j) + d(j, i) of two nodes of a full grid: how much their displacements may differ in all.
double slack_range(const StepBounds& bounds, const Index3& nodes);

/// True if every node of the body is joined to `from` by a lattice path of links that never turns back along
/// any axis, so that closed forms hold although the body does not fill its grid. O(nodes) time, two slabs.
bool reaches_all_monotonely(const Specimen& body, const Index3& from);

} // namespace maille::deform
