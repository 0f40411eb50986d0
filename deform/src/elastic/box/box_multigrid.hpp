#pragma once
/// Multigrid for elasticity on a box, as a preconditioner.

#include "elastic/box/box_level.hpp"
#include "maille/scene/answer.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// The operator itself on coarser grids, linear interpolation. See PlaneMultigrid.
class BoxMultigrid : public PlaneMultigrid<BoxLevel> {
public:
  /// @param steps of relaxation before and after each coarser level, 2 or more
  BoxMultigrid(std::unique_ptr<BoxLevel> finest, int steps, ThreadTeam& team)
      : PlaneMultigrid(with_relaxation(std::move(finest), steps), team) {}

  /// Stiffens links of the body, and of its coarser levels as they follow from it: see BoxLevel. Those of
  /// before are so no longer.
  void set_penalties(std::vector<PenaltyLink> links);
  /// K u on plane z of the body in the unit of its stiffness, [component][node], until the thread's next
  /// plane.
  const double* forces_of_plane(const Displacement& u, int z) const;
  /// Nodes in a plane of the body.
  std::size_t in_plane() const {
    return static_cast<std::size_t>(finest().nodes()[0]) * static_cast<std::size_t>(finest().nodes()[1]);
  }

private:
  static std::unique_ptr<BoxLevel> with_relaxation(std::unique_ptr<BoxLevel> finest, int steps) {
    finest->set_relaxation(steps);
    return finest;
  }
};

} // namespace maille::deform
