#pragma once
/// `sweep`: the relaxation of Gibson 1995, voxel by voxel. Kept as the oracle of faster relaxers.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Relaxes a body one node after the other, as Gibson 1995 (Object Deformation) describes it; handles are
/// clipped (see admit). **elastic**: from the answer of `limits`, every free component of every node moves to
/// the mean of its linked neighbours, clamped to what its links leave it; feasible after every move. Active
/// limits may block groups of nodes; `message` counts these. **deformable**: from rest with the handles
/// placed, a node with links outside their limits moves as little as they ask; feasible once converged.
///
/// @return status done, clamped, budget_reached (sweeps or seconds), interrupted, or refused for loads and
///         moves that are not finite. `iterations` counts sweeps; `residual`, with scene.relaxation.tolerance
///         as its goal: last change * rho / (1 - rho), rho the contraction of the last sweeps, over the
///         largest prescribed displacement, 1 while nothing can be said
/// Cost        O(links) a sweep, O(n^2) sweeps for n nodes along the body; 390 bytes a node in 3D
/// Repeatable  same input, same bits
/// Source      Gibson 1995; docs/theory.md, section 2. Departures: the start; displacements in place of
///             positions (the same at equal spacing); ended by an estimate where the source never ends
/// Checked by  tests/deform/elastic/sweep_test.cpp
Answer solve_sweep(const Scene& scene, const Control& control = {});

/// The same from another state, into which the handles are placed first.
/// @param limits of `scene`; @param start legal for the elastic mode, any for the deformable one
Answer relax_sweep(const Scene& scene, const LinkLimits& limits, const Displacement& start,
                   const Control& control = {});

} // namespace maille::deform
