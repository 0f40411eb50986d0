#pragma once
/// `coupled` where the scene asks for blocks, whose strains are measured in a frame for every cell.

#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"

namespace maille::deform {

struct ProjectionInBlocks {
  bool is_feasible = false; ///< largest_violation_in_blocks is 0 but for rounding
  int sweeps = 0;
  std::int64_t bytes = 0; ///< held meanwhile
};

/// Moves nodes where they are free, until no link breaks its limits in the mean frame of the cells that it
/// borders.
///
/// Frames turn with the state and tie the components together, so there is no closed form as there is in the
/// object's frame (see projection): links that are outside are brought within one after another, forward and
/// backward through the body, half by either end (Jakobsen 2001), with frames found anew every few sweeps. A
/// link is brought into its range narrowed by a hundredth of it at either end, so that sweeps that converge
/// end with every link within, after finitely many. Links that have no room (low = high) come to within
/// `rounding` of a link's length.
///
/// @param u     finite; prescribed components are in their places and stay there
/// @return      not feasible where sweeps did not converge: as a rule because what is prescribed asks for
/// more than the limits grant
/// Cost         a microsecond a cell each time that frames are found, some 20 ns a link and sweep
/// Checked by   tests/deform/elastic/coupled_blocks_test.cpp
ProjectionInBlocks project_in_blocks(const Scene& scene, const LinkLimits& limits,
                                     const std::vector<Prescribed>& prescribed, Displacement& u);

/// By which a link may break its limits and be called feasible, over its rest length.
constexpr double rounding_in_blocks = 1e-9;

/// @pre 2D or 3D, and no rigid motion is left. Where the scene's limits bind (see Scene::limits_bind_coupled)
/// the elastic answer is projected at the end, each link in the mean frame of the cells around; where no such
/// state is found, moves and loads are cut back by bisection (status clamped), and the message says to what
/// share.
Answer solve_coupled_in_blocks(const Scene& scene, const Control& control);

} // namespace maille::deform
