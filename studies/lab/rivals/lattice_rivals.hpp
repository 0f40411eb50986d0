#pragma once
/// A baseline for relaxation: the way in which games and surgery simulators deform a lattice of springs,
/// given the same body and the same time.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace maille::lab {

/// What a rival came to in its time.
struct RivalResult {
  Displacement displacement;   ///< empty where the rival cannot carry the scene; `note` says why
  std::int64_t iterations = 0; ///< time steps of ten iterations
  double seconds = 0;          ///< of iterating, which is what the budget limits
  double seconds_of_setup = 0; ///< lattice and arrays, before the first iteration
  std::string note;            ///< what the rival cannot represent, or why it did nothing
};

/// Bullet's classic soft body (btSoftBody) of the same nodes and links: 10 position iterations a time step of
/// 1/60 s, damping 0.1, the setting that came to rest soonest of those tried. Bullet has no elastic moduli: a
/// link's linear stiffness, 0 to 1, is that of its spring over the stiffest. Links are in the order of their
/// directions: node by node, Bullet is slower and rests further from elasticity. The body is stepped without
/// a world around it, which saves Bullet the time that a world takes to find no collisions.
///
/// Carries holds and moves of whole nodes only, and no loads, for it would not know how far to give way.
///
/// @param seconds_budget for stepping; at least one step is done
/// @return nothing where Maille was built without libbullet
/// Checked by  tests/studies/lattice_rivals_test.cpp
std::optional<RivalResult> relax_by_bullet(const Scene& scene, double seconds_budget);

} // namespace maille::lab
