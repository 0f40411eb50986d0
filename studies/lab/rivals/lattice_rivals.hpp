#pragma once
/// Baselines for relaxation: two ways in which games and surgery simulators deform a lattice of springs, each
/// given the same body and the same time.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace maille::lab {

/// What a rival came to in its time.
struct RivalResult {
  Displacement displacement;   ///< empty where the rival cannot carry the scene; `note` says why
  std::int64_t iterations = 0; ///< time steps: of XPBD one iteration each, of Bullet ten
  double seconds = 0;          ///< of iterating, which is what the budget limits
  double seconds_of_setup = 0; ///< lattice and arrays, before the first iteration
  /// Force out of balance at the free nodes over the force at the prescribed ones, both of the springs of
  /// SpringLattice (whose balance is what XPBD is after; Bullet knows only ratios of stiffness) [1]
  double residual = 0;
  std::string note; ///< what the rival cannot represent, or why it did nothing
};

/// Extended position-based dynamics on the springs of SpringLattice, in float32, on one thread, until it is
/// at rest.
///
/// As published, and three things that let it come to rest as fast as we know how to:
/// **One iteration a time step**, as small steps converge faster than many iterations (Macklin et al. 2019).
/// **Multipliers are kept** from step to step and their forces applied before each. From multipliers of zero,
/// one iteration comes to rest where constraints solved one after the other cancel, which depends on their
/// order and on the time step (measured: 0.7 % to 9 % from the springs' balance on a poke). Kept, the rest
/// state is the balance itself.
/// **Velocities as in Nesterov's method**: step k after the last stop keeps k / (k + 3) of them, and they
/// stop where they point uphill. So iterations grow like the number of nodes along a side, not its square,
/// and nothing needs tuning.
///
/// Masses mean nothing at rest. Each is half the sum of the stiffnesses at its node, so that soft and stiff
/// parts settle together; they are doubled where motion does not fade, as it may not once springs are several
/// times as long as at rest.
///
/// Constraints that share no node are solved together, up to 16 at a time: those of a direction that start in
/// one plane, or in every second row of it. Planes in the order of the grid, to and fro: Gauss-Seidel that
/// reads memory once an iteration.
///
/// Holds and moves of single components, tractions and gravity are carried. Distances are true ones: the
/// springs turn with the body, and stiffen and soften where linear elasticity does not: moves of more than a
/// fraction of the spacing, from node to node, have another answer. Starts from rest with the moves made at
/// once.
///
/// @param seconds_budget for iterating; at least one iteration is done
/// @return `note` names what SpringLattice cannot represent, or says that the state is not finite
/// Cost        14 ns a node and iteration at 33^3 nodes, 18 at 65^3 (512-bit vectors); some 5 iterations per
///             node along a side to 1 % of the rest state
/// Memory      120 bytes a grid point, 132 with loads
/// Repeatable  for a number of iterations on one kind of vector; a budget makes that number a matter of the
///             machine
/// Source      Macklin, Mueller, Chentanez 2016 (Motion in Games), algorithm 1; Macklin et al. 2019, "Small
///             steps in physics simulation" (SCA); O'Donoghue and Candes 2015, section 3.2 (when to stop)
/// Checked by  tests/studies/lattice_rivals_test.cpp
RivalResult relax_by_xpbd(const Scene& scene, double seconds_budget);

/// The same for a number of iterations, whatever the time. @param iterations > 0
RivalResult relax_by_xpbd_steps(const Scene& scene, std::int64_t iterations);

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
