#pragma once
/// `sweep`: the relaxation of Gibson 1995, voxel by voxel. Kept as the oracle of faster relaxers.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Relaxes a body one node after the other, the way Gibson 1995 (Object Deformation) describes it; which of
/// its two systems is scene.relaxation.mode. Handles are those that the limits admit (see admit); prescribed
/// components never move; every component is relaxed for itself.
///
/// **elastic**: starts from the answer of `limits`. Every free component of every node moves to the mean of
/// its linked neighbours' displacements ("the point equidistant from its nearest neighbors", equal weights),
/// clamped into the interval that its links leave it now, so the state is legal after every single move.
/// Where no limit stays active it tends to the solution of the graph Laplacian. This is not elasticity:
/// components do not feel each other. **Where limits stay active it jams**: two nodes that press against the
/// limit between them hold each other, although both would move on together, and where a link is rigid
/// (min = max) always. No single node can move then, so the method has settled, but not at the least energy;
/// `message` counts the groups of nodes that this holds for.
///
/// **deformable**: starts from rest with the handles placed. A node whose links are all within their limits
/// stays (dead zone); another moves as little as its links ask, or to the middle of bounds that contradict
/// each other. Legal within the tolerance when settled, not before.
///
/// A sweep is settled when the estimated remaining error, last change * rho / (1 - rho) with rho the
/// contraction of the last sweeps, is below scene.relaxation.tolerance * largest prescribed displacement. The
/// change of one sweep alone says nothing: it takes O(n^2) sweeps for n nodes along the body.
///
/// @return status done, clamped, budget_reached (sweeps or seconds), interrupted, or refused for loads and
///         moves that are not finite. `iterations` counts sweeps, `residual` is the estimated remaining error
///         over the largest prescribed displacement, 1 while nothing can be said
/// @post   elastic, any status but refused: no link is further outside its limits than rounding
/// Cost        O(links) a sweep, O(n^2) sweeps; 10 to 15 ns a node and component a sweep (measured at
///             39,304 nodes), 390 bytes a node in 3D
/// Repeatable  same input, same bits
/// Source      Gibson 1995, Object Deformation. Departures: the start; displacements in place of positions
///             (the same at equal spacing); settled by an estimate where the source never ends
/// Checked by  tests/deform/relax/sweep_test.cpp
Answer solve_sweep(const Scene& scene, const Control& control = {});

/// The same from another state, into which the handles are placed first.
/// @param limits of `scene`; @param start legal for the elastic mode, any for the deformable one
Answer relax_sweep(const Scene& scene, const LinkLimits& limits, const Displacement& start,
                   const Control& control = {});

} // namespace maille::deform
